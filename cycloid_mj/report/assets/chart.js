"use strict";
// Charts over a shared x axis: panels above each other, a cursor and a zoom in common.

/** What charts share: the span that is seen, the cursor, and who wants to know. */
class View {
  constructor(span) {
    this.home = span;
    this.span = span;
    this.cursor = null;
    this.listeners = [];
  }

  on(listener) {
    this.listeners.push(listener);
  }

  zoom(span) {
    const [low, high] = [Math.max(span[0], this.limits?.[0] ?? -Infinity), Math.min(span[1], this.limits?.[1] ?? Infinity)];
    if (!(high - low > 1e-9 * Math.max(1, Math.abs(high)))) return;
    this.span = [low, high];
    for (const listener of this.listeners) listener("span");
  }

  point(x, source = null) {
    this.cursor = x;
    for (const listener of this.listeners) listener("cursor", source);
  }
}

const MARGIN = { right: 10, top: 20, gap: 26, bottom: 34 };
const PANEL = 118;
const LETTER = 6.9;
/** Steps of a chart's table, and of its keyboard cursor. */
const VALUES = 60;

/** One figure: `panels` of {label, curves: [{name, x, offset, y, colour, width}], height, zero}. */
class Chart {
  constructor(place, view, panels, { xLabel, marks = [], shaded = null }) {
    Object.assign(this, { place, view, panels, xLabel, marks, shaded });
    this.width = 0;
    view.on((what) => (what === "span" ? this.draw() : this.showCursor()));
    new ResizeObserver(() => {
      const width = Math.round(place.clientWidth);
      if (width && width !== this.width) this.draw();
    }).observe(place);
    Chart.all.push(this);
    this.draw();
    this.offerValues();
  }

  /** Name the chart: the caption's title, else the labels of its panels. */
  get name() {
    const caption = this.place.closest("figure")?.querySelector("figcaption b")?.textContent;
    return caption ?? this.panels.map((panel) => panel.label).join(", ");
  }

  /** Let the keyboard read the values at a place along x, and open the values that are seen as a table. */
  offerValues() {
    const reader = Object.assign(document.createElement("input"), { type: "range", className: "reader", min: 0, max: VALUES, value: 0 });
    reader.setAttribute("aria-label", `Values along ${this.xLabel}: ${this.name}`);
    const at = () => this.view.span[0] + (reader.valueAsNumber / VALUES) * (this.view.span[1] - this.view.span[0]);
    const say = () => reader.setAttribute("aria-valuetext", this.rowAt(at()).map((cell, i) => `${this.heads[i]} ${cell}`).join(", "));
    reader.addEventListener("input", () => {
      this.view.point(at());
      say();
    });
    say();
    const details = document.createElement("details");
    details.className = "values-of";
    details.innerHTML = '<summary>Values</summary><div class="scroll" tabindex="0" role="region"></div>';
    details.lastChild.setAttribute("aria-label", `Values: ${this.name}`);
    details.addEventListener("toggle", () => details.open && this.fillTable(details.lastChild));
    this.place.after(reader);
    (this.place.closest("figure") ?? this.place.parentElement).append(details);
  }

  get heads() {
    return [this.xLabel, ...this.panels.flatMap((panel) => panel.curves.map((curve) => [panel.label, curve.name].filter(Boolean).join(", ")))];
  }

  /** Give the values of all curves at a place along x, as text. */
  rowAt(at) {
    const values = this.panels.flatMap((panel) => panel.curves.map((curve) => curve.y[nearest(curve.x, at - curve.offset)]));
    return [at, ...values].map(numberText);
  }

  /** Write a table of values over the span that is seen. */
  fillTable(place) {
    const [low, high] = this.view.span;
    const table = document.createElement("table");
    const add = (part, cells, first) => {
      const row = part.insertRow();
      cells.forEach((text, i) => {
        const cell = document.createElement(i === 0 || first === "col" ? "th" : "td");
        if (cell.tagName === "TH") cell.scope = first;
        cell.textContent = text;
        row.append(cell);
      });
    };
    add(table.createTHead(), this.heads, "col");
    const body = table.createTBody();
    for (let i = 0; i <= VALUES; i++) add(body, this.rowAt(low + (i / VALUES) * (high - low)), "row");
    place.replaceChildren(table);
  }

