"""Dryden turbulence against its analytic spectra, variances and correlations, and against scipy."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope
from scipy.integrate import quad
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import welch

from pathsim_jsbsim_blocks import DrydenTurbulence, ParameterError
from pathsim_jsbsim_blocks.wind import Dryden, dryden_field
from pathsim_jsbsim_blocks.wind.turbulence import WIND_20FT

DATA = Path(__file__).parents[1] / "data"
NAMES = ("u", "v", "w", "p", "q", "r")
SPAN = 94.7  # ft, a 737

# height in ft, airspeed in ft/s, severity: both forms of the specification
LOW, MEDIUM = (200.0, 230.0, "severe"), (10000.0, 500.0, "moderate")


def spectra(h, V, severity):
    """The specification's one-sided spectra over the angular frequency, written down once more."""
    if h <= 1000:
        sigma_w, L_w = 0.1 * WIND_20FT[severity] * 1.687810, h  # ft/s in a knot
        sigma_u, L_u = (
            sigma_w / (0.177 + 0.000823 * h) ** 0.4,
            h / (0.177 + 0.000823 * h) ** 1.2,
        )
    else:
        # figure 7 for moderate turbulence: 10.1 at 7500 ft, 8.0 at 15,000 ft
        sigma_u = sigma_w = 10.1 + (h - 7500) / 7500 * (8.0 - 10.1)
        L_u = L_w = 1750.0

    def u(w):
        return sigma_u**2 * 2 * L_u / (math.pi * V) / (1 + (L_u * w / V) ** 2)

    def across(sigma, L):
        return lambda w: (
            sigma**2
            * (L / (math.pi * V))
            * ((1 + 3 * (L * w / V) ** 2) / (1 + (L * w / V) ** 2) ** 2)
        )

    def p(w):
        return (
            sigma_w**2
            / (V * L_w)
            * (0.8 * (math.pi * L_w / (4 * SPAN)) ** (1 / 3))
            / (1 + (4 * SPAN * w / (math.pi * V)) ** 2)
        )

    def rate(phi, factor):
        return lambda w: (w / V) ** 2 / (1 + (factor * SPAN * w / (math.pi * V)) ** 2) * phi(w)

    v, w = across(sigma_u, L_u), across(sigma_w, L_w)
    return {"u": u, "v": v, "w": w, "p": p, "q": rate(w, 4), "r": rate(v, 3)}


def recorded(case, T, flights, samples):
    """Turbulence of many flights at once: quantity by sample by flight."""
    h, V, severity = case
    dryden = Dryden(T, span=SPAN, severity=severity)
    random = np.random.default_rng(1)
    state = dryden.start(h, random.standard_normal((Dryden.WIDTH, flights)))
    out = np.empty((6, samples, flights))
    for k in range(samples):
        out[:, k] = dryden.turbulence(state, h)
        state = dryden.step(state, h, V, random.standard_normal((Dryden.WIDTH, flights)))
    return out


def variances(case):
    """The integrals of the spectra."""
    return {name: quad(phi, 0, np.inf, limit=500)[0] for name, phi in spectra(*case).items()}


def standard_errors(of_flights, expected):
    """By how many standard errors the mean of flights is off."""
    return abs(of_flights.mean() - expected) / (of_flights.std() / math.sqrt(of_flights.size))


@pytest.fixture(scope="module", params=[LOW, pytest.param(MEDIUM, marks=pytest.mark.long)])
def turbulence(request):
    """10^5 s at 20 Hz, as 1000 flights of 102.4 s that start in the stationary state."""
    T = 1 / 20
    return request.param, T, recorded(request.param, T, flights=1000, samples=2048)


def test_the_spectra_are_those_of_the_specification(turbulence):
    case, T, data = turbulence
    analytic = spectra(*case)
    for name, x in zip(NAMES, data, strict=True):
        frequency, density = welch(x, fs=1 / T, nperseg=len(x), axis=0, detrend=False)
        # two decades; at 3 Hz the images of 17 Hz and above add 0.3 dB to the samples' spectrum
        band = (frequency >= 0.03) & (frequency <= 3.0)
        expected = 2 * math.pi * analytic[name](2 * math.pi * frequency[band])
        error = 10 * np.log10(density.mean(axis=1)[band] / expected)
        # one frequency scatters by 0.15 dB, the mean of ten by 0.05 dB
        assert abs(error).max() < 1.0, name
        assert abs(np.convolve(error, np.ones(10) / 10, mode="valid")).max() < 0.5, name


def test_variances_are_within_three_standard_errors(turbulence):
    case, _, data = turbulence
    for x, (name, variance) in zip(data, variances(case).items(), strict=True):
        assert standard_errors((x**2).mean(axis=0), variance) < 3, name


