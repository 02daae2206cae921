// Sliders and lists of the parameters, each with unit, range, description and an input field for its value.

import { el, number, fill } from "./dom.js";

let layout = "";

export function showKnobs(place, knobs, apply) {
  const shape = knobs.map(knob => `${knob.key}:${knob.options.length}`).join();
  if (shape !== layout) {
    layout = shape;
    const groups = new Map();
    for (const knob of knobs) groups.set(knob.group, [...(groups.get(knob.group) || []), knob]);
    fill(place, ...[...groups].map(([group, inside]) => el("fieldset", {}, el("legend", {}, group),
      inside.map(knob => knob.options.length ? list(knob, apply) : slider(knob, apply)))));
  }
  for (const knob of knobs) update(place.querySelector(`[data-key="${knob.key}"]`), knob);
}

export function markKnob(key, words) {
  const row = document.querySelector(`[data-key="${key}"]`);
  if (!row) return;
  row.classList.add("refused");
  row.querySelector(".said").textContent = words;
}

const tip = knob => `${knob.meaning} · ${knob.key}`;

function list(knob, apply) {
  const id = `k-${knob.key}`;
  return el("div", { class: "knob list", "data-key": knob.key, "data-tip": tip(knob) },
    el("label", { for: id }, knob.label),
    el("select", { id, onchange: event => apply({ [knob.key]: JSON.parse(event.target.value) }) }),
    el("span", { class: "said" }));
}

function slider(knob, apply) {
  const id = `k-${knob.key}`;
  const send = event => {
    const value = event.target.valueAsNumber;
    if (Number.isFinite(value)) apply({ [knob.key]: value });
    else event.target.value = event.target.defaultValue;
  };
  return el("div", { class: "knob", "data-key": knob.key, "data-tip": tip(knob) },
    el("label", { for: id }, knob.label),
    el("span", { class: "value" }, el("input", { type: "number", step: "any", "aria-label": `${knob.label}${knob.unit ? ` in ${knob.unit}` : ""}, typed`, onchange: send }), el("span", { class: "unit" }, knob.unit)),
    el("input", { id, type: "range", oninput: send }),
    el("span", { class: "ends", "aria-hidden": "true" }, el("span", {}), el("span", {})),
    el("span", { class: "said" }));
}

function update(row, knob) {
  row.classList.remove("refused");
  row.querySelector(".said").textContent = "";
  row.dataset.tip = tip(knob);
  const select = row.querySelector("select");
  if (select) {
    fill(select, ...knob.options.map(([value, words]) => el("option", { value: JSON.stringify(value) }, words)));
    select.value = JSON.stringify(knob.value);
    return;
  }
  const [range, typed, ends] = [row.querySelector("[type=range]"), row.querySelector("[type=number]"), row.querySelector(".ends")];
  const held = range === document.activeElement && knob.value >= +range.min && knob.value <= +range.max;
  if (!held) Object.assign(range, { min: Math.min(knob.low, knob.value), max: Math.max(knob.high, knob.value), step: knob.step });
  if (!held || Math.abs(range.valueAsNumber - knob.value) > knob.step / 2) range.value = knob.value;
  range.setAttribute("aria-valuetext", `${number(knob.value, 6)} ${knob.unit}`);
  range.style.setProperty("--at", `${100 * (range.valueAsNumber - range.min) / (range.max - range.min)}%`);
  typed.value = typed.defaultValue = Number(knob.value.toPrecision(6));
  ends.firstChild.textContent = number(+range.min);
  ends.lastChild.textContent = number(+range.max);
}
