"""Dryden turbulence of MIL-F-8785C: the recursion, as a plain class and as a block."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple

from .._core.checks import integer, number, one_of, positive
from .._core.noise import WhiteNoise
from .._core.parameters import parameter
from .._core.sampling import SampledLaw
from .._core.units import KNOT

_DEG = 180.0 / math.pi
_ROOT3 = math.sqrt(3.0)

# wind at 20 ft, kt: MIL-F-8785C, 3.7.3
Severity = Literal["light", "moderate", "severe"]
WIND_20FT: dict[str, float] = {"light": 15.0, "moderate": 30.0, "severe": 45.0}

# rms in ft/s by altitude in ft: MIL-F-8785C, figure 7, at probabilities of exceedance of 1e-2, 1e-3
# and 1e-5; the figure's curves as read off in JSBSim's FGWinds.cpp
_ALTITUDES = (500, 1750, 3750, 7500, 15000, 25000, 35000, 45000, 55000, 65000, 75000, 80000)
SIGMA = {
    "light": (6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0),
    "moderate": (8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0),
    "severe": (15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1),
}

_LOWEST, _LOW, _MEDIUM = 10.0, 1000.0, 2000.0  # ft, limits of the specification's forms
_MEDIUM_LENGTH = 1750.0  # ft
_speed = partial(number, low=0.0, high=1e3)  # winds in kt, rms in ft/s
_span = partial(number, above=0.0, low=0.1, high=1e3)  # ft
_FARTHEST = 1e100  # ft per period: the previous state has decayed, and squares are finite

# index of the next row of noise; u; two states and the lagged velocity, for v and for w; p
State = tuple[Any, ...]


class Field(NamedTuple):
    """Root mean squares in ft/s and scale lengths in ft of the turbulence at a height."""

    sigma_u: float
    sigma_v: float
    sigma_w: float
    L_u: float
    L_v: float
    L_w: float


def dryden_field(
    h: float,
    severity: Severity = "moderate",
    wind_20ft: float | None = None,
    sigma: float | None = None,
) -> Field:
    """Intensities and scale lengths of MIL-F-8785C at a height.

    .. math::
        \\sigma_w = 0.1 \\, W_{20}, \\quad
        \\frac{\\sigma_u}{\\sigma_w} = \\frac{\\sigma_v}{\\sigma_w} = (0.177 + 0.000823 h)^{-0.4}

        L_w = h, \\quad L_u = L_v = h \\, (0.177 + 0.000823 h)^{-1.2}

    up to 1000 ft (below 10 ft, with h = 10 ft); from 2000 ft up a common rms, and lengths of
    1750 ft; linear in height between.

    Parameters
    ----------
    h : float
        height above the terrain, ft
    severity : str
        "light", "moderate" or "severe"; sets the defaults of the next two
    wind_20ft : float, optional
        wind speed at 20 ft, kt; default 15, 30 or 45
    sigma : float, optional
        rms from 2000 ft up, ft/s; default: figure 7 of the specification at h, for a probability
        of exceedance of 1e-2, 1e-3 or 1e-5

    Returns
    -------
    Field
        ``sigma_u``, ``sigma_v``, ``sigma_w`` in ft/s, ``L_u``, ``L_v``, ``L_w`` in ft

    Raises
    ------
    ParameterError
        for an unknown severity, negative values and values that are not finite

    References
    ----------
    MIL-F-8785C, *Flying Qualities of Piloted Airplanes*, 1980, 3.7.2 and 3.7.3.

    Examples
    --------
    >>> field = dryden_field(200.0)
    >>> round(field.sigma_u, 2), round(field.sigma_w, 2), round(field.L_u)
    (7.78, 5.06, 726)
    """
    return _field(number("h", h), *_intensities(severity, wind_20ft, sigma))


def _intensities(severity: Any, wind_20ft: Any, sigma: Any) -> tuple[float, tuple[float, ...]]:
    """Rms of the vertical velocity near the ground, and the rms at each of the altitudes."""
    one_of("severity", severity, WIND_20FT)
    if wind_20ft is None:
        wind_20ft = WIND_20FT[severity]
    low = 0.1 * KNOT * _speed("wind_20ft", wind_20ft)
    if sigma is None:
        return low, SIGMA[severity]
    return low, (_speed("sigma", sigma),) * len(_ALTITUDES)


def _field(h: float, low: float, medium: tuple[float, ...]) -> Field:
    if h >= _MEDIUM:
        s = _interpolate(h, medium)
        return Field(s, s, s, _MEDIUM_LENGTH, _MEDIUM_LENGTH, _MEDIUM_LENGTH)
    if h > _LOW:
        part = (h - _LOW) / (_MEDIUM - _LOW)
        s = low + part * (_interpolate(_MEDIUM, medium) - low)
        L = _LOW + part * (_MEDIUM_LENGTH - _LOW)
        return Field(s, s, s, L, L, L)
    h = max(h, _LOWEST)
    ratio = 0.177 + 0.000823 * h
    s, L = low * ratio**-0.4, h * ratio**-1.2
    return Field(s, s, low, L, L, h)


def _interpolate(h: float, values: tuple[float, ...]) -> float:
    i = bisect_right(_ALTITUDES, h)
    if i == len(_ALTITUDES):
        return values[-1]
    low, high = _ALTITUDES[i - 1], _ALTITUDES[i]
    return values[i - 1] + (h - low) / (high - low) * (values[i] - values[i - 1])


class Dryden:
    """Dryden turbulence as a recursion that is exact while height and airspeed are constant.

    White noise of unit density drives, in units of L / V for time,

    .. math::
        \\frac{u}{\\sigma_u} = \\frac{\\sqrt 2}{1 + s}, \\quad
        \\frac{v}{\\sigma_v}, \\frac{w}{\\sigma_w} = \\frac{1 + \\sqrt 3 s}{(1 + s)^2}

    and the rates follow from the velocities along the flight path, averaged over the wing:

    .. math::
        q = -\\frac{s / V}{1 + \\frac{4 b}{\\pi V} s} w, \\quad
        r = \\frac{s / V}{1 + \\frac{3 b}{\\pi V} s} v, \\quad
        \\Phi_p(\\omega) = \\frac{\\sigma_w^2}{V L_w}
        \\frac{0.8 (\\pi L_w / 4 b)^{1/3}}{1 + (4 b \\omega / \\pi V)^2}

    with a separate noise for p. Each step uses the transition matrix of the filters and the
    covariance of the noise added within it, and the first state is drawn from the stationary
    distribution, so at any T the samples have the statistics of the continuous process. The class
    itself is stateless, as ``PID`` is. States and noise may be arrays, for many flights at once.

    Parameters
    ----------
    T : float
        sample period in s
    span : float
        wing span b, ft
    severity, wind_20ft, sigma
        as in `dryden_field`

    References
    ----------
    MIL-F-8785C, *Flying Qualities of Piloted Airplanes*, 1980, 3.7.1.
    """

    # standard normal numbers in a sample
    WIDTH = 8

    def __init__(
        self,
        T: float,
        *,
        span: float,
        severity: Severity = "moderate",
        wind_20ft: float | None = None,
        sigma: float | None = None,
    ):
        self.T = positive("T", T)
        self.span = _span("span", span)
        self._low, self._medium = _intensities(severity, wind_20ft, sigma)

    def field(self, h: float) -> Field:
        """Intensities and scale lengths at height ``h`` in ft."""
        return _field(h, self._low, self._medium)

    def start(self, h: float, noise: Any) -> State:
        """A state of the stationary distribution at height ``h``."""
        field = self.field(h)
        n_u, *n, n_p = noise
        v = _times(_lower(_stationary(self._lag_v(field))), n[:3])
        w = _times(_lower(_stationary(self._lag_w(field))), n[3:])
        return (n_u, *v, *w, n_p)

    def step(self, state: State, h: float, V: float, noise: Any) -> State:
        """The state one period later, at height ``h`` in ft and true airspeed ``V`` in ft/s."""
        field = self.field(h)
        n_u, *n, n_p = noise
        distance = min(max(V, 0.0) * self.T, _FARTHEST)
        u = _first_order(state[0], distance / field.L_u, n_u)
        v = _second_order(state[1:4], distance / field.L_v, self._lag_v(field), n[:3])
        w = _second_order(state[4:7], distance / field.L_w, self._lag_w(field), n[3:])
        p = _first_order(state[7], distance * math.pi / (4 * self.span), n_p)
        return (u, *v, *w, p)

    def turbulence(self, state: State, h: float) -> tuple[Any, ...]:
        """Velocities u, v, w of the air in ft/s and its rates p, q, r in rad/s."""
        field = self.field(h)
        b, L = self.span, field.L_w
        v, w = _velocity(state[1], state[2]), _velocity(state[4], state[5])
        sigma_p = field.sigma_w * math.sqrt(
            0.8 * (math.pi * L / (4 * b)) ** (1 / 3) * math.pi**2 / (8 * b * L)
        )
        return (
            field.sigma_u * state[0],
            field.sigma_v * v,
            field.sigma_w * w,
            sigma_p * state[7],
            -field.sigma_w * math.pi / (4 * b) * (w - state[6]),
            field.sigma_v * math.pi / (3 * b) * (v - state[3]),
        )

    # poles of the rates' filters in units of V / L
    def _lag_v(self, field: Field) -> float:
        return math.pi * field.L_v / (3 * self.span)

    def _lag_w(self, field: Field) -> float:
        return math.pi * field.L_w / (4 * self.span)


# The second-order filter with the lag of its rate, time in units of L / V, noise n of unit density:
#   x1' = -x1 + n,  x2' = -x2 + x1,  y = sqrt(3) x1 + (1 - sqrt(3)) x2,  x3' = k (y - x3)
Covariance = tuple[float, float, float, float, float, float]  # 11, 21, 22, 31, 32, 33


def _velocity(x1: Any, x2: Any) -> Any:
    return _ROOT3 * x1 + (1 - _ROOT3) * x2


def _first_order(x: Any, theta: float, noise: Any) -> Any:
    return math.exp(-theta) * x + math.sqrt(-math.expm1(-2 * theta)) * noise


def _second_order(x: Any, theta: float, k: float, noise: Any) -> tuple[Any, ...]:
    """The three states after the time ``theta``."""
    a, b, c31, c32, f = _transition(theta, k)
    p11, p21, p22, p31, p32, p33 = _stationary(k)
    # required entries of transition times covariance
    m21, m22 = b * p11 + a * p21, b * p21 + a * p22
    m31 = c31 * p11 + c32 * p21 + f * p31
    m32 = c31 * p21 + c32 * p22 + f * p32
    m33 = c31 * p31 + c32 * p32 + f * p33
    # the covariance of the added noise keeps the total stationary
    factor = _times(
        _lower(
            (
                p11 - a * a * p11,
                p21 - a * m21,
                p22 - (b * m21 + a * m22),
                p31 - a * m31,
                p32 - (b * m31 + a * m32),
                p33 - (c31 * m31 + c32 * m32 + f * m33),
            )
        ),
        noise,
    )
    x1, x2, x3 = x
    return (
        a * x1 + factor[0],
        b * x1 + a * x2 + factor[1],
        c31 * x1 + c32 * x2 + f * x3 + factor[2],
    )


def _transition(theta: float, k: float) -> tuple[float, float, float, float, float]:
    """The entries 11 and 22, 21, 31, 32, 33 of the transition matrix."""
    a, f = math.exp(-theta), math.exp(-k * theta)
    z = (1 - k) * theta
    # (exp(z) - 1) / z and (exp(z) - 1 - z) / z^2, times a
    if abs(z) > 0.1:
        first, second = (f - a) / z, (f - a - a * z) / z**2
    else:
        second = a * sum(z**n / math.factorial(n + 2) for n in range(9))
        first = a + z * second
    # the lag's response to y: to the initial value of y and to x1, which drives y
    value, slope = k * theta * first, (1 - _ROOT3) * k * theta**2 * second
    return a, theta * a, _ROOT3 * value + slope, (1 - _ROOT3) * value, f


def _stationary(k: float) -> Covariance:
    p31 = k / (1 + k) * (1 + _ROOT3) / 4
    p32 = (p31 + k / 4) / (1 + k)
    return 0.5, 0.25, 0.25, p31, p32, _velocity(p31, p32)


def _lower(q: Covariance) -> Covariance:
    """Cholesky factor; over short times its last entries are below the rounding of ``q``: clip."""
    q11, q21, q22, q31, q32, q33 = q
    l11 = math.sqrt(max(q11, 0.0))
    l21, l31 = (q21 / l11, q31 / l11) if l11 else (0.0, 0.0)
    l22 = math.sqrt(max(q22 - l21 * l21, 0.0))
    l32 = (q32 - l31 * l21) / l22 if l22 else 0.0
    l33 = math.sqrt(max(q33 - l31 * l31 - l32 * l32, 0.0))
    return l11, l21, l22, l31, l32, l33


def _times(factor: Covariance, noise: Any) -> tuple[Any, Any, Any]:
    l11, l21, l22, l31, l32, l33 = factor
    n1, n2, n3 = noise
    return l11 * n1, l21 * n1 + l22 * n2, l31 * n1 + l32 * n2 + l33 * n3


@dataclass(eq=False, repr=False)
class DrydenTurbulence(SampledLaw):
    """Dryden turbulence of MIL-F-8785C at low and medium altitude, for the aircraft's wind ports.

    .. math::
        \\Phi_u = \\frac{2 \\sigma_u^2 L_u}{\\pi V} \\frac{1}{1 + (L_u \\omega / V)^2}, \\qquad
        \\Phi_{v,w} = \\frac{\\sigma^2 L}{\\pi V}
        \\frac{1 + 3 (L \\omega / V)^2}{(1 + (L \\omega / V)^2)^2}

    sampled at T and held. The samples have these spectra's variances and correlations at any T;
    intensities and scale lengths follow the height (see ``wind.dryden_field``). The velocity u is
    along the horizontal heading, v to its right, w down; the outputs turn u and v to north and
    east. The same seed gives the same turbulence; give blocks that must be independent different
    seeds.

    Parameters
    ----------
    severity : str
        "light", "moderate" or "severe": the wind at 20 ft, and the rms from 2000 ft up
    wind_20ft : float, optional
        wind speed at 20 ft above the terrain in kt; default by severity: 15, 30 or 45
    sigma : float, optional
        rms of each velocity from 2000 ft up in ft/s; default: figure 7 of the specification
    span : float
        wing span in ft, for the rates
    terrain : float
        elevation of the terrain above mean sea level, ft
    seed : int
        seed of the random numbers, 0 or more
    T : float
        sample period in s; a new one acts at the next reset

    Inputs
    ------
    h
        altitude above mean sea level, ft
    vt
        true airspeed, ft/s; at 0 the turbulence is frozen
    psi
        true heading, deg

    Outputs
    -------
    north, east, down
        velocity of the air, ft/s
    p, q, r
        rotation of the air about the axes of u, v and w, as for a rigid body, deg/s; JSBSim has no
        input for these

    Raises
    ------
    ParameterError
        for an unknown severity, a seed that is not a whole number, a span that is not positive,
        negative speeds, and values that are not finite

    References
    ----------
    MIL-F-8785C, *Flying Qualities of Piloted Airplanes*, 1980, 3.7.
    """

    severity: Severity = "moderate"
    wind_20ft: float | None = None
    sigma: float | None = None
    span: float = parameter(35.8, _span)
    terrain: float = parameter(0.0, number)
    seed: int = parameter(0, integer, low=0)
    T: float = parameter(1 / 120, positive)

    is_wind = True
    measured = ("h", "vt")
    input_port_labels = {"h": 0, "vt": 1, "psi": 2}
    output_port_labels = {"north": 0, "east": 1, "down": 2, "p": 3, "q": 4, "r": 5}

    def build(self) -> None:
        self._dryden = Dryden(
            self.clock.period,
            span=self._checked.span,
            severity=self.severity,
            wind_20ft=self.wind_20ft,
            sigma=self.sigma,
        )
        self._terrain = self._checked.terrain
        self._noise = WhiteNoise(self._checked.seed, Dryden.WIDTH)

    def initial_state(self) -> State:
        return (0,)

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        h, vt, psi = u[0] - self._terrain, u[1], math.radians(u[2])
        k, x = state[0], state[1:]
        if not x:
            x = self._dryden.start(h, self._noise.row(k))
        forward, right, down, p, q, r = self._dryden.turbulence(x, h)
        cos, sin = math.cos(psi), math.sin(psi)
        y = [
            forward * cos - right * sin,
            forward * sin + right * cos,
            down,
            _DEG * p,
            _DEG * q,
            _DEG * r,
        ]
        return y, (k + 1, *self._dryden.step(x, h, vt, self._noise.row(k + 1)))
