"use strict";
// A path in the plane, equal scales on both axes, with a point that follows the cursor.

const PLANE = { size: 180, left: 44, bottom: 32, top: 8, right: 8 };

class Plane {
  /** `paths` of {x, y (interleaved), colour, width}; `circle` is a radius about the origin. */
  constructor(place, paths, unit, circle) {
    const { size, left, bottom, top, right } = PLANE;
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", `0 0 ${size + left + right} ${size + top + bottom}`);
    svg.setAttribute("role", "img");
    const caption = place.closest("figure")?.querySelector("figcaption b")?.textContent ?? "";
    svg.setAttribute("aria-label", `Path over one crank turn: ${caption}`);
    place.replaceChildren(svg);
    const box = this.box(paths, circle);
    const x = (value) => left + ((value - box.x) / box.reach) * size;
    const y = (value) => top + size - ((value - box.y) / box.reach) * size;
    const across = ticks(box.x, box.x + box.reach, 4);
    for (const value of across) {
      element(svg, "line", { class: "grid", x1: x(value), x2: x(value), y1: top, y2: top + size });
      element(svg, "text", { x: x(value), y: top + size + 14, "text-anchor": "middle" }, tickText(value, across.step));
    }
    const up = ticks(box.y, box.y + box.reach, 4);
    for (const value of up) {
      element(svg, "line", { class: "grid", x1: left, x2: left + size, y1: y(value), y2: y(value) });
      element(svg, "text", { x: left - 5, y: y(value) + 4, "text-anchor": "end" }, tickText(value, up.step));
    }
    if (circle) {
      const radius = (circle / box.reach) * size;
      element(svg, "circle", { cx: x(0), cy: y(0), r: radius, fill: "none", class: "mesh" });
    }
    for (const path of paths) {
      const parts = [];
      for (let i = 0; i < path.points.length; i += 2) {
        parts.push(`${x(path.points[i]).toFixed(2)},${y(path.points[i + 1]).toFixed(2)}`);
      }
      const look = { class: "curve", style: `stroke:${path.colour}`, "stroke-width": path.width };
      element(svg, "path", { d: `M${parts.join("L")}`, ...look });
    }
    const label = { "text-anchor": "middle", class: "soft" };
    element(svg, "text", { ...label, x: left + size / 2, y: top + size + 28 }, `x [${unit}]`);
    const middle = top + size / 2;
    element(svg, "text", { ...label, x: 10, y: middle, transform: `rotate(-90 10 ${middle})` }, `y [${unit}]`);
  }

  box(paths, circle) {
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    if (circle) for (const k of [0, 1]) [low[k], high[k]] = [-circle, circle];
    for (const { points } of paths) {
      for (let i = 0; i < points.length; i++) {
        if (points[i] < low[i % 2]) low[i % 2] = points[i];
        if (points[i] > high[i % 2]) high[i % 2] = points[i];
      }
    }
    const reach = 1.12 * Math.max(high[0] - low[0], high[1] - low[1], 1e-9);
    return { x: (low[0] + high[0] - reach) / 2, y: (low[1] + high[1] - reach) / 2, reach };
  }
}
