"""`LinearModel`: A, B, C, D of a trimmed aircraft, with names, units and the trim."""

from __future__ import annotations

import json
import os
import reprlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm

from .._core.checks import (
    did_you_mean,
    integer,
    mapping,
    must_be,
    name_list,
    nearest,
    positive,
    refuse,
)
from .._core.extras import required
from .._core.files import as_path, write_whole
from ..errors import FileError
from .identification import respond
from .modes import Mode, natural_modes

if TYPE_CHECKING:
    import control
    import pandas as pd

_ARRAYS = {
    "A": ("states", "states"),
    "B": ("states", "inputs"),
    "C": ("outputs", "states"),
    "D": ("outputs", "inputs"),
    "x0": ("states",),
    "u0": ("inputs",),
    "y0": ("outputs",),
    "kinks": ("outputs", "inputs"),
    "fit": ("outputs", "inputs"),
    "latency": ("inputs",),
}
_NAMES = ("states", "inputs", "outputs")

# arrays that are NaN for responses too small to judge
_PARTIAL = ("kinks", "fit")

# first entry of a saved model
_FORMAT = "pathsim-jsbsim-blocks linear model 1"


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Linear model of an aircraft about its trim.

    .. math::
        \\dot{x} &= A \\, (x - x_0) + B \\, (u(t - \\tau) - u_0) \\\\
        y &= y_0 + C \\, (x - x_0) + D \\, (u(t - \\tau) - u_0)

    The latency tau, ``latency`` sample periods, comes from JSBSim's order of computation between
    command and motion. The block also holds its inputs over each period; in a continuous design
    both together are the delay ``delay``.

    Parameters
    ----------
    aircraft : str
        the model's name
    condition : str
        the trim
    method : str
        "flown" or "algebraic"
    A, B, C, D : array
        shapes (n, n), (n, m), (p, n), (p, m); per s, in the units of the names
    states, inputs, outputs : list of str
        names of the n states, m inputs and p outputs. A state that is also an output has the same
        name in both; states that appear in no output are x1, x2, ...
    units : dict
        unit of each state, input and output, by name; "" without one
    x0, u0, y0 : array
        the trim, in these units
    dt : float
        sample period of the block in s
    latency : array of int, shape (m,)
        periods by which each input acts late; with the flown method, a throttle's latency is that
        of a step of the doublet's height
    kinks : array, shape (p, m)
        even part over odd part of each response, ``|y+ + y- - 2 y0| / |y+ - y-|``, the maximum
        after pulse and doublet: 0 for a linear aircraft; NaN if an output hardly responds
    fit : array, shape (p, m)
        maximum of three relative rms errors against the flown responses: after the pulse, over
        the output's maximum rms response to any input, and after doublets that begin upwards and
        downwards, over the response itself unless it is small; NaN for the algebraic method,
        which has no flights

    Raises
    ------
    ParameterError
        for arrays whose shape does not match the names or that are not finite, a duplicate name, a
        ``dt`` that is not positive, a ``latency`` that is not in whole periods
    """

    aircraft: str
    condition: str
    method: str
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, str]
    x0: np.ndarray
    u0: np.ndarray
    y0: np.ndarray
    dt: float
    latency: np.ndarray
    kinks: np.ndarray
    fit: np.ndarray

    def __post_init__(self) -> None:
        positive("dt", self.dt)
        object.__setattr__(self, "units", mapping("units", self.units))
        for name in _NAMES:
            object.__setattr__(self, name, tuple(getattr(self, name)))
            find(name, getattr(self, name), getattr(self, name))
        sizes = {name: len(getattr(self, name)) for name in _NAMES}
        for name, shape in _ARRAYS.items():
            try:
                value = np.array(getattr(self, name), dtype=float)
            except (TypeError, ValueError, OverflowError) as error:
                refuse(name, getattr(self, name), f"{name} must be an array of numbers: {error}")
            dimensions = tuple(sizes[side] for side in shape)
            # numpy has no shape (0, m) for an empty list
            if value.shape != dimensions and value.size == np.prod(dimensions) == 0:
                value = value.reshape(dimensions)
            if value.shape != dimensions:
                counts = " and ".join(f"{sizes[side]} {side}" for side in dict.fromkeys(shape))
                refuse(name, value, f"{name} has the shape {value.shape}, but there are {counts}")
            entries = value[~np.isnan(value)] if name in _PARTIAL else value
            if not np.all(np.isfinite(entries)):
                refuse(name, value, f"{name} must be finite")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        late = self.latency
        if np.any((late < 0) | (late != np.round(late))):
            refuse("latency", late, f"latency must be in whole periods, not {late.tolist()}")

    @property
    def delay(self) -> np.ndarray:
        """Delay of each input in s in a continuous loop: latency plus half a period of hold."""
        return (self.latency + 0.5) * self.dt

    def __repr__(self) -> str:
        return (
            f"<LinearModel of {self.aircraft!r} at {self.condition}: {len(self.states)} states, "
            f"{len(self.inputs)} inputs, {len(self.outputs)} outputs, {self.method}>"
        )

    def select(
        self, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None
    ) -> LinearModel:
        """The model with the named inputs and outputs only, in that order.

        Raises
        ------
        ParameterError
            for a name that the model does not have, naming the nearest
        """
        indices = {
            "states": range(len(self.states)),
            "inputs": find("inputs", self.inputs, inputs),
            "outputs": find("outputs", self.outputs, outputs),
        }
        parts: dict[str, Any] = {
            name: getattr(self, name)[np.ix_(*(indices[side] for side in shape))]
            for name, shape in _ARRAYS.items()
        }
        parts |= {side: [getattr(self, side)[i] for i in indices[side]] for side in _NAMES}
        return replace(self, **parts)

    def modes(self) -> list[Mode]:
        """Natural modes, the fastest first, named by the participating states."""
        return natural_modes(self.A, self.states)

    def simulate(self, u: Any) -> np.ndarray:
        """Outputs at the sample instants for inputs that are held over each period.

        Parameters
        ----------
        u : array, shape (n, m)
            inputs over n periods of ``dt``, full values, finite

        Returns
        -------
        array, shape (n + 1, p)
            full values of the outputs, the trim first

        Raises
        ------
        ParameterError
            for inputs of another shape, or values that are not finite
        """
        try:
            inputs = np.asarray(u, dtype=float)
            valid = inputs.shape[1:] == (len(self.inputs),) and np.isfinite(inputs).all()
        except (TypeError, ValueError):
            valid = False
        if not valid:
            shape = f" of shape {u.shape}" if isinstance(u, np.ndarray) else ""
            requirement = f"a row for each period of {self.dt:.6g} s and {len(self.inputs)} columns"
            requirement += f" ({', '.join(self.inputs)}) of finite numbers"
            refuse("u", u, f"u must have {requirement}, not {reprlib.repr(u)}{shape}")
        return self.y0 + respond(self, inputs - self.u0, self.dt).sum(axis=0)

    def frequency_response(self, omega: Any) -> np.ndarray:
        """Frequency response of the sampled aircraft, with its hold and latency.

        .. math::
            z^{-k} \\left(C (z I - \\Phi)^{-1} \\Gamma + D\\right), \\quad z = e^{j \\omega T}

        k is the latency; Phi and Gamma are the matrices over one period T. Hold, sampling and
        latency are exact, up to pi / T, the limit of a sampled system. Well below that limit the
        response is the continuous one with a delay of `delay` s.

        Parameters
        ----------
        omega : array, shape (k,)
            rad/s

        Returns
        -------
        complex array, shape (k, p, m)

        Raises
        ------
        ParameterError
            if omega is not a list of numbers, or has a pole (0 for an integrator)
        """
        transition, effect = sampled(self)
        z = np.exp(1j * self.dt * np.asarray(omega, dtype=complex))
        try:
            z = z[:, None, None]
            states = np.linalg.solve(z * np.eye(len(transition)) - transition, effect)
        except (IndexError, np.linalg.LinAlgError):
            must_be("omega", omega, "a list of frequencies, none of them a pole")
        return (self.C @ states + self.D) * z**-self.latency

    def with_lags(self, tau: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C, D with a first-order lag of ``tau`` s on each input, in place of a delay.

        The lags are the last states; an input without one (``tau`` 0) acts directly. With lags on
        all inputs the model has no direct feedthrough and cannot close an algebraic loop.

        Raises
        ------
        ParameterError
            if tau is not one number of at least 0, or one for each input
        """
        m, lags = len(self.inputs), np.asarray(tau, dtype=float)
        if lags.shape not in ((), (m,)) or not np.all((lags >= 0.0) & np.isfinite(lags)):
            must_be("tau", tau, f"a time of at least 0 s, or {m} of them, one for each input")
        tau = np.broadcast_to(lags, m)
        lagging = np.flatnonzero(tau)
        n, k = len(self.states), len(lagging)
        rate = np.diag(1.0 / tau[lagging])
        B, D = self.B.copy(), self.D.copy()
        B[:, lagging] = D[:, lagging] = 0.0
        into = np.zeros((k, m))
        into[:, lagging] = rate
        return (
            np.block([[self.A, self.B[:, lagging]], [np.zeros((k, n)), -rate]]),
            np.vstack([B, into]),
            np.hstack([self.C, self.D[:, lagging]]),
            D,
        )

    def to_control(self, pade: int = 2) -> control.StateSpace:
        """A python-control ``StateSpace`` with the names of inputs, outputs and states.

        Its inputs and outputs are increments about the trim. `delay`, latency and half a period of
        hold, is a Pade approximation on each input, whose states come last ("elevator delay 1").

        Parameters
        ----------
        pade : int
            order of the approximation; 0 for the states of the aircraft alone, without delay

        Raises
        ------
        MissingExtraError
            if python-control (extra ``analysis``) is not installed
        ParameterError
            if the order is not a whole number of at least 0
        """
        control = required("control", "analysis", name="python-control")
        order = integer("pade", pade, low=0)
        A, B, C, D = self.A, self.B, self.C, self.D
        states = list(self.states)
        if order:
            late = [control.tf2ss(*control.pade(delay, order)) for delay in self.delay]
            lag = control.append(*late)
            A = np.block([[A, B @ lag.C], [np.zeros((lag.nstates, len(A))), lag.A]])
            B, C, D = np.vstack([B @ lag.D, lag.B]), np.hstack([C, D @ lag.C]), D @ lag.D
            states += [f"{u} delay {k}" for u in self.inputs for k in range(1, order + 1)]
        names = {"inputs": list(self.inputs), "outputs": list(self.outputs), "states": states}
        return control.StateSpace(
            A, B, C, D, **names, name=self.aircraft, remove_useless_states=False
        )

    def to_frame(self) -> pd.DataFrame:
        """The matrix ``[[A, B], [C, D]]`` as a table with the names.

        Returns
        -------
        pandas.DataFrame
            rows: derivatives of the states (``d vt/dt``), then outputs; columns: states, inputs

        Raises
        ------
        MissingExtraError
            if pandas (extra ``studies``) is not installed
        """
        pd = required("pandas", "studies")
        return pd.DataFrame(
            np.block([[self.A, self.B], [self.C, self.D]]),
            index=[*(f"d {name}/dt" for name in self.states), *self.outputs],
            columns=[*self.states, *self.inputs],
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as JSON; `load` reads it back, bit for bit.

        Raises
        ------
        FileError
            if the file cannot be written
        """
        file = as_path("path", path)
        data = {"format": _FORMAT, **asdict(self)}
        for name in _ARRAYS:
            data[name] = _to_lists(data[name])
        write_whole(file, json.dumps(data, indent=1, allow_nan=False))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> LinearModel:
        """Read a model written by `save`.

        Raises
        ------
        FileError
            if the file cannot be read
        ParameterError
            if it is not a saved linear model
        """
        file = as_path("path", path)
        try:
            data = json.loads(file.read_text(encoding="utf-8"))
            if not isinstance(data, dict) or data.pop("format", None) != _FORMAT:
                raise ValueError(f"its format is not {_FORMAT!r}")
            return cls(**data)  # an array of null is NaN
        except OSError as error:
            raise FileError("read", file, error) from None
        except (ValueError, TypeError, RecursionError) as error:
            refuse("path", str(file), f"{str(file)!r} is not a saved linear model: {error}")


def _to_lists(array: np.ndarray) -> Any:
    """Nested lists, with None for NaN."""
    entries = array.astype(object)
    entries[np.isnan(array)] = None
    return entries.tolist()


def sampled(model: LinearModel) -> tuple[np.ndarray, np.ndarray]:
    """The states' transition over one period, and the effect of the inputs held over it."""
    n, m = model.B.shape
    step = expm(np.block([[model.A, model.B], [np.zeros((m, n + m))]]) * model.dt)
    return step[:n, :n], step[:n, n:]


def find(parameter: str, names: Sequence[str], selection: Sequence[str] | None) -> list[int]:
    """Indices of the selected names, each at most once; all for None."""
    if selection is None:
        return list(range(len(names)))
    selection = name_list(parameter, selection)
    for i, name in enumerate(selection):
        if name not in names:
            close = did_you_mean(nearest(str(name), names)) or f" among {', '.join(names)}"
            refuse(parameter, selection, f"{parameter}[{i}]: there is no {name!r}{close}")
    if len(set(selection)) < len(selection):
        refuse(parameter, selection, f"{parameter} lists a name twice: {', '.join(selection)}")
    return [list(names).index(name) for name in selection]
