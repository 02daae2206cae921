// Sliders and lists of the parameters, each with unit, range, description and an input field for its value.

import { el, number, fill } from "./dom.js";

const MAX_NARROW = 13; // characters of an option that are seen next to its label

const layouts = new Map(); // container -> keys and options of its controls

export function showControls(container, controls, apply) {
  const shape = controls.map(control => `${control.key}:${control.options.length}`).join();
  if (shape !== layouts.get(container)) {
    layouts.set(container, shape);
    const groups = new Map();
    for (const control of controls) groups.set(control.group, [...(groups.get(control.group) || []), control]);
    fill(container, ...[...groups].map(([group, inside]) => el("fieldset", {}, el("legend", {}, group),
      inside.map(control => control.options.length ? list(control, apply) : slider(control, apply)))));
  }
  for (const control of controls) update(container.querySelector(`[data-key="${control.key}"]`), control);
}

export function markControl(key, words) {
  const row = document.querySelector(`[data-key="${key}"]`);
  if (!row) return;
  row.classList.add("refused");
  row.querySelector(".said").textContent = words;
}

// Hide the controls that a text does not match; return the number of the others.
export function filterControls(container, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const group of container.querySelectorAll("fieldset")) {
    const name = group.querySelector("legend").textContent;
    let shown = 0;
    for (const row of group.querySelectorAll(".control")) {
      const all = `${name} ${row.querySelector("label").textContent} ${row.dataset.key} ${row.querySelector(".meaning").textContent}`.toLowerCase();
      row.hidden = !words.every(word => all.includes(word));
      shown += row.hidden ? 0 : 1;
    }
    group.hidden = !shown;
    count += shown;
  }
  return count;
}

const meaning = control => `${control.meaning} · ${control.key}`;

const described = control => ({ id: `k-${control.key}`, "aria-describedby": `m-${control.key}` });

function list(control, apply) {
  return el("div", { class: "control list", "data-key": control.key },
    el("label", { for: `k-${control.key}` }, control.label),
    el("select", { ...described(control), onchange: event => apply({ [control.key]: JSON.parse(event.target.value) }) }),
    el("span", { class: "meaning", id: `m-${control.key}` }), el("span", { class: "said" }));
}

function slider(control, apply) {
  const send = event => {
    const value = event.target.valueAsNumber;
    if (Number.isFinite(value)) apply({ [control.key]: value });
    else event.target.value = event.target.defaultValue;
  };
  return el("div", { class: "control", "data-key": control.key },
    el("label", { for: `k-${control.key}` }, control.label),
    el("span", { class: "value" }, el("input", { type: "number", step: "any", "aria-label": `${control.label}${control.unit ? ` in ${control.unit}` : ""}, typed`, onchange: send }), el("span", { class: "unit" }, control.unit)),
    el("input", { ...described(control), type: "range", oninput: send }),
    el("span", { class: "ends", "aria-hidden": "true" }, el("span", {}), el("span", {})),
    el("span", { class: "meaning", id: `m-${control.key}` }), el("span", { class: "said" }));
}

function update(row, control) {
  row.classList.remove("refused");
  row.querySelector(".said").textContent = "";
  row.querySelector(".meaning").textContent = meaning(control);
  const select = row.querySelector("select");
  if (select) {
    row.classList.toggle("long", control.options.some(([, words]) => words.length > MAX_NARROW));
    fill(select, ...control.options.map(([value, words]) => el("option", { value: JSON.stringify(value) }, words)));
    select.value = JSON.stringify(control.value);
    return;
  }
  const [range, typed, ends] = [row.querySelector("[type=range]"), row.querySelector("[type=number]"), row.querySelector(".ends")];
  const held = range === document.activeElement && control.value >= +range.min && control.value <= +range.max;
  if (!held) Object.assign(range, { min: Math.min(control.low, control.value), max: Math.max(control.high, control.value), step: control.step });
  if (!held || Math.abs(range.valueAsNumber - control.value) > control.step / 2) range.value = control.value;
  range.setAttribute("aria-valuetext", `${number(control.value, 6)} ${control.unit}`);
  range.style.setProperty("--at", `${100 * (range.valueAsNumber - range.min) / (range.max - range.min)}%`);
  typed.value = typed.defaultValue = Number(control.value.toPrecision(6));
  ends.firstChild.textContent = number(+range.min);
  ends.lastChild.textContent = number(+range.max);
}
