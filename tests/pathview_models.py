"""Models as PathView writes them, part by part."""


def block(name, kind, inputs=0, outputs=1, graph=None, **params):
    ports = {
        side: [{"id": f"{name}-{side}-{i}", "name": f"{i}", "index": i} for i in range(n)]
        for side, n in (("inputs", inputs), ("outputs", outputs))
    }
    return {
        "id": name,
        "type": kind,
        "name": name,
        "position": {"x": 0, "y": 0},
        "params": params,
        **({} if graph is None else {"graph": graph}),
        **ports,
    }


def subsystem(name, *nodes, inputs=0, outputs=0, **graph):
    return block(name, "Subsystem", inputs, outputs, {"nodes": list(nodes), **graph})


def wire(source, target, out=0, into=0):
    return {
        "id": f"{source}-{target}",
        "sourceNodeId": source,
        "sourcePortIndex": out,
        "targetNodeId": target,
        "targetPortIndex": into,
    }


def event(name, kind="pathsim.events.Schedule", **params):
    return {"type": kind, "name": name, "params": params}


def model(*nodes, events=(), code="", **graph):
    return {
        "version": "1.0.0",
        "metadata": {"name": "model", "created": "", "modified": ""},
        "graph": {"nodes": list(nodes), **graph},
        "events": list(events),
        "codeContext": {"code": code},
    }