@pytest.mark.parametrize("lag", [1, 5, 20, 100])
def test_autocorrelations_are_within_three_standard_errors(turbulence, lag):
    (h, V, severity), T, data = turbulence
    field = dryden_field(h, severity)
    for name, x, sigma, L in (
        ("u", data[0], field.sigma_u, field.L_u),
        ("v", data[1], field.sigma_v, field.L_v),
        ("w", data[2], field.sigma_w, field.L_w),
    ):
        d = V * lag * T / L
        expected = sigma**2 * math.exp(-d) * (1 if name == "u" else 1 - d / 2)
        assert standard_errors((x[lag:] * x[:-lag]).mean(axis=0), expected) < 3, (name, lag)


def test_velocities_and_rates_correlate_as_they_must(turbulence):
    # q is -dw/dx and r is dv/dx through a lag: E[w q] = -E[w dw/dx] filtered, by the cross spectrum
    (h, V, severity), _, data = turbulence
    analytic = spectra(h, V, severity)
    for velocity, rate, factor, sign in ((2, 4, 4, -1.0), (1, 5, 3, 1.0)):
        tau = factor * SPAN / (math.pi * V)
        phi = analytic[NAMES[velocity]]
        # the real part of (i w / V) / (1 + i tau w)
        cross = quad(
            lambda w, tau=tau, phi=phi: phi(w) * w**2 * tau / V / (1 + (tau * w) ** 2),
            0,
            np.inf,
            limit=500,
        )[0]
        product = (data[velocity] * data[rate]).mean(axis=0)
        assert standard_errors(product, sign * cross) < 3
    for i, j in ((0, 1), (0, 2), (1, 2), (0, 3), (2, 3)):
        assert standard_errors((data[i] * data[j]).mean(axis=0), 0.0) < 3


def test_variances_do_not_depend_on_the_sample_period():
    # the shortest period is far below the gust's, the longest beyond it
    for T in (1 / 120, 1.0, 20.0):
        data = recorded(LOW, T, flights=4000, samples=20)
        for x, (name, variance) in zip(data, variances(LOW).items(), strict=True):
            assert standard_errors((x**2).mean(axis=0), variance) < 3.5, (name, T)


