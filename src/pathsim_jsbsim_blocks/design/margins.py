"""Stability margins of loops from their frequency responses, many at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Margins:
    """Margins of loops broken at their actuator, arrays of shape (loops,)."""

    crossover: np.ndarray  # highest frequency at which the gain is 1, rad/s; 0 without one
    gain: np.ndarray  # dB, the smaller of those up and down; infinite without a phase crossing
    phase: np.ndarray  # deg, the smallest; infinite without a crossover
    Ms: np.ndarray  # largest sensitivity |1 / (1 + L)|
    Ms_delayed: np.ndarray  # the same with 50 ms of delay more


EXTRA_DELAY = 0.05  # s


def margins(omega: np.ndarray, L: np.ndarray) -> Margins:
    """Margins of the loops ``L``, shape (loops, frequencies), with negative feedback."""
    size = np.abs(L)
    phase = np.unwrap(np.angle(L), axis=1)
    log = np.log(np.maximum(size, 1e-300))
    # |L| = 1
    crosses = (log[:, :-1] > 0.0) != (log[:, 1:] > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(crosses, log[:, :-1] / (log[:, :-1] - log[:, 1:]), 0.0)
    there = phase[:, :-1] + share * np.diff(phase, axis=1)
    away = np.degrees(np.abs(np.mod(there, 2 * np.pi) - np.pi))
    pm = np.where(crosses, away, np.inf).min(axis=1)
    at = np.exp(np.log(omega[:-1]) + share * np.diff(np.log(omega)))
    crossover = np.where(crosses, at, 0.0).max(axis=1)
    # phase of an odd multiple of 180 deg
    turns = np.floor((phase + np.pi) / (2 * np.pi))
    crosses = turns[:, :-1] != turns[:, 1:]
    edge = (np.maximum(turns[:, :-1], turns[:, 1:]) * 2 - 1) * np.pi
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(crosses, (edge - phase[:, :-1]) / np.diff(phase, axis=1), 0.0)
    there = log[:, :-1] + share * np.diff(log, axis=1)
    gm = np.where(crosses, np.abs(there), np.inf).min(axis=1) * 20 / np.log(10)
    late = L * np.exp(-1j * omega * EXTRA_DELAY)
    return Margins(
        crossover, gm, pm, 1 / np.abs(1 + L).min(axis=1), 1 / np.abs(1 + late).min(axis=1)
    )
