// Charts as SVG, drawn at the width that they have, each with its values as a table. All numbers come from the server.

import { el, svg, number, fill, JUDGED } from "./dom.js";

const QUARTERS = [0, 90, 180, 270, 360];
const RATIO = 0.41, MAX_HEIGHT = 320; // height over width of a chart, and its limit [px]
const LEFT = 56, RIGHT = 20, TOP = 14, BOTTOM = 40;
const WIDTH = 480; // px, until the page has its layout
const TABLE_ROWS = 73; // of a table of many values; others are left out evenly

function ticks(low, high, count = 5) {
  const span = high - low || 1, rough = span / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map(one => one * power).find(one => one >= rough);
  const found = [];
  for (let at = Math.ceil(low / step - 1e-9) * step; at <= high + 1e-9 * span; at += step) found.push(Number(at.toPrecision(10)));
  return found;
}

// Scales and axes of a chart [px]; `steps` are the tick marks along x, by default round numbers.
function frame(width, x, y, labels, steps = ticks(...x, width < 380 ? 4 : 6)) {
  const height = Math.min(MAX_HEIGHT, Math.round(RATIO * width) + BOTTOM);
  const across = value => LEFT + (value - x[0]) / (x[1] - x[0] || 1) * (width - LEFT - RIGHT);
  const up = value => height - BOTTOM - (value - y[0]) / (y[1] - y[0] || 1) * (height - TOP - BOTTOM);
  const axes = svg("g", { class: "axes" },
    ticks(...y).map(at => [svg("line", { x1: LEFT, x2: width - RIGHT, y1: up(at), y2: up(at) }), svg("text", { x: LEFT - 7, y: up(at) + 4, "text-anchor": "end" }, number(at))]),
    steps.map(at => svg("text", { x: across(at), y: height - BOTTOM + 17, "text-anchor": "middle" }, number(at))),
    svg("text", { x: (width + LEFT - RIGHT) / 2, y: height - 5, "text-anchor": "middle", class: "label" }, labels[0]),
    svg("text", { x: -(height - BOTTOM + TOP) / 2, y: 13, "text-anchor": "middle", class: "label", transform: "rotate(-90)" }, labels[1]));
  return { across, up, axes, height };
}

// A chart that is drawn again when its width changes: `draw` gets the width [px] and returns the height and children.
function chart(title, draw) {
  const drawn = svg("svg", { role: "img", "aria-label": title, class: "chart" });
  let seen = 0;
  const show = width => {
    if (Math.abs(width - seen) < 2) return;
    seen = width;
    const { height, inside } = draw(width);
    drawn.setAttribute("viewBox", `0 0 ${width} ${height}`);
    drawn.style.height = `${height}px`;
    fill(drawn, ...inside);
  };
  show(WIDTH);
  new ResizeObserver(([entry]) => { if (entry.contentRect.width > 0) show(Math.round(entry.contentRect.width)); }).observe(drawn);
  return drawn;
}

// The values of a chart as a table, which is built when it is opened.
function values(title, heads, rows) {
  const every = Math.max(1, Math.ceil(rows.length / TABLE_ROWS)), region = el("div", { class: "values", role: "region", tabindex: "0", "aria-label": `Values: ${title}` });
  const open = () => region.firstChild || region.append(el("table", {}, el("thead", {}, el("tr", {}, heads.map(head => el("th", { scope: "col" }, head)))),
    el("tbody", {}, rows.filter((_, at) => at % every === 0).map(row => el("tr", {}, row.map((value, at) => el(at ? "td" : "th", at ? {} : { scope: "row" }, typeof value === "number" ? number(value) : value)))))));
  return el("details", { class: "values-of", ontoggle: open }, el("summary", {}, "Values"), region);
}

// Lines over the crank angle: series of {name, y, look} with common `x`. The values at the cursor are shown below.
export function lines(title, x, series, labels) {
  const all = series.flatMap(one => one.y);
  const [low, high] = [Math.min(0, ...all), Math.max(0, ...all)], room = 0.06 * (high - low || 1);
  const data = el("figcaption", {}), named = series.filter(one => one.name);
  let cursor, across, height, near = -1;
  const mark = () => {
    for (const end of ["x1", "x2"]) cursor.setAttribute(end, near < 0 ? -9 : across(x[near]));
    fill(data, near < 0 ? null : el("span", {}, `${number(x[near])}°`), ...named.map(one => el("span", { class: `key ${one.look}` }, near < 0 ? one.name : `${one.name}: ${number(one.y[near])}`)));
  };
  const drawn = chart(title, width => {
    const scales = frame(width, [x[0], x[x.length - 1]], [low < 0 ? low - room : low, high + room], labels, QUARTERS);
    ({ across, height } = scales);
    cursor = svg("line", { class: "cursor", y1: TOP, y2: height - BOTTOM, x1: -9, x2: -9 });
    mark();
    return { height, inside: [scales.axes, series.map(one => svg("polyline", { class: one.look, points: one.y.map((value, at) => `${across(x[at]).toFixed(1)},${scales.up(value).toFixed(1)}`).join(" ") })), cursor] };
  });
  drawn.addEventListener("pointermove", event => {
    const at = event.clientX - drawn.getBoundingClientRect().left;
    near = x.reduce((best, value, index) => (Math.abs(across(value) - at) < Math.abs(across(x[best]) - at) ? index : best), 0);
    mark();
  });
  drawn.addEventListener("pointerleave", () => { near = -1; mark(); });
  const words = at => `${number(x[at])} degrees: ${named.map(one => `${one.name} ${number(one.y[at])}`).join(", ")}`;
  const reader = el("input", { type: "range", class: "reader", min: "0", max: String(x.length - 1), value: "0", "aria-label": `Values at a crank angle: ${title}`, "aria-valuetext": words(0),
    oninput: event => { near = event.target.valueAsNumber; event.target.setAttribute("aria-valuetext", words(near)); mark(); }, onblur: () => { near = -1; mark(); } });
  return el("figure", {}, el("h3", {}, title), drawn, reader, data, values(title, [labels[0], ...series.map(one => one.name)], x.map((at, row) => [at, ...series.map(one => one.y[row])])));
}

