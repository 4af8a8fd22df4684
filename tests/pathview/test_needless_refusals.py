"""Blocks and parameters of PathSim that PathView lacks: written as something that it has, or named."""

import subprocess
import sys

import pytest
from scripts_of_tests import HEAD

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview.toolboxes import core_registry, unknown_block

# PathSim warns of its old names
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def kinds(graph):
    for node in graph["nodes"]:
        yield node["name"], node["type"]
        yield from kinds(node.get("graph") or {"nodes": []})


def test_old_names_that_add_nothing_are_their_bases(export):
    content = export(
        f"""{HEAD}
step, pulse, clock, chirp, rng = Step(2.0, 0.1), Pulse(T=0.2), Clock(0.1), ChirpSource(T=0.3), RNG(0.1)
io, inner = Interface(), Step(tau=0.2)
sub = Subsystem([io, inner], [Connection(inner, io)])
scope = Scope()
sim = Simulation(
    [step, pulse, clock, chirp, rng, sub, scope],
    [Connection(b, scope[i]) for i, b in enumerate([step, pulse, clock, chirp, rng, sub])],
    dt=0.05, log=False,
)
sim.run(0.5)
"""
    )
    named = dict(kinds(content["graph"]))
    assert named["step"] == named["inner"] == "StepSource"
    assert named["pulse"] == "PulseSource"
    assert named["clock"] == "ClockSource"
    assert named["chirp"] == "ChirpPhaseNoiseSource"
    assert named["rng"] == "RandomNumberGenerator"


def test_blocks_without_memory_are_functions(export):
    content = export(
        f"""{HEAD}
a, b = Source(np.sin), Source(lambda t: t + 0.5)
turn = 0.1
matrix = Matrix([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)], [1.0, 0.0]])
both = [Norm(), PowProd(3), PowProd([1, 2]), Atan(), Sinh(), Cosh()]
io, inner = Interface(), Atan()
sub = Subsystem([io, inner], [Connection(io, inner), Connection(inner, io)])
scope = Scope()
sim = Simulation(
    [a, b, matrix, sub, scope, *both],
    [
        Connection(a, matrix[0], sub, *(x[0] for x in both)),
        Connection(b, matrix[1], *(x[1] for x in both)),
        *(Connection(matrix[i], scope[i]) for i in range(3)),
        Connection(sub, scope[3]),
        *(Connection(x, scope[4 + i]) for i, x in enumerate(both)),
        Connection(both[4][1], scope[10]),
    ],
    dt=0.05, log=False,
)
sim.run(0.5)
"""
    )
    assert sum(kind == "Function" for _, kind in kinds(content["graph"])) == 8


@pytest.mark.parametrize(
    ("simulation", "subsystem", "name"),
    [
        (", iterations_max=50", "", "'sim' has iterations_max = 50"),
        ("", ", tolerance_fpi=1e-3", "'sub' has tolerance_fpi = 0.001"),
        ("", ", iterations_max=3", "'sub' has iterations_max = 3"),
    ],
)
def test_a_parameter_without_a_field_is_refused_by_name(written, simulation, subsystem, name):
    text = f"""{HEAD}
io, gain, source, scope = Interface(), Amplifier(2.0), Source(np.sin), Scope()
sub = Subsystem([io, gain], [Connection(io, gain), Connection(gain, io)]{subsystem})
sim = Simulation([source, sub, scope], [Connection(source, sub), Connection(sub, scope)], dt=0.05, log=False{simulation})
sim.run(0.5)
"""
    with pytest.raises(DiagramError, match=name) as refused:
        written(text)
    assert refused.value.line == (10 if simulation else 9)


def test_one_that_is_set_later_and_in_a_nested_subsystem(written):
    text = f"""{HEAD}
io, deep, gain, source, scope = Interface(), Interface(), Amplifier(2.0), Source(np.sin), Scope()
low = Subsystem([deep, gain], [Connection(deep, gain), Connection(gain, deep)])
sub = Subsystem([io, low], [Connection(io, low), Connection(low, io)])
low.iterations_max = 5
sim = Simulation([source, sub, scope], [Connection(source, sub), Connection(sub, scope)], dt=0.05, log=False)
sim.run(0.5)
"""
    with pytest.raises(DiagramError, match="'low' has iterations_max = 5"):
        written(text)


def test_a_recorder_of_diagnostics_changes_no_flight(written):
    written(
        f"""{HEAD}
source, scope = StepSource(), Scope()
sim = Simulation([source, scope], [Connection(source, scope)], log=False, diagnostics=True)
sim.run(0.5)
"""
    )


def test_a_block_of_an_installed_toolbox_names_it(tmp_path, monkeypatch):
    registry = core_registry()
    assert "--toolbox" not in unknown_block("Bubbler4", registry)
    (tmp_path / "pathsim_chem.py").write_text(
        "from pathsim.blocks import Block\nclass Bubbler4(Block): ...\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert "--toolbox pathsim-chem" in unknown_block("Bubbler4", registry)
    assert "--toolbox" not in unknown_block("Bubbler5", registry)


def test_the_toolbox_of_a_block_is_named_without_loading_the_others():
    code = """
import sys
from pathsim_jsbsim_blocks import PitchHold
from pathsim_jsbsim_blocks.pathview.toolboxes import toolbox_of
assert toolbox_of(PitchHold).package == "pathsim-jsbsim-blocks"
assert "pathsim_jsbsim_blocks.guidance" not in sys.modules
assert "pathsim_jsbsim_blocks.daveml" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)
