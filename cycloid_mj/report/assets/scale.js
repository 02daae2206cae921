"use strict";
// Arrays, numbers and SVG: what every figure of the page needs.

const SVG = "http://www.w3.org/2000/svg";

/** Give a typed array and its shape from {shape, f32}. */
function decoded({ shape, f32 }) {
  const text = atob(f32);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const values = new Float32Array(bytes.buffer);
  values.shape = shape;
  return values;
}

/** Decode every array of a nested value. */
function unpacked(value) {
  if (value === null || typeof value !== "object") return value;
  if (typeof value.f32 === "string") return decoded(value);
  if (Array.isArray(value)) return value.map(unpacked);
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, unpacked(item)]));
}

/** Make an SVG element with attributes, inside a parent. */
function element(parent, name, attributes = {}, text = null) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== null) made.textContent = text;
  parent.appendChild(made);
  return made;
}

/** Give round numbers within [low, high], about `count` of them. */
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= 0.7 * raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  found.step = step;
  return found;
}

const minus = (text) => text.replace("-", "\u2212");

/** Write a tick's number with the digits that its step needs. */
function tickText(value, step) {
  if (value !== 0 && (Math.abs(value) >= 1e6 || step < 1e-7)) return minus(value.toExponential(1));
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = value.toFixed(digits);
  return minus(Number(text) === 0 ? (0).toFixed(digits) : text);
}

/** Write a number with five significant digits. */
function numberText(value) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return minus(value.toExponential(3));
  return minus(Number(value.toPrecision(5)).toString());
}

/** Give the first index at which an increasing array is not below a value. */
function search(values, value) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Give the index of the nearest value of an increasing array. */
function nearest(values, value) {
  const after = Math.min(search(values, value), values.length - 1);
  return after > 0 && value - values[after - 1] < values[after] - value ? after - 1 : after;
}