// Vertical bars at orders; `named` highlights some of them: [order, name] each. The names are drawn above all bars.
export function spikes(title, orders, sizes, labels, named) {
  const most = Math.max(...orders, 1), name = order => named.filter(([at]) => Math.abs(at - order) < 1e-3).map(([, word]) => word).join(", ");
  const drawn = chart(title, width => {
    const { across, up, axes, height } = frame(width, [0, 1.02 * most], [0, 1.12 * Math.max(...sizes) || 1], labels);
    const wide = Math.min(9, Math.max(2, 0.5 * (across(1) - across(0))));
    const bar = (value, at) => svg("rect", { x: across(orders[at]) - wide / 2, y: up(value), width: wide, height: Math.max(0, up(0) - up(value)), class: name(orders[at]) ? "spike named" : "spike" }, svg("title", {}, `Order ${number(orders[at])}: ${number(value)}`));
    const word = (value, at) => name(orders[at]) ? svg("text", { x: across(orders[at]), y: Math.max(TOP + 10, up(value) - 4), "text-anchor": "middle", class: "label over" }, name(orders[at])) : null;
    return { height, inside: [axes, ...sizes.map(bar), ...sizes.map(word).filter(Boolean)] };
  });
  return el("figure", {}, el("h3", {}, title), drawn, values(title, [...labels, "name"], orders.map((order, at) => [order, sizes[at], name(order)])));
}

export function histogram(title, edges, counts, unit, marks) {
  const drawn = chart(`${title}: ${marks.map(([value, word]) => `${word} ${number(value, 3)} ${unit}`).join(", ")}`, width => {
    const { across, up, axes, height } = frame(width, [edges[0], edges[edges.length - 1]], [0, 1.12 * Math.max(...counts)], [unit, "drives"]);
    return { height, inside: [axes,
      ...counts.map((count, at) => svg("rect", { class: "spike", x: across(edges[at]) + 0.5, width: Math.max(0.5, across(edges[at + 1]) - across(edges[at]) - 1), y: up(count), height: up(0) - up(count) })),
      ...marks.map(([value, word]) => svg("g", {}, svg("line", { class: "quantile", x1: across(value), x2: across(value), y1: TOP + 5, y2: height - BOTTOM }), svg("text", { class: "label", x: across(value), y: TOP, "text-anchor": "middle" }, word)))] };
  });
  return el("figure", {}, el("h3", {}, title), drawn, el("figcaption", {}, marks.map(([value, word]) => el("span", {}, `${word}: ${number(value, 3)} ${unit}`))),
    values(title, [`from [${unit}]`, `to [${unit}]`, "drives"], counts.map((count, at) => [edges[at], edges[at + 1], count])));
}

// Horizontal bars: {name, share (0 to 1), text, look, title}; the title is shown when the name is opened.
export const bars = items => el("div", { class: "lying" }, items.map(one => {
  const fill = el("span", { class: `fill ${one.look || ""}`, style: null });
  fill.style.width = `${100 * Math.max(0, Math.min(1, one.share))}%`;
  if (one.colour) fill.style.background = one.colour;
  const name = one.title ? el("details", { class: "what" }, el("summary", {}, one.name), el("p", { class: "soft" }, one.title)) : el("span", { class: "what" }, one.name);
  return el("div", { class: "row" }, name, el("span", { class: "track" }, fill, one.mark ? el("i", { class: "limit" }) : null), el("b", { class: one.look || null }, one.text));
}));

// Bars of judged rows: judgement and length of each bar come from the server.
export const judgedBars = (rows, line) => bars(rows.map(row => ({ name: row.name, share: row.share, text: `${JUDGED[row.judgement].mark} ${row.text}`, look: JUDGED[row.judgement].look, mark: line, title: row.title })));
