"""Blocks and parameters of PathSim that PathView lacks: written as something that it has, or named."""

import subprocess
import sys

import pytest
from scripts_of_tests import HEAD, kinds, script

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview.toolboxes import core_registry, unknown_block

# PathSim warns of its old names
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_old_names_that_add_nothing_are_their_bases(export):
    blocks = """
step, pulse, clock, chirp, rng = Step(2.0, 0.1), Pulse(T=0.2), Clock(0.1), ChirpSource(T=0.3), RNG(0.1)
io, inner = Interface(), Step(tau=0.2)
sub = Subsystem([io, inner], [Connection(inner, io)])
"""
    names = "step, pulse, clock, chirp, rng, sub"
    named = dict(kinds(export(script(blocks, names=names, after="sim.run(0.5)"))["graph"]))
    assert named["step"] == named["inner"] == "StepSource"
    assert named["pulse"] == "PulseSource"
    assert named["clock"] == "ClockSource"
    assert named["chirp"] == "ChirpPhaseNoiseSource"
    assert named["rng"] == "RandomNumberGenerator"


def test_blocks_without_memory_are_functions(export):
    blocks = """
a, b = Source(np.sin), Source(lambda t: t + 0.5)
turn = 0.1
matrix = Matrix([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)], [1.0, 0.0]])
both = [Norm(), PowProd(3), PowProd([1, 2]), Atan(), Sinh(), Cosh()]
io, inner = Interface(), Atan()
sub = Subsystem([io, inner], [Connection(io, inner), Connection(inner, io)])
"""
    wires = (
        "Connection(a, matrix[0], sub, *(x[0] for x in both)),"
        "Connection(b, matrix[1], *(x[1] for x in both))"
    )
    content = export(script(blocks, wires, names="a, b, matrix, sub, *both", after="sim.run(0.5)"))
    assert sum(kind == "Function" for _, kind in kinds(content["graph"])) == 8


@pytest.mark.parametrize(
    ("simulation", "subsystem", "later", "name", "line"),
    [
        (", iterations_max=50", "", "", "'sim' has iterations_max = 50", 12),
        ("", ", tolerance_fpi=1e-3", "", "'sub' has tolerance_fpi = 0.001", 10),
        ("", "", "low.iterations_max = 5", "'low' has iterations_max = 5", 9),
    ],
)
def test_a_parameter_without_a_field_is_refused_by_name(
    written, simulation, subsystem, later, name, line
):
    text = f"""{HEAD}
io, deep, gain, source, scope = Interface(), Interface(), Amplifier(2.0), Source(np.sin), Scope()
low = Subsystem([deep, gain], [Connection(deep, gain), Connection(gain, deep)])
sub = Subsystem([io, low], [Connection(io, low), Connection(low, io)]{subsystem})
{later}
sim = Simulation([source, sub, scope], [Connection(source, sub), Connection(sub, scope)], dt=0.05, log=False{simulation})
sim.run(0.5)
"""
    with pytest.raises(DiagramError, match=name) as refused:
        written(text)
    assert refused.value.line == line


def test_a_recorder_of_diagnostics_changes_no_flight(written):
    written(script("a = StepSource()").replace("log=False", "diagnostics=True"))


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
