"""An aircraft in a diagram, with sources at its inputs and a scope at its outputs."""

from types import MappingProxyType

from pathsim import Connection, Simulation
from pathsim.blocks import Scope


def diagram(
    plane, shown=(), sources=MappingProxyType({}), others=(), wires=(), inputs=False, **options
):
    """The simulation and its scope of the outputs ``shown``.

    ``sources`` are blocks by the input that they drive, which the scope shows too, after the
    outputs, if ``inputs``; ``others`` and ``wires`` are further blocks and their connections.
    """
    scope = Scope()
    seen = [*(plane[port] for port in shown), *(sources.values() if inputs else ())]
    sim = Simulation(
        [plane, scope, *sources.values(), *others],
        [
            *(Connection(source, plane[port]) for port, source in sources.items()),
            *(Connection(signal, scope[i]) for i, signal in enumerate(seen)),
            *wires,
        ],
        **{"dt": plane.T, "log": False, **options},
    )
    return sim, scope
