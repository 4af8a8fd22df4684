"""Random arguments for every public constructor and function; `test_fuzz` runs this in a process.

    python fuzz_public_names.py REPORT [EXAMPLES]

Writes a JSON list of what went wrong: calls that ended in another error than one of the package's
own, or took longer than 5 s of the processor.
"""

import contextlib
import inspect
import json
import math
import sys
import time
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from pathsim import Simulation
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import (
    Aircraft,
    BlocksError,
    JSBSimFDM,
    TrimCondition,
    axes,
    catalogue,
)
from pathsim_jsbsim_blocks.air import airspeed, atmosphere
from pathsim_jsbsim_blocks.flight import Airframe, fleet, model_files, trim
from pathsim_jsbsim_blocks.pathview import convert_model, export_script
from pathsim_jsbsim_blocks.studies import trim_sweep

LIMIT = 5.0  # s of processor time, for one call

# the hot path below `isa`, for values that have passed its checks
INNER = ["pressure_temperature"]

NAMES = [
    "c172p",
    "737",
    "SGS",
    "C172P",
    "blank",
    "../c172p",
    "full",
    "none",
    "turn",
    "pull-up",
    "raise",
    "clip",
    "geopotential",
    "attitude/theta-deg",
    "attitude",
    "fcs/elevator-cmd-norm",
    "a b",
    "a[x]",
    "1",
    "-x",
    "/",
    "..",
    "\0",
    "propulsion/tank[99999999999]/contents-lbs",
]

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from(
        [
            0,
            1,
            -1,
            0.5,
            2,
            90,
            1e-300,
            1e300,
            -1e9,
            10**400,
            math.nan,
            math.inf,
            Fraction(1, 3),
            np.float32(1.5),
            np.int8(3),
            np.float64("nan"),
            True,
        ]
    ),
)
text = st.one_of(st.sampled_from(NAMES), st.text(max_size=12))
atoms = st.one_of(
    st.none(),
    numbers,
    text,
    st.binary(max_size=4),
    st.just(1j),
    st.just(Decimal("1.5")),
    st.just(object()),
    st.just(print),
    st.just(TrimCondition(speed=90)),
    st.sampled_from(
        [
            np.array(2.0),
            np.array([]),
            np.array([1.0, 2.0]),
            np.array([[1.0], [np.nan]]),
            np.array("x"),
            np.array([None]),
        ]
    ),
)
junk = st.one_of(
    atoms,
    st.lists(atoms, max_size=3),
    st.tuples(atoms, atoms),
    st.dictionaries(st.one_of(text, st.integers()), atoms, max_size=3),
    st.just({1, 2}),
)


def parameters(call):
    return [
        p
        for p in inspect.signature(call).parameters.values()
        if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)
    ]


def editing(block, valid):
    """A call that edits a block's parameters while its diagram runs, and goes on."""

    def edit(**changes):
        flying = block(**valid)
        sim = Simulation([flying], dt=1 / 120, log=False)
        sim.run(0.02)
        for name, value in changes.items():
            setattr(flying, name, value)
        for go_on in (sim.run, sim.reset, sim.run):
            with contextlib.suppress(BlocksError):
                go_on(*[0.02] * (go_on != sim.reset))

    # no parameter has to change
    edit.__signature__ = inspect.Signature([p.replace(default=None) for p in parameters(block)])
    return edit


def targets():
    """(name, callable, keywords that make a valid call)."""
    for name, thing in list(vars(package).items()):
        if inspect.isclass(thing) and issubclass(thing, Block):
            valid = {
                Aircraft: {"speed": 90.0},
                JSBSimFDM: {
                    "aircraft_model": "c172p",
                    "trim_airspeed": 90.0,
                    "trim_altitude": 5000.0,
                },
            }
            yield name, thing, valid.get(thing, {})
            if parameters(thing):
                yield f"editing {name}", editing(thing, valid.get(thing, {})), {}
    yield "TrimCondition", TrimCondition, {}
    air = atmosphere.isa(1000.0)
    for module in (atmosphere, airspeed, axes):
        for name, thing in list(vars(module).items()):
            if (
                inspect.isfunction(thing)
                and name[0] != "_"
                and name not in INNER
                and (thing.__module__.startswith(module.__name__))
            ):
                valid = {
                    p.name: air if p.name == "air" else 1.0
                    for p in parameters(thing)
                    if p.default is p.empty
                }
                yield f"{module.__name__}.{name}", thing, valid
    yield "Airframe", Airframe, {"aircraft": "c172p"}
    yield "aircraft_names", model_files.aircraft_names, {}
    yield "empty_weight_cg", model_files.empty_weight_cg, {"aircraft": "c172p"}
    yield "has_retractable_gear", model_files.has_retractable_gear, {"aircraft": "c172p"}
    plane = Airframe("c172p")
    for method in (
        plane.reader,
        plane.writer,
        plane.write,
        plane.access,
        plane.has,
        plane.canonical,
        plane.property_names,
    ):
        yield method.__name__, method, {}
    level = TrimCondition(speed=90)
    yield "trim", lambda condition=level, setup=None: trim(plane, condition, setup), {}
    yield "level_flight", fleet.level_flight, {"aircraft": "c172p"}
    yield "find_diagram", catalogue.find_diagram, {"name": "hello_jsbsim"}
    yield (
        "trim_sweep",
        lambda aircraft="c172p", grid=({"altitude": [5000], "speed": [90]}), outputs=(), root=None: (
            trim_sweep(aircraft, grid, outputs=outputs, root=root, jobs=1, progress=False)
        ),
        {},
    )
    yield "convert_model", convert_model, {"path": "no.pvm"}
    yield "export_script", export_script, {"script": "no.py"}


def arguments(call, valid):
    """Keywords of a call: the valid ones, and junk for some."""
    names = [p.name for p in parameters(call)]
    required = [p.name for p in parameters(call) if p.default is p.empty and p.name not in valid]
    return (
        st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True)
        .flatmap(lambda some: st.fixed_dictionaries({n: junk for n in {*some, *required}}))
        .map(lambda changed: {**valid, **changed})
        if names
        else st.just({})
    )


def attempts(name, call, valid, examples):
    """What goes wrong with one target: the shortest example of it."""
    trouble = {}

    @settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(arguments(call, valid))
    def attempt(keywords):
        start, why = time.process_time(), None
        try:
            call(**keywords)
        except BlocksError:
            pass
        except Exception as error:
            why = f"{type(error).__name__}: {error}"[:200]
        if time.process_time() - start > LIMIT:
            why = f"took longer than {LIMIT} s"
        if why:
            said = repr(keywords)
            if len(said) < len(trouble.get(why, said + " ")):
                trouble[why] = said

    attempt()
    return [[name, said, why] for why, said in trouble.items()]


def main(report, examples):
    warnings.simplefilter("ignore")
    trouble = [
        found for name, call, valid in targets() for found in attempts(name, call, valid, examples)
    ]
    with open(report, "w", encoding="utf-8") as file:
        json.dump(trouble, file)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20)
