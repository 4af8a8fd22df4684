"""Laws as expressions: what is compiled is what was described."""

import math

import numpy as np
import pytest

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    DiscretePID,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)
from pathsim_jsbsim_blocks.control.signals import (
    Signal,
    acos,
    compiled,
    flat,
    larger,
    limit,
    nested,
    select,
    smaller,
    wrap,
)


def every_operation(u, state):
    a, b, c = u
    (x, (engaged, y)) = state
    low, high = smaller(a, b), larger(a, b)
    inside = limit(c, low, high)
    turned = wrap(100.0 * a - y) + acos(limit(b / (1.0 + abs(c)), -1.0, 1.0))
    on = (a >= b) & (c != 0.5) | (x < -1.0)
    after = select(on, (1.0 - x, (False, -y)), (x + 2.0 * inside, (engaged, y % 3.0)))
    return [inside, turned, select(engaged, a**2, 2.0**b), select(on, 1.0, 1.0)], after


def test_each_operation_is_that_of_floats():
    rng = np.random.default_rng(3)
    start = (0.5, (True, -7.0))
    law = compiled(every_operation, 3, start)
    for u in rng.normal(size=(200, 3)).round(1).tolist():
        state = (float(rng.normal()), (bool(rng.random() < 0.5), float(rng.normal())))
        outputs, after = every_operation(u, state)
        assert law([*u, 9.0], flat(state)) == (outputs, flat(after))
    assert nested(iter(flat(start)), start) == start


def test_a_law_that_decides_by_if_is_refused():
    with pytest.raises(TypeError, match="by select and limit"):
        compiled(lambda u, x: ([u[0] if u[0] > 0 else -u[0]], x), 1, (0.0,))


def test_an_operation_that_is_not_reached_is_not_done():
    # the same division three times, and one without use
    def describe(u, state):
        a, b = u
        _unused = 1.0 / b
        return [
            select(b == 0.0, 0.0, a / b),
            select(b == 0.0, 1.0, a / select(b == 0.0, 1.0, b)),
        ], state

    assert compiled(describe, 2, (0.0,))([1.0, 0.0], (0.0,)) == ([0.0, 1.0], (0.0,))
    assert isinstance(Signal("u0") / Signal("u1"), Signal)


KINDS = (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    DiscretePID,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)


@pytest.mark.parametrize("gains", ["737", "c172p-designed"])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_compiled_law_is_its_description_on_floats(kind, gains):
    # ports at 0 and not, so that everything is on and off; all states of the flight are compared
    block = kind() if kind is DiscretePID else kind(gains, T=1 / 20)
    rng = np.random.default_rng(8)
    n, state = len(block.input_port_labels), block.initial_state()
    row = []
    for k in range(120):
        u = (rng.normal(size=n) * 10.0 * (rng.random(n) < 0.8)).tolist()
        for name in ("vc", "h"):
            if name in block.input_port_labels:
                u[block.input_port_labels[name]] = 80.0 + 0.1 * k
        form = None
        if kind is not DiscretePID:
            form = block.form(u) if block._formed else None
            row = block.gains_at(80.0 + 0.1 * k, 80.0 + 0.1 * k if block._h is not None else None)
        outputs, after = block.describe([*u, *row], nested(iter(state), block.START), form)
        found, state = block.law(u, state)
        assert found == pytest.approx(outputs, rel=1e-12, abs=1e-12)
        assert state == pytest.approx(flat(after), rel=1e-12, abs=1e-12)
        assert all(math.isfinite(x) for x in state)
