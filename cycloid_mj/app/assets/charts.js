// Charts as SVG: lines over an angle, bars, histograms. All numbers are computed by the server.

import { el, svg, number, fill } from "./dom.js";

const QUARTERS = [0, 90, 180, 270, 360];
const W = 560, H = 230, LEFT = 56, RIGHT = 20, TOP = 12, BOTTOM = 38;

function ticks(low, high, count = 5) {
  const span = high - low || 1, rough = span / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map(one => one * power).find(one => one >= rough);
  const found = [];
  for (let at = Math.ceil(low / step - 1e-9) * step; at <= high + 1e-9 * span; at += step) found.push(Number(at.toPrecision(10)));
  return found;
}

// `steps` are the tick marks along x; by default round numbers.
function frame(x, y, labels, steps = ticks(...x, 6)) {
  const across = value => LEFT + (value - x[0]) / (x[1] - x[0] || 1) * (W - LEFT - RIGHT);
  const up = value => H - BOTTOM - (value - y[0]) / (y[1] - y[0] || 1) * (H - TOP - BOTTOM);
  const axes = svg("g", { class: "axes" },
    ticks(...y).map(at => [svg("line", { x1: LEFT, x2: W - RIGHT, y1: up(at), y2: up(at) }), svg("text", { x: LEFT - 7, y: up(at) + 4, "text-anchor": "end" }, number(at))]),
    steps.map(at => svg("text", { x: across(at), y: H - BOTTOM + 17, "text-anchor": "middle" }, number(at))),
    svg("text", { x: (W + LEFT - RIGHT) / 2, y: H - 4, "text-anchor": "middle", class: "label" }, labels[0]),
    svg("text", { x: -(H - BOTTOM + TOP) / 2, y: 13, "text-anchor": "middle", class: "label", transform: "rotate(-90)" }, labels[1]));
  return { across, up, axes };
}

const chart = (title, ...inside) => svg("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": title, class: "chart" }, ...inside);

// Lines over the crank angle: series of {name, y, look} with common `x`. The values at the cursor are shown below.
export function lines(title, x, series, labels) {
  const all = series.flatMap(one => one.y);
  const [low, high] = [Math.min(0, ...all), Math.max(0, ...all)], room = 0.06 * (high - low || 1);
  const { across, up, axes } = frame([x[0], x[x.length - 1]], [low < 0 ? low - room : low, high + room], labels, QUARTERS);
  const cursor = svg("line", { class: "cursor", y1: TOP, y2: H - BOTTOM, x1: -9, x2: -9 });
  const data = el("figcaption", {});
  const key = () => fill(data, ...series.filter(one => one.name).map(one => el("span", { class: `key ${one.look}` }, one.name)));
  key();
  const drawn = chart(title, axes, series.map(one => svg("polyline", { class: one.look, points: one.y.map((value, at) => `${across(x[at]).toFixed(1)},${up(value).toFixed(1)}`).join(" ") })), cursor);
  drawn.addEventListener("pointermove", event => {
    const box = drawn.getBoundingClientRect(), at = (event.clientX - box.left) / box.width * W;
    let near = 0;
    x.forEach((value, place) => { if (Math.abs(across(value) - at) < Math.abs(across(x[near]) - at)) near = place; });
    cursor.setAttribute("x1", across(x[near]));
    cursor.setAttribute("x2", across(x[near]));
    fill(data, el("span", {}, `${number(x[near])}°`), ...series.filter(one => one.name).map(one => el("span", { class: `key ${one.look}` }, `${one.name}: ${number(one.y[near])}`)));
  });
  drawn.addEventListener("pointerleave", () => { cursor.setAttribute("x1", -9); cursor.setAttribute("x2", -9); key(); });
  return el("figure", {}, el("h3", {}, title), drawn, data);
}

// Vertical bars at orders; `named` highlights some of them: [order, name] each. The names are drawn above all bars.
export function spikes(title, orders, values, labels, named) {
  const most = Math.max(...orders, 1), { across, up, axes } = frame([0, 1.02 * most], [0, 1.12 * Math.max(...values) || 1], labels);
  const wide = Math.min(9, Math.max(2, 0.5 * (across(1) - across(0))));
  const name = order => named.filter(([at]) => Math.abs(at - order) < 1e-3).map(([, word]) => word).join(", ");
  const bar = (value, at) => svg("rect", { x: across(orders[at]) - wide / 2, y: up(value), width: wide, height: Math.max(0, up(0) - up(value)), class: name(orders[at]) ? "spike named" : "spike" }, svg("title", {}, `Order ${number(orders[at])}: ${number(value)}`));
  const word = (value, at) => name(orders[at]) ? svg("text", { x: across(orders[at]), y: Math.max(TOP + 10, up(value) - 4), "text-anchor": "middle", class: "label over" }, name(orders[at])) : null;
  return el("figure", {}, el("h3", {}, title), chart(title, axes, values.map(bar), values.map(word)));
}

export function histogram(title, edges, counts, unit, marks) {
  const { across, up, axes } = frame([edges[0], edges[edges.length - 1]], [0, 1.12 * Math.max(...counts)], [unit, "drives"]);
  return el("figure", {}, el("h3", {}, title), chart(title, axes,
    counts.map((count, at) => svg("rect", { class: "spike", x: across(edges[at]) + 0.5, width: Math.max(0.5, across(edges[at + 1]) - across(edges[at]) - 1), y: up(count), height: up(0) - up(count) })),
    marks.map(([value, word]) => svg("g", {}, svg("line", { class: "quantile", x1: across(value), x2: across(value), y1: TOP + 5, y2: H - BOTTOM }), svg("text", { class: "label", x: across(value), y: TOP, "text-anchor": "middle" }, word)))),
    el("figcaption", {}, marks.map(([value, word]) => el("span", {}, `${word}: ${number(value, 3)} ${unit}`))));
}

// Horizontal bars: {name, share (0 to 1), text, look, title}.
export const bars = items => el("div", { class: "lying" }, items.map(one => {
  const fill = el("span", { class: `fill ${one.look || ""}` });
  fill.style.width = `${100 * Math.max(0, Math.min(1, one.share))}%`;
  return el("div", { class: "row", title: one.title || null }, el("span", { class: "what" }, one.name), el("span", { class: "track" }, fill, one.mark ? el("i", { class: "limit" }) : null), el("b", { class: one.look || null }, one.text));
}));
