// Short forms to create elements, and the formats of numbers and judgements.

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key in element && element.namespaceURI !== SVG && typeof value !== "string") element[key] = value;
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...there(children));
  return element;
}

const there = children => children.flat(3).filter(one => one !== null && one !== undefined && one !== false && one !== "");

export const el = (tag, attributes, ...children) => filled(document.createElement(tag), attributes, children);
export const svg = (tag, attributes, ...children) => filled(document.createElementNS(SVG, tag), attributes, children);
export const fill = (element, ...children) => element.replaceChildren(...there(children));

// Replace the children of an element that may contain the focus: it moves to the new child with the same id or text, else to the element.
export function refill(element, ...children) {
  const held = element.contains(document.activeElement) && document.activeElement;
  fill(element, ...children);
  if (!held || held === element) return;
  const same = one => one.tagName === held.tagName && !one.disabled && (held.id ? one.id === held.id : one.textContent === held.textContent);
  ([...element.querySelectorAll("a, button, input, summary")].find(same) || element).focus({ preventScroll: true });
}

// How a judgement of the server is shown: its mark, its style and its word for screen readers.
export const JUDGED = {
  passed: { mark: "✓", look: "holds", word: "passed" },
  warning: { mark: "!", look: "near", word: "warning" },
  failed: { mark: "✗", look: "fails", word: "failed" },
  "not applicable": { mark: "–", look: "", word: "no limit" },
};

export const byId = id => document.getElementById(id);

// Format a number with significant digits, without an exponent between 1e-4 and 1e7.
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(digits - 1).replace("e+", "e");
  if (size >= 10 ** digits) return String(Math.round(value));
  return String(Number(value.toPrecision(digits)));
}

let hiding;
export function toast(words) {
  const box = byId("toast");
  box.textContent = words;
  box.hidden = false;
  clearTimeout(hiding);
  hiding = setTimeout(() => { box.hidden = true; }, 6000);
}

// Say something to screen readers, once nothing else has been said for a moment.
const QUIET = 700; // ms
let saying;
export function announce(words) {
  clearTimeout(saying);
  saying = setTimeout(() => { byId("says").textContent = words; }, QUIET);
}
