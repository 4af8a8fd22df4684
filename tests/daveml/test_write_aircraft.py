"""A JSBSim aircraft with every kind of variable: what JSBSim computes is what the model does."""

import random

import jsbsim
import pytest
from test_daveml import A, B, apply

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.daveml import DaveModel, write_aircraft

CASE = "<piecewise><piece><ci>a</ci>{}</piece><piece><ci>b</ci>{}</piece><otherwise><cn>7</cn></otherwise></piecewise>"
ONE, HALF = "<cn>1</cn>", "<cn>0.5</cn>"
POSITIVE = apply("plus", ONE, apply("times", A, A))
FORMULAS = {
    "sum": apply("plus", A, B, A),
    "negative": apply("minus", A),
    "difference": apply("minus", A, B),
    "product": apply("times", A, B, B),
    "quotient": apply("divide", A, POSITIVE),
    "power": apply("power", POSITIVE, B),
    "root": apply("root", "<degree><cn>3</cn></degree>", POSITIVE),
    "rem": apply("rem", A, POSITIVE),
    "size": apply("abs", B),
    "least": apply("min", A, B, HALF),
    "most": apply("max", A, B),
    "floor": apply("floor", A),
    "ceiling": apply("ceiling", A),
    "exp": apply("exp", B),
    "ln": apply("ln", POSITIVE),
    "log": apply("log", POSITIVE),
    "atan2": "<apply><csymbol>atan2</csymbol><ci>a</ci><ci>b</ci></apply>",
    **{f: apply(f, A) for f in ("sin", "cos", "tan", "arctan")},
    "arcs": apply("plus", apply("arcsin", apply("sin", A)), apply("arccos", apply("cos", A))),
    **{f: apply(f, A, B) for f in ("lt", "gt", "leq", "geq", "eq", "neq")},
    "logic": apply("and", apply("gt", A, B), apply("not", apply("or", apply("lt", B, HALF), "<false/>"))),
    "pieces": CASE.format(apply("gt", A, B), apply("gt", B, HALF)),
    "flag": CASE.format(apply("floor", A), apply("lt", A, HALF)),
}  # fmt: skip
TABLES = """
  <function name="cube"><independentVarPts varID="a">-1, 0, 2</independentVarPts>
    <independentVarPts varID="b">-2, 2</independentVarPts>
    <independentVarPts varID="c">0, 1, 3, 4</independentVarPts>
    <dependentVarPts varID="cube">{}</dependentVarPts></function>
  <function name="line"><independentVarPts varID="c">0, 1, 3</independentVarPts>
    <dependentVarPts varID="line">4, 2, 5</dependentVarPts></function>"""
OUTPUTS = {"thrustBodyForce_X": "lbf", "thrustBodyForce_Y": "lbf", "thrustBodyForce_Z": "lbf"}
OUTPUTS |= {"thrustBodyMoment_Roll": "ftlbf", "thrustBodyMoment_Pitch": "ftlbf"}
OUTPUTS |= {"thrustBodyMoment_Yaw": "ftlbf"}


def variable(name, formula="", units="nd", more=""):
    math = f"<calculation><math>{formula}</math></calculation>" if formula else ""
    return f'<variableDef varID="{name}" name="{name}" units="{units}" {more}>{math}</variableDef>'


def written(folder):
    """An aircraft whose propulsion has the variables."""
    draw = random.Random(3)
    text = variable("a") + variable("b") + variable("c", more='minValue="-0.5" maxValue="3.5"')
    text += "".join(variable(name, formula) for name, formula in FORMULAS.items())
    text += variable("cube") + variable("line") + TABLES.format([draw.random() for _ in range(24)])
    text += variable("held", A, more='minValue="-0.5"') + variable(
        "both", A, more='minValue="-0.5" maxValue="1"'
    )
    for i, (name, units) in enumerate(OUTPUTS.items()):
        text += variable(name, apply("times", f"<cn>{i + 1}</cn>", "<ci>sum</ci>"), units)
    file = folder / "engine.dml"
    file.write_text(f"<DAVEfunc>{text}</DAVEfunc>".replace("[", "").replace("]", ""))
    write_aircraft(
        "x", aero="f16_aero.dml", inertia="f16_inertia.dml", propulsion=file, folder=folder
    )
    return file


def test_jsbsim_computes_what_the_model_does(tmp_path):
    model = DaveModel(written(tmp_path))
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm, draw = jsbsim.FGFDMExec(str(tmp_path)), random.Random(4)
    assert fdm.load_model("x")
    fdm["ic/h-sl-ft"] = 10000.0
    for _ in range(200):
        at = {name: draw.uniform(-1.5, 4.0) for name in "abc"}
        for name, value in at.items():
            fdm[f"x/{name}"] = value
        fdm.run_ic()
        found = model.evaluate(at)
        for name in (*FORMULAS, "cube", "line", "held", "both"):
            assert fdm[f"x/propulsion/{name}"] == pytest.approx(found[name], abs=1e-9), name
        forces = [fdm[f"forces/fb{axis}-external-lbs"] for axis in "xyz"]
        moments = [fdm[f"moments/{axis}-external-lbsft"] for axis in "lmn"]
        assert forces + moments == pytest.approx([i * found["sum"] for i in range(1, 7)], abs=1e-9)


def test_properties_of_ones_own(tmp_path):
    written(tmp_path)
    named = {"a": "attitude/theta-rad", "b": "fcs/elevator-pos-rad"}
    models = {"aero": "f16_aero.dml", "inertia": "f16_inertia.dml"}
    write_aircraft(
        "y", **models, propulsion=tmp_path / "engine.dml", folder=tmp_path, properties=named
    )
    fdm = jsbsim.FGFDMExec(str(tmp_path))
    assert fdm.load_model("y")
    fdm["fcs/elevator-pos-rad"] = 0.25
    fdm.run_ic()
    assert fdm["y/propulsion/size"] == 0.25
    assert not fdm.get_property_manager().hasNode("y/b")
    for bad, said in (
        ({"el": "fcs/elevator-pos-rad"}, "properties: none of the models has an input 'el'"),
        ({"a": "fcs/elevator pos"}, r"properties\['a'\] must be the name of a property"),
        ({"a": 1.0}, r"properties\['a'\] must be the name of a property"),
    ):
        with pytest.raises(ParameterError, match=said):
            write_aircraft(
                "z", **models, propulsion=tmp_path / "engine.dml", folder=tmp_path, properties=bad
            )
    assert not (tmp_path / "aircraft" / "z").exists()
