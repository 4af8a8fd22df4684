() => {
    const box = e => e.getBoundingClientRect(), shown = q => [...document.querySelectorAll(q)];
    const touch = (a, b) => a.left < b.right && b.left < a.right
        && a.top < b.bottom && b.top < a.bottom;
    const names = shown(".port-label, .node-name, .node-type, .pinned-param label");
    const wires = shown(".svelte-flow__edge-path").flatMap(path => {
        const to = path.getScreenCTM(), length = path.getTotalLength();
        return Array.from({length: Math.ceil(length / 2) + 1}, (_, i) =>
            path.getPointAtLength(Math.min(2 * i, length)).matrixTransform(to));
    });
    const inside = (p, r) => p.x > r.left && p.x < r.right && p.y > r.top && p.y < r.bottom;
    return names.filter(name => {
        const rect = box(name);
        return (name.scrollWidth > name.clientWidth + 1 && getComputedStyle(name).overflow != "visible")
            || wires.some(point => inside(point, rect))
            || names.some(other => other !== name && touch(rect, box(other)));
    }).map(name => name.innerText);
}
