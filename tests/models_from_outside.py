"""Models as other people have them: bundled ones, changed, below a JSBSim root of their own.

``changed`` is the factory; the functions after it make the kinds that several tests fly.
"""

import re
import shutil
from pathlib import Path

import jsbsim

BUNDLED = Path(jsbsim.get_default_root_dir())

ELECTRIC = '<electric_engine name="motor"><power unit="WATTS">{}</power></electric_engine>'


def changed(root, aircraft, *changes, files=None):
    """A JSBSim root with one bundled aircraft, its file changed; returns it as text.

    Each change is a regular expression and its replacement (text or function), which must match;
    ``files`` are texts by their path below the root, such as "engine/motor.xml".
    """
    root = Path(root)
    for part in (f"aircraft/{aircraft}", "engine", "systems"):
        shutil.copytree(BUNDLED / part, root / part, dirs_exist_ok=True)
    xml = root / "aircraft" / aircraft / f"{aircraft}.xml"
    text = xml.read_text(encoding="utf-8")
    for pattern, replacement in changes:
        text, number = re.subn(pattern, replacement, text, flags=re.DOTALL)
        assert number, f"{pattern!r} is not in {xml.name}"
    xml.write_text(text, encoding="utf-8")
    for path, content in (files or {}).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content, encoding="utf-8")
    return str(root)


def before(tag, text):
    """The change that puts a text before the first opening of a tag."""
    return rf"\A(.*?)(?=<{tag}\b)", lambda match: match[1] + text


def electric_single(root, watts=120_000.0, aircraft="c172x"):
    """The c172x (or c172p) with an electric motor at its propeller of fixed pitch."""
    return changed(root, aircraft, files={"engine/eng_io320.xml": ELECTRIC.format(watts)})


def light_propeller(root, fraction):
    """c172p with an electric motor and a fraction of its propeller's moment of inertia."""
    propeller = (BUNDLED / "engine/prop_75in2f.xml").read_text(encoding="utf-8")
    inertia = re.search(r"(<ixx>)(.*?)(</ixx>)", propeller)
    light = f"{inertia[1]} {float(inertia[2]) / fraction} {inertia[3]}"
    files = {"engine/eng_io320.xml": ELECTRIC.format(110_000)}
    files["engine/prop_75in2f.xml"] = propeller.replace(inertia[0], light)
    return changed(root, "c172p", files=files)


def electric_twin(root, watts=180_000.0):
    """The c310 with two electric motors at its constant-speed propellers."""
    return changed(root, "c310", files={"engine/engIO470D.xml": ELECTRIC.format(watts)})


def without_contents(root, aircraft="c172x"):
    """Tanks without contents, as in models that FlightGear fills."""
    return changed(root, aircraft, ("<contents.*?</contents>", ""))


def lever_writes_throttle(root):
    """A c172x that writes its throttle command itself, from a lever."""
    system = """<system name="lever"><property value="0.3">lever/norm</property>
    <channel name="throttle"><pure_gain name="lever/gain"><input>lever/norm</input><gain>1</gain>
    <output>fcs/throttle-cmd-norm</output></pure_gain></channel></system>"""
    return changed(root, "c172x", before("aerodynamics", system))


def digital_throttle(root, steps):
    """A c172p whose engine control has a throttle with this number of steps."""
    control = f"""<channel name="engine control"><fcs_function name="fcs/throttle-digital">
    <function><quotient><floor><product><value>{steps}</value><property>fcs/throttle-cmd-norm
    </property></product></floor><value>{steps}</value></quotient></function>
    <output>fcs/throttle-pos-norm</output></fcs_function></channel>"""
    pitch = r'(<channel name="Pitch">)', lambda match: control + match[1]
    return changed(root, "c172p", pitch)


def without_pitch_command(root):
    """A c172x whose elevator follows neither the elevator command nor the pitch trim."""
    commands = r"<input>\s*fcs/elevator-cmd-norm\s*</input>\s*<input>\s*fcs/pitch-trim-cmd-norm"
    rates = "<input>velocities/p-rad_sec</input><input>velocities/p-rad_sec"
    return changed(root, "c172x", (commands, rates))
