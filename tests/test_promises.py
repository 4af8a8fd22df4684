"""Names, order and defaults of parameters and ports: models and scripts rely on each of them.

``data/promises.json`` lists them. Additions come last. What the last version had and this one has not
is listed under "gone", so that nothing else goes unseen.
"""

import importlib
import inspect
import json
import re
from importlib import metadata
from pathlib import Path

import pytest
from public_blocks import BLOCKS

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.cli import main

LISTS = json.loads((Path(__file__).parent / "data" / "promises.json").read_text())
PROMISES = LISTS["blocks"]
PUBLIC = {**BLOCKS, "TrimCondition": package.TrimCondition}
# a default is compared by its text, which tells 0 from 0.0 and from False


def promise(thing):
    """What the table says of a class."""
    parameters = list(inspect.signature(thing).parameters.values())
    kept = {"parameters": [[p.name, repr(p.default)] for p in parameters]}
    for side in ("inputs", "outputs"):
        labels = getattr(thing, f"{side[:-1]}_port_labels", None)
        kept[side] = labels and list(labels.items())
    return json.loads(json.dumps(kept))


def test_every_block_is_in_the_table():
    assert set(PROMISES) == set(PUBLIC), "add the new ones' promise() to data/promises.json"


@pytest.mark.parametrize("name", PROMISES)
def test_what_was_promised_is_kept_and_ports_are_numbered_in_their_order(name):
    now = promise(PUBLIC[name])
    for kind, promised in PROMISES[name].items():
        assert promised == (promised and now[kind][: len(promised)]), kind
    for side in ("inputs", "outputs"):
        ports = now[side] or []
        assert [number for _, number in ports] == list(range(len(ports)))


def named(name):
    """A public thing by its module's name and its own, or None."""
    module, _, own = name.rpartition(".")
    place = importlib.import_module(f"{package.__name__}.{module}".rstrip("."))
    return getattr(place, own, None) if own in getattr(place, "__all__", [own]) else None


def options(command, capsys):
    """The options that a command's help shows."""
    with pytest.raises(SystemExit):
        main([command, "--help"])
    return re.findall(r"--[a-z][\w-]*", capsys.readouterr().out)


def test_what_has_gone_since_the_last_version_is_listed(capsys):
    gone = []
    for name, parameters in LISTS["names"].items():
        if (thing := named(name)) is None:
            gone.append(name)
        elif parameters is not None:
            now = [*inspect.signature(thing).parameters]
            kept = [p for p in parameters if p in now]
            assert kept == [p for p in now if p in parameters], f"{name}: order"
            gone += [f"{name}({p})" for p in parameters if p not in now]
    with pytest.raises(SystemExit):
        main(["--help"])
    commands = capsys.readouterr().out
    for command, promised in LISTS["commands"].items():
        if not re.search(rf"^ +{command} ", commands, re.MULTILINE):
            gone.append(f"pathsim-jsbsim {command}")
        else:
            now = options(command, capsys)
            gone += [f"pathsim-jsbsim {command} {o}" for o in promised if o not in now]
    extras = metadata.metadata("pathsim-jsbsim-blocks").get_all("Provides-Extra")
    gone += sorted({*LISTS["extras"]} - {*extras})
    assert sorted(gone) == LISTS["gone"]
