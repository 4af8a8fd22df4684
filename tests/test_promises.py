"""Names, order and defaults of parameters and ports: models and scripts rely on each of them.

``data/promises.json`` lists them. Additions come last.
"""

import inspect
import json
from pathlib import Path

from how_many import each
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package

PROMISES = json.loads((Path(__file__).parent / "data" / "promises.json").read_text())
PUBLIC = {
    name: thing
    for name in package.__all__
    if inspect.isclass(thing := getattr(package, name))
    and (issubclass(thing, Block) or name == "TrimCondition")
}
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


@each(PROMISES)
def test_what_was_promised_is_kept(name):
    now = promise(PUBLIC[name])
    for kind, promised in PROMISES[name].items():
        assert promised == (promised and now[kind][: len(promised)]), kind


@each(PROMISES)
def test_ports_are_numbered_in_their_order(name):
    for side in ("inputs", "outputs"):
        ports = promise(PUBLIC[name])[side] or []
        assert [number for _, number in ports] == list(range(len(ports)))