  /** Draw at the width of the place, or at another: it is stretched to the place. */
  draw(width = this.place.clientWidth) {
    this.width = Math.max(240, Math.round(width) || 600);
    const heights = this.panels.map((panel) => Math.round(PANEL * panel.height));
    const axes = this.panels.map((panel, index) => this.axis(panel, heights[index]));
    const longest = Math.max(...axes.flatMap(({ marks }) => marks.map((value) => tickText(value, marks.step).length)));
    const left = (this.left = 14 + LETTER * Math.max(4, longest));
    const inner = this.width - left - MARGIN.right;
    const total = MARGIN.top + heights.reduce((a, b) => a + b, 0) + MARGIN.gap * (heights.length - 1) + MARGIN.bottom;
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${total}`);
    this.svg.setAttribute("role", "img");
    this.svg.setAttribute("aria-label", this.name);
    this.place.replaceChildren(this.svg);
    const [low, high] = this.view.span;
    this.x = (value) => left + ((value - low) / (high - low)) * inner;
    this.unx = (pixel) => low + ((pixel - left) / inner) * (high - low);
    this.readouts = [];
    let top = MARGIN.top;
    this.panels.forEach((panel, index) => {
      this.drawPanel(panel, axes[index], top, heights[index], inner);
      top += heights[index] + (index < heights.length - 1 ? MARGIN.gap : 0);
    });
    this.drawXAxis(top, inner);
    this.line = element(this.svg, "line", { class: "cursor", y1: MARGIN.top, y2: top, visibility: "hidden" });
    this.chosen = element(this.svg, "rect", { class: "chosen", y: MARGIN.top, height: top - MARGIN.top, width: 0 });
    const area = { x: left, y: MARGIN.top - 14, width: inner, height: top - MARGIN.top + 14, class: "catch" };
    this.listen(element(this.svg, "rect", area));
    this.showCursor();
  }

  /** Give a panel's samples that are seen, its range and its ticks. */
  axis(panel, height) {
    const visible = panel.curves.map((curve) => this.visible(curve));
    const [low, high] = this.range(panel, visible);
    return { visible, low, high, marks: ticks(low, high, Math.max(2, height / 32)) };
  }

  drawPanel(panel, { visible, low, high, marks }, top, height, inner) {
    const group = element(this.svg, "g");
    const { left } = this;
    const y = (value) => top + height - ((value - low) / (high - low)) * height;
    if (this.shaded) {
      const [from, to] = this.shaded.map((value) => Math.min(Math.max(this.x(value), left), left + inner));
      if (to > from) element(group, "rect", { class: "turn", x: from, width: to - from, y: top, height });
    }
    for (const value of marks) {
      element(group, "line", { class: "grid", x1: left, x2: left + inner, y1: y(value), y2: y(value) });
      const at = { x: left - 6, y: y(value) + 4, "text-anchor": "end" };
      element(group, "text", at, tickText(value, marks.step));
    }
    if (low < 0 && high > 0 && panel.zero) {
      element(group, "line", { class: "zero", x1: left, x2: left + inner, y1: y(0), y2: y(0) });
    }
    for (const mark of this.marks) {
      if (mark > this.view.span[0] && mark < this.view.span[1]) {
        element(group, "line", { class: "mesh", x1: this.x(mark), x2: this.x(mark), y1: top, y2: top + height });
      }
    }
    const clip = `clip-${Chart.clips++}`;
    const shape = element(element(group, "clipPath", { id: clip }), "rect", {});
    for (const [key, value] of Object.entries({ x: left, y: top, width: inner, height })) shape.setAttribute(key, value);
    const lines = element(group, "g", { "clip-path": `url(#${clip})` });
    panel.curves.forEach((curve, index) => {
      const d = this.path(curve, visible[index], y, inner);
      element(lines, "path", { class: "curve", d, style: `stroke:${curve.colour}`, "stroke-width": curve.width });
    });
    element(group, "line", { class: "axis", x1: left, x2: left + inner, y1: top + height, y2: top + height });
    element(group, "text", { x: 2, y: top - 9, "font-weight": 600 }, panel.label);
    const readout = element(group, "text", { x: left + inner, y: top - 7, "text-anchor": "end" });
    this.readouts.push({ panel, readout });
  }

  drawXAxis(top, inner) {
    const [low, high] = this.view.span;
    const marks = ticks(low, high, Math.max(2, inner / 90));
    for (const value of marks) {
      const at = { x: this.x(value), y: top + 15, "text-anchor": "middle" };
      element(this.svg, "text", at, tickText(value, marks.step));
      element(this.svg, "line", { class: "axis", x1: this.x(value), x2: this.x(value), y1: top, y2: top + 4 });
    }
    const at = { x: this.left + inner / 2, y: top + 30, "text-anchor": "middle", class: "soft" };
    element(this.svg, "text", at, this.xLabel);
  }

  /** Give the range of a curve's samples that are seen, with one more on both sides. */
  visible(curve) {
    const [low, high] = this.view.span;
    const from = Math.max(0, search(curve.x, low - curve.offset) - 1);
    return [from, Math.min(curve.x.length, search(curve.x, high - curve.offset) + 1)];
  }

  /** Give the y range of a panel: what is seen, with a margin. */
  range(panel, visible) {
    let low = Infinity;
    let high = -Infinity;
    panel.curves.forEach(({ y }, index) => {
      for (let i = visible[index][0]; i < visible[index][1]; i++) {
        if (y[i] < low) low = y[i];
        if (y[i] > high) high = y[i];
      }
    });
    if (!(low <= high)) return [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (panel.fromZero) return [0, 1.06 * (high || 1)];
    // single precision tells nothing apart that is closer than this
    const slack = high - low > 3e-7 * size ? 0.08 * (high - low) : 0.1 * size || 1;
    return [low - slack, high + slack];
  }

  /** Give the path of a curve; where samples are denser than pixels, from least to largest in each column. */
  path({ x, y, offset }, [from, to], toY, inner) {
    const parts = [];
    const put = (i) => parts.push(`${this.x(x[i] + offset).toFixed(1)},${toY(y[i]).toFixed(1)}`);
    if (to - from <= 3 * inner) {
      for (let i = from; i < to; i++) put(i);
    } else {
      for (let i = from; i < to; ) {
        const column = Math.floor(this.x(x[i] + offset));
        let [least, most] = [i, i];
        for (; i < to && Math.floor(this.x(x[i] + offset)) === column; i++) {
          if (y[i] < y[least]) least = i;
          if (y[i] > y[most]) most = i;
        }
        put(Math.min(least, most));
        if (least !== most) put(Math.max(least, most));
      }
    }
    return parts.length ? `M${parts.join("L")}` : "";
  }

  /** Show the cursor and each panel's values there; without one, the names of the curves. */
  showCursor() {
    const at = this.view.cursor;
    const seen = at !== null && at >= this.view.span[0] && at <= this.view.span[1];
    this.line.setAttribute("visibility", seen ? "visible" : "hidden");
    if (seen) {
      this.line.setAttribute("x1", this.x(at));
      this.line.setAttribute("x2", this.x(at));
    }
    for (const { panel, readout } of this.readouts) {
      readout.replaceChildren();
      panel.curves.forEach((curve, index) => {
        const value = seen ? numberText(curve.y[nearest(curve.x, at - curve.offset)]) : curve.name;
        if (!value) return;
        if (index && readout.childNodes.length) element(readout, "tspan", {}, "\u2002");
        element(readout, "tspan", { style: `fill:${curve.colour}`, "font-weight": 600 }, "\u25CF ");
        element(readout, "tspan", {}, value);
      });
    }
  }

  /** Follow the pointers: a mouse points and drags a span, one finger points, two fingers zoom. */
  listen(area) {
    const down = new Map();
    let start = null;
    const at = (event) => {
      const box = this.svg.getBoundingClientRect();
      const pixel = ((event.clientX - box.left) / box.width) * this.width;
      return this.unx(Math.min(Math.max(pixel, this.left), this.width - MARGIN.right));
    };
    area.addEventListener("pointerdown", (event) => {
      down.set(event.pointerId, event.clientX);
      if (event.pointerType === "mouse" && event.button === 0) start = at(event);
      if (down.size === 2) this.pinch = { span: [...this.view.span], reach: this.reach(down) };
      area.setPointerCapture(event.pointerId);
    });
    area.addEventListener("pointermove", (event) => {
      if (down.has(event.pointerId)) down.set(event.pointerId, event.clientX);
      if (down.size === 2 && this.pinch) {
        this.choose(null);
        const now = this.reach(down);
        const [low, high] = this.pinch.span;
        const scale = Math.min(4, Math.max(0.25, this.pinch.reach.width / Math.max(20, now.width)));
        const middle = low + this.pinch.reach.middle * (high - low);
        const wide = (high - low) * scale;
        this.pinched = [middle - now.middle * wide, middle + (1 - now.middle) * wide];
        return;
      }
      const x = at(event);
      this.view.point(x, this);
      if (start !== null) this.choose([start, x]);
    });
    const end = (event) => {
      down.delete(event.pointerId);
      if (this.pinched) {
        const span = this.pinched;
        this.pinched = this.pinch = null;
        this.view.zoom(span);
      } else if (start !== null) {
        const span = [start, at(event)].sort((a, b) => a - b);
        start = null;
        this.choose(null);
        if (this.x(span[1]) - this.x(span[0]) > 6) this.view.zoom(span);
      }
    };
    area.addEventListener("pointerup", end);
    area.addEventListener("pointercancel", end);
    area.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse" && start === null) this.view.point(null, this);
    });
    area.addEventListener("dblclick", () => this.view.zoom(this.view.home));
  }

  /** Give width [px] and middle (share of the area) between two fingers. */
  reach(down) {
    const box = this.svg.getBoundingClientRect();
    const [a, b] = [...down.values()];
    return { width: Math.abs(a - b), middle: ((a + b) / 2 - box.left) / box.width };
  }

  choose(span) {
    const [from, to] = (span ?? [0, 0]).map(this.x).sort((a, b) => a - b);
    this.chosen.setAttribute("x", span ? from : 0);
    this.chosen.setAttribute("width", span ? to - from : 0);
  }
}
Chart.clips = 0;
Chart.all = [];
