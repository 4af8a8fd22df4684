// Runs in PathView's page before PathView starts. page.py sets `toolboxes` and `seeded`.

// toolboxes are registered before PathView looks for them; the last of a name wins
const key = "pathview.toolboxes.v1";
let state = null;
try { state = JSON.parse(localStorage.getItem(key)); } catch {}
if (state?.version !== 1) state = {version: 1};
const others = (state.toolboxes ?? []).filter(o => !toolboxes.some(t => t.id === o.id));
state.toolboxes = [...others, ...toolboxes];
state.seededIds = [...new Set([...(state.seededIds ?? []), ...seeded])];
localStorage.setItem(key, JSON.stringify(state));

const fetched = window.fetch, pause = ms => new Promise(done => setTimeout(done, ms));

// PathView gives all pages of a browser one worker, and a page's calls end another page's run.
// A page here holds a worker by a lock, which ends with the page: then another page may take it.
const held = number => new Promise(answer => navigator.locks.request(
    `worker ${number}`, {ifAvailable: true}, lock => {
        answer(lock !== null);
        return lock && new Promise(() => {});
    }));
const session = (async () => {
    const profile = localStorage.getItem("flask-session-id") ?? crypto.randomUUID();
    localStorage.setItem("flask-session-id", profile);
    let number = 0;
    while (!await held(number)) number++;
    return `${profile}-${number}`;
})();

// PathView leaves unknown blocks out of a run, and saves them without their parameters
let blocks, graph, found;
const findParts = async () => {
    const scripts = performance.getEntriesByType("resource").map(entry => entry.name)
        .filter(name => name.startsWith(`${location.origin}/app/immutable/chunks/`));
    const modules = await Promise.all(scripts.map(name => import(name)));
    const parts = modules.flatMap(module => Object.values(module));
    blocks = parts.find(part => part?.unregisterSource && part.has("Constant"));
    graph = parts.find(part => part?.nodesArray && part.toJSON);
    graph.nodesArray.subscribe(makeRoom);
    graph.annotations.subscribe(all => { notes = [...all.values()]; });
    const add = graph.addNode;
    graph.addNode = (...given) => settle(add(...given));
};
const unknown = nodes => nodes.flatMap(node => [
    ...(["Subsystem", "Interface"].includes(node.type) || blocks.has(node.type)
        ? [] : [`${node.name} (${node.type})`]),
    ...unknown(node.graph?.nodes ?? []),
]);
const incomplete = () => {
    const missing = unknown(graph.toJSON().nodes);
    return missing.length ? `Unknown blocks: ${missing.join(", ")}. The diagram cannot run without `
        + "them, and is not saved, because their parameters would be lost. Reload the page, or add "
        + "their toolbox before you open the diagram." : "";
};
const guard = (object, method, concerned, say) => {
    const original = object?.[method];
    if (original) object[method] = function (...given) {
        const reason = concerned(...given) ? incomplete() : "";
        if (reason) {
            say(reason);
            throw new DOMException(reason, "AbortError");
        }
        return original.apply(this, given);
    };
};
guard(window, "showSaveFilePicker", () => true, alert);
guard(URL, "createObjectURL", blob => blob.type === "application/json", alert);
guard(window.FileSystemFileHandle?.prototype, "createWritable", () => true, () => {});
guard(IDBObjectStore.prototype, "put", (value, key) => key === "autosave", () => {});

// room for the names of ports inside a block (page.css), as in layout.py
const rooms = document.head.appendChild(document.createElement("style"));
const room = ports => 20 * Math.ceil((8 + 4 * Math.max(...ports.map(p => p.name.length), 0)) / 20);
const makeRoom = nodes => {
    const text = nodes.map(node => {
        const sides = [room(node.inputs), room(node.outputs)];
        if (node.params._rotation == 2) sides.reverse();
        const [left, right] = sides;
        return `[data-id="${CSS.escape(node.id)}"] { --left: ${left}px; --right: ${right}px }`;
    }).join("");
    if (rooms.textContent !== text) rooms.textContent = text;
};

// a fresh block shows what its ports are, and stands below a note that it would cover
let notes = [];
const named = ports => ports.some(port => !/^((in|out) \d+|in|out|y|\W)$/.test(port.name));
const settle = node => {
    if (!node) return node;
    const sides = [["Input", node.inputs], ["Output", node.outputs]].filter(side => named(side[1]));
    const width = sides.reduce((sum, side) => sum + room(side[1]), Math.max(80, 6 * node.name.length + 20));
    const height = 20 * Math.max(2, node.inputs.length, node.outputs.length);
    let {x, y} = node.position;
    for (const note of notes.toSorted((a, b) => a.position.y - b.position.y)) {
        const {x: left, y: top} = note.position;
        if (Math.abs(x - left - note.width / 2) < (width + note.width) / 2
            && Math.abs(y - top - note.height / 2) < (height + note.height) / 2)
            y = 10 * Math.ceil((top + note.height + height / 2) / 10) + 20;
    }
    graph.updateNodePosition(node.id, {x, y});
    graph.updateNodeParams(node.id, Object.fromEntries(sides.map(s => [`_show${s[0]}Labels`, true])));
    return node;
};

// PathView fits the blocks into the window, not the wires around them: zoom out until these are seen
const showWhole = async () => {
    const shown = () => [...document.querySelectorAll(".svelte-flow__edge-path")].map(
        wire => wire.getBoundingClientRect());
    let busy = false, before = "", still = 0;
    const over = new AbortController(), options = {capture: true, signal: over.signal};
    for (const kind of ["pointerdown", "keydown", "wheel"])
        addEventListener(kind, event => { busy ||= event.isTrusted; }, options);
    for (let i = 0; i < 100 && still < 4 && !busy; i++) {
        await pause(250);
        const now = JSON.stringify(shown());
        still = now === before && now !== "[]" ? still + 1 : 0;
        before = now;
    }
    const outside = () => shown().some(wire => wire.left < 0 || wire.right > innerWidth
        || wire.top < 40 || wire.bottom > innerHeight);
    for (let i = 0; i < 4 && !busy && outside(); i++) {
        document.body.dispatchEvent(new KeyboardEvent("keydown", {key: "-", bubbles: true}));
        await pause(400);
    }
    over.abort();
};

window.fetch = async (url, options) => {
    const path = new URL(url, location).pathname;
    if (path.startsWith("/model/")) {
        // a model that opens before its toolboxes are there is drawn, and wired, at wrong sizes
        const ready = "button[aria-label='Run']:not([disabled])";
        for (let i = 0; i < 600 && !document.querySelector(ready); i++) await pause(100);
        showWhole();
    }
    if (!path.startsWith("/api/")) return fetched(url, options);
    await (found ??= findParts());
    const reason = path === "/api/stream/start" ? incomplete() : "";
    if (reason) return Response.json({type: "error", error: reason});
    const headers = {...options?.headers, "X-Session-ID": await session};
    return fetched(url, {...options, headers});
};
