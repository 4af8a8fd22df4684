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
let blocks = null, graph = null;
const findParts = async () => {
    const scripts = performance.getEntriesByType("resource").map(entry => entry.name)
        .filter(name => name.startsWith(`${location.origin}/app/immutable/chunks/`));
    const modules = await Promise.all(scripts.map(name => import(name)));
    const parts = modules.flatMap(module => Object.values(module));
    blocks = parts.find(part => part?.unregisterSource && part.has("Constant"));
    graph = parts.find(part => part?.nodesArray && part.toJSON);
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
    if (!graph) await findParts();
    const reason = path === "/api/stream/start" ? incomplete() : "";
    if (reason) return Response.json({type: "error", error: reason});
    const headers = {...options?.headers, "X-Session-ID": await session};
    return fetched(url, {...options, headers});
};