@pytest.mark.parametrize("theta", [1e-4, 0.01, 0.09, 0.5, 3.0, 50.0])
@pytest.mark.parametrize("k", [0.2, 0.9, 1.0, 1.02, 8.0, 400.0])
def test_a_step_is_that_of_the_matrix_exponential(theta, k):
    root = math.sqrt(3)
    A = np.array([[-1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [k * root, k * (1 - root), -k]])
    B = np.array([[1.0], [0.0], [0.0]])
    transition = expm(A * theta)
    stationary = solve_continuous_lyapunov(A, -B @ B.T)
    h = 10.0  # ft; the states of v are numbers 1 to 3, their noise too
    L = dryden_field(h).L_v
    dryden = Dryden(1.0, span=math.pi * L / (3 * k))
    V, units, still = theta * L, np.eye(8), np.zeros((8, 8))
    moved = np.array(dryden.step(units, h, V, still))[1:4, 1:4]
    assert moved == pytest.approx(transition, abs=1e-13)
    factor = np.array(dryden.step(still, h, V, units))[1:4, 1:4]
    added = stationary - transition @ stationary @ transition.T
    assert factor @ factor.T == pytest.approx(added, abs=1e-12)
    start = np.array(dryden.start(h, units))[1:4, 1:4]
    assert start @ start.T == pytest.approx(stationary, abs=1e-13)


def test_the_field_is_that_of_the_figures():
    # MIL-F-8785C, figures 10 and 11, at 100 ft: 100 / 0.2593^1.2, 0.2593^-0.4
    at_100 = dryden_field(100.0, wind_20ft=60.0)
    assert at_100.L_u == at_100.L_v == pytest.approx(505.1, abs=0.1)
    assert at_100.L_w == 100.0
    assert at_100.sigma_w == pytest.approx(6.0 * 1.68781, abs=1e-4)
    assert at_100.sigma_u / at_100.sigma_w == pytest.approx(1.7158, abs=1e-3)
    assert dryden_field(0.0) == dryden_field(10.0)
    # all meet at 1000 ft
    assert dryden_field(1000.0) == pytest.approx((5.06343,) * 3 + (1000.0,) * 3, rel=1e-6)
    assert dryden_field(1000.0) == pytest.approx(dryden_field(1000.0000001), rel=1e-9)
    # half way between 3 kt * 1.688 ft/s and figure 7 at 2000 ft, 9.6 + 0.125
    assert dryden_field(1500.0).sigma_u == pytest.approx((5.06343 + 9.725) / 2, abs=1e-4)
    assert dryden_field(1500.0).L_w == 1375.0
    assert dryden_field(2000.0) == pytest.approx(dryden_field(1999.9999999), rel=1e-9)
    assert dryden_field(90000.0, "severe").sigma_w == 5.1
    assert dryden_field(90000.0, sigma=3.0) == (3.0, 3.0, 3.0, 1750.0, 1750.0, 1750.0)


def test_the_rms_aloft_is_that_of_jsbsims_table():
    with (DATA / "turbulence_aloft.csv").open(newline="") as file:
        rows = [{name: float(x) for name, x in row.items()} for row in csv.DictReader(file)]
    assert len(rows) == 12
    for row in rows:
        for severity in ("light", "moderate", "severe"):
            field = dryden_field(row["altitude_ft"], severity)
            expected = (row[severity],) * 3
            assert field[:3] == pytest.approx(expected, abs=1e-12), (row, severity)


def flown(block, h, vt, psi=0.0, duration=2.0, dt=1 / 120):
    scope = Scope()
    sources = [Constant(h), Constant(vt), Constant(psi)]
    sim = Simulation(
        [*sources, block, scope],
        [
            *(Connection(source, block[i]) for i, source in enumerate(sources)),
            *(Connection(block[i], scope[i]) for i in range(6)),
        ],
        dt=dt,
        log=False,
    )
    sim.run(duration)
    return sim, scope


def test_the_block_is_the_recursion_turned_to_north_and_east():
    block = DrydenTurbulence(span=SPAN, seed=5, terrain=150.0)
    _, scope = flown(block, 350.0, 230.0, psi=90.0)
    dryden = Dryden(1 / 120, span=SPAN)
    rows = np.random.default_rng([5, 0]).standard_normal((1024, Dryden.WIDTH))
    state = dryden.start(200.0, rows[0])
    for k, got in enumerate(scope.read()[1].T):
        u, v, w, p, q, r = dryden.turbulence(state, 200.0)
        expected = [-v, u, w, *np.degrees([p, q, r])]
        assert got == pytest.approx(expected, abs=1e-12)
        state = dryden.step(state, 200.0, 230.0, rows[k + 1])


# large ones such as those of time.time_ns(), which a float does not hold
@pytest.mark.parametrize("seed", [1, 2**60])
def test_the_same_seed_is_the_same_flight_and_another_is_another(seed):
    def north(seed):
        sim, scope = flown(DrydenTurbulence(seed=seed), 3000.0, 400.0)
        before = scope.read()[1]
        sim.run(2.0, reset=True)
        assert np.array_equal(scope.read()[1], before)
        return before[0]

    one, again, other = north(seed), north(seed), north(seed + 1)
    assert np.array_equal(one, again)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.9


def test_frozen_air_and_calm_air():
    _, scope = flown(DrydenTurbulence(), 3000.0, 0.0)
    assert np.ptp(scope.read()[1], axis=1).max() == 0.0
    _, scope = flown(DrydenTurbulence(sigma=0.0), 3000.0, 400.0)
    assert not scope.read()[1].any()
    # going backwards is as standing still, and a step of a mile is one without memory
    dryden = Dryden(10.0, span=SPAN)
    state = dryden.start(500.0, range(8))
    assert dryden.step(state, 500.0, -5.0, range(8)) == state
    assert dryden.step(state, 10.0, 1e6, range(8)) == pytest.approx(
        dryden.start(10.0, range(8)), abs=1e-12
    )


def test_nan_is_handed_on_to_the_aircraft_which_refuses_it():
    block = DrydenTurbulence()
    y, _ = block.law([math.nan, 300.0, 0.0], block.initial_state())
    assert np.isnan(y[:2]).all()


@pytest.mark.parametrize(
    ("keywords", "parameter"),
    [
        ({"severity": "moderat"}, "severity"),
        ({"wind_20ft": -1.0}, "wind_20ft"),
        ({"sigma": -1.0}, "sigma"),
        ({"span": 0.0}, "span"),
        ({"terrain": math.inf}, "terrain"),
        ({"seed": -1}, "seed"),
        ({"seed": 0.5}, "seed"),
    ],
)
def test_bad_parameters_are_refused_by_name(keywords, parameter):
    with pytest.raises(ParameterError) as error:
        DrydenTurbulence(**keywords)
    assert error.value.parameter == parameter


def test_a_bad_height_is_refused():
    with pytest.raises(ParameterError) as error:
        dryden_field(math.nan)
    assert error.value.parameter == "h"
