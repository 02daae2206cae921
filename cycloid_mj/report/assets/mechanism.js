"use strict";
// The moving mechanism and the load around its ring. Lengths in mm, x right and y up; gaps as cycloid_mj.scene.drawing has them.

// Colours are those of the classes in page.css.
const FORCES = ["ring", "cam", "output"];
/** Length of the largest force of a kind, as a share of the housing's radius. */
const LONGEST = 0.25;
const DEGREES = 180 / Math.PI;

const circlePath = (x, y, r) => `M${x - r},${y}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0Z`;

class Mechanism {
  constructor(figure, shape) {
    this.shape = shape;
    this.frames = shape.frames;
    this.count = this.frames.time.length;
    this.magnification = shape.magnifications[0];
    this.showForces = true;
    this.largest = Object.fromEntries(FORCES.map((kind) => [kind, largestForce(this.frames.force[kind])]));
    this.build(figure.querySelector(".mechanism"));
    this.clock = figure.querySelector(".clock");
    this.legend(figure.querySelector(".legend"));
    this.ring = new RingLoad(figure.querySelector(".ring"), shape, this.largest.ring);
  }

  build(place) {
    const reach = 1.06 * this.shape.housing;
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", `${-reach} ${-reach} ${2 * reach} ${2 * reach}`);
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", "Animated mechanism from the output side, with contact forces");
    place.replaceChildren(svg);
    const up = element(svg, "g", { transform: "scale(1,-1)", "stroke-width": 0.8 });
    const { angles, free, kind, outputPins, shaft, eccentricity } = this.shape;
    this.housing = element(up, "path", { class: "housing" });
    this.sockets = free ? this.many(up, "path", angles.length, { class: "socket" }) : [];
    this.gear = element(up, "g");
    element(this.gear, "path", { class: "gear", d: this.gearPath() });
    const between = (this.shape.wall - 2 * eccentricity + this.shape.outputCircle + this.shape.hole) / 2;
    element(this.gear, "circle", { cx: 0, cy: between, r: 0.8, class: "dot" });
    this.pins = kind === "pin" ? this.many(up, "g", angles.length, {}) : [];
    for (const pin of this.pins) {
      element(pin, "circle", { class: "pin" });
      element(pin, "line", { x1: 0, y1: 0, y2: 0, class: "pin" });
    }
    this.others = this.shape.others.map(({ gear }) => element(up, "path", { class: "other", d: polygon(gear) }));
    this.outputs = this.many(up, "circle", outputPins, { class: "output" });
    this.shaft = element(up, "g");
    this.cam = element(this.shaft, "circle", { class: "cam", cy: eccentricity });
    element(this.shaft, "circle", { class: "shaft", r: shaft });
    element(this.shaft, "circle", { cx: 0, cy: 0.8 * this.shape.bore, r: 0.8, style: "fill:var(--cam-edge)" });
    this.arrows = {};
    for (const group of FORCES) {
      const look = { class: `force-${group}`, "stroke-width": 1.8, "stroke-linejoin": "round" };
      this.arrows[group] = this.many(element(up, "g", look), "path", this.frames.force[group].shape[1], {});
    }
    this.resize();
  }

  /** Name the arrows' colours, with the largest force of each kind. */
  legend(place) {
    const names = { ring: this.shape.kind === "pin" ? "ring pins" : "internal gear", cam: "cam", output: "output pins" };
    const entries = Object.entries(names).map(([group, name]) => {
      const key = document.createElement("span");
      key.style.setProperty("--key", `var(--force-${group})`);
      key.textContent = `${name} up to ${numberText(Number(this.largest[group].toPrecision(3)))} N`;
      return key;
    });
    place.replaceChildren(...entries);
  }

  many(parent, name, count, look) {
    return Array.from({ length: count }, () => element(parent, name, look));
  }

  gearPath() {
    const { gear, bore, hole, outputCircle, outputPins } = this.shape;
    let d = polygon(gear) + circlePath(0, 0, bore);
    for (let k = 0; k < outputPins; k++) {
      const angle = (2 * Math.PI * k) / outputPins;
      d += circlePath(outputCircle * Math.sin(angle), outputCircle * Math.cos(angle), hole);
    }
    return d;
  }

  /** Draw the parts as thick as the magnification wants them. */
  resize() {
    const { pin, socket, cam, output_pin: outputPin } = this.magnification;
    for (const group of this.pins) {
      group.querySelector("circle").setAttribute("r", pin);
      group.querySelector("line").setAttribute("x2", 0.8 * pin);
    }
    const [x, y] = [socket * Math.cos(95 / DEGREES), socket * Math.sin(95 / DEGREES)];
    for (const path of this.sockets) path.setAttribute("d", `M${x},${-y}A${socket},${socket} 0 1 1 ${x},${y}`);
    this.cam.setAttribute("r", cam);
    for (const circle of this.outputs) circle.setAttribute("r", outputPin);
    if (this.shape.kind === "pin") {
      this.housing.setAttribute("d", circlePath(0, 0, this.shape.housing) + circlePath(0, 0, this.shape.wall));
    }
  }

  magnify(times) {
    const possible = this.shape.magnifications.filter((one) => one.times <= times);
    this.magnification = possible[possible.length - 1];
    this.resize();
  }

  /** Draw frame k. */
  draw(k) {
    const { frames, shape, magnification } = this;
    const { teeth, angles, eccentricity: c, pinCircle, outputCircle, outputPins } = shape;
    const times = magnification.times;
    const crank = frames.crank[k];
    const turn = -crank / (teeth - 1);
    const [sin, cos] = [Math.sin(crank), Math.cos(crank)];
    const gear = [-c * sin, c * cos];
    const [dx, dy, dturn] = frames.deviation.subarray(3 * k, 3 * k + 3);
    const cam = [gear[0] - times * dx, gear[1] - times * dy];
    this.gear.setAttribute("transform", placed(gear, turn));
    this.shaft.setAttribute("transform", placed([-times * dx, -times * dy], crank));
    shape.others.forEach(({ phase }, i) => {
      const centre = [-c * Math.sin(crank + phase), c * Math.cos(crank + phase)];
      this.others[i].setAttribute("transform", placed(centre, turn));
    });

    const ring = [];
    for (const [i, angle] of angles.entries()) {
      const [x, y] = [pinCircle * Math.sin(angle), pinCircle * Math.cos(angle)];
      const [nx, ny] = unit(x - teeth * gear[0], y - teeth * gear[1]);
      const opening = times * frames.opening[k * angles.length + i];
      ring.push([x + opening * nx, y + opening * ny]);
      if (this.pins.length) this.pins[i].setAttribute("transform", placed(ring[i], frames.pinAngle[k * angles.length + i]));
      if (this.sockets.length) {
        const j = 2 * (k * angles.length + i);
        const socket = [ring[i][0] - times * frames.away[j], ring[i][1] - times * frames.away[j + 1]];
        this.sockets[i].setAttribute("transform", placed(socket, Math.PI / 2 - angle));
      }
    }
    if (shape.kind !== "pin") this.housing.setAttribute("d", this.ringPath(gear, [dx, dy, dturn]));

    const outputs = [];
    for (let i = 0; i < outputPins; i++) {
      const angle = (2 * Math.PI * i) / outputPins - turn;
      const away = 1 + (times * frames.outputDistance[k * outputPins + i]) / c;
      const hole = [gear[0] + outputCircle * Math.sin(angle), gear[1] + outputCircle * Math.cos(angle)];
      outputs.push([hole[0] - away * gear[0], hole[1] - away * gear[1]]);
      this.outputs[i].setAttribute("cx", outputs[i][0]);
      this.outputs[i].setAttribute("cy", outputs[i][1]);
    }
    this.point("ring", k, ring, magnification.pin);
    this.point("cam", k, [cam], magnification.cam);
    this.point("output", k, outputs, magnification.output_pin);
    this.ring.draw(k);
    const degrees = ((crank * DEGREES) % 360).toFixed(1).padStart(5, "\u2007");
    this.clock.textContent = `crank at ${degrees}\u00B0\u2003t = ${(frames.start + frames.time[k]).toFixed(5)} s`;
  }

  /** Set the arrows of a kind: from a part's centre outwards to its surface, where the contact is. */
  point(group, k, centres, radius) {
    const force = this.frames.force[group];
    const scale = (LONGEST * this.shape.housing) / this.largest[group];
    this.arrows[group].forEach((arrow, i) => {
      const j = 2 * (k * centres.length + i);
      const size = Math.hypot(force[j], force[j + 1]);
      const length = size * scale;
      if (!this.showForces || !(length > 0.3)) {
        arrow.setAttribute("d", "");
        return;
      }
      const [ux, uy] = [force[j] / size, force[j + 1] / size];
      const tip = [centres[i][0] + radius * ux, centres[i][1] + radius * uy];
      const head = Math.min(2.2, 0.6 * length);
      const neck = [tip[0] - head * ux, tip[1] - head * uy];
      const side = [-0.38 * head * uy, 0.38 * head * ux];
      const tail = [tip[0] - length * ux, tip[1] - length * uy];
      const corners = [[neck[0] + side[0], neck[1] + side[1]], tip, [neck[0] - side[0], neck[1] - side[1]]];
      arrow.setAttribute("d", `M${tail}L${neck}M${corners.join("L")}Z`);
    });
  }

  /** Give the housing of an internal gear, each point moved along its normal by its gap. */
  ringPath(gear, [dx, dy, dturn]) {
    const { ring, ringNormals, clearance, housing } = this.shape;
    const times = this.magnification.times;
    const moved = new Float32Array(ring.length);
    for (let i = 0; i < ring.length; i += 2) {
      const [nx, ny] = [ringNormals[i], ringNormals[i + 1]];
      const [ux, uy] = [dx - dturn * (ring[i + 1] - gear[1]), dy + dturn * (ring[i] - gear[0])];
      const room = (times - 1) * clearance + times * (nx * ux + ny * uy);
      [moved[i], moved[i + 1]] = [ring[i] - room * nx, ring[i + 1] - room * ny];
    }
    return circlePath(0, 0, housing) + polygon(moved);
  }
}

/**
 * The force at each place of the ring as bars around a circle, with ideal load sharing and the largest of the turn. Of a
 * ring in two halves a place has a bar of each, next to each other.
 */
class RingLoad {
  constructor(place, shape, largest) {
    this.shape = shape;
    this.force = shape.frames.force.ring;
    this.ideal = shape.frames.ideal ?? null;
    this.top = 1e-9;
    this.places = shape.angles.length;
    this.halves = this.places / shape.teeth;
    this.peak = new Float32Array(this.places);
    for (let j = 0; j < this.force.length / 2; j++) {
      const size = Math.hypot(this.force[2 * j], this.force[2 * j + 1]);
      this.peak[j % this.places] = Math.max(this.peak[j % this.places], size);
    }
    this.top = Math.max(largest, ...(this.ideal ? [this.ideal.reduce((a, b) => Math.max(a, b), 0)] : []), 1e-9);
    this.build(place);
  }

  build(place) {
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", "-52 -54 104 106");
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", "Force at each position of the ring");
    place.replaceChildren(svg);
    // text of at least 12 pixels, whatever the width of the picture
    new ResizeObserver(() => svg.style.setProperty("--text", `${Math.max(3, (12 * 104) / (svg.clientWidth || 416))}px`)).observe(svg);
    const marks = ticks(0, this.top, 3);
    for (const value of marks) element(svg, "circle", { r: this.radius(value), class: "scale", "stroke-width": 0.3 });
    element(svg, "path", { d: this.steps(this.peak), class: "largest", "stroke-width": 1 });
    this.bars = element(svg, "path", { class: "bar" });
    this.line = element(svg, "path", { class: "ideal", "stroke-width": 1.2 });
    this.hand = element(svg, "path", { class: "hand", "stroke-width": 1.4, "stroke-linecap": "round" });
    element(svg, "text", { x: 0, y: 6, "text-anchor": "middle", class: "soft" }, "eccentricity");
    const every = Math.max(1, Math.round(this.shape.teeth / 12));
    for (let i = 0; i < this.shape.teeth; i += every) {
      const angle = (2 * Math.PI * i) / this.shape.teeth;
      const at = { x: 17.6 * Math.sin(angle), y: -17.6 * Math.cos(angle) + 1.2, "text-anchor": "middle", class: "soft" };
      element(svg, "text", at, String(i + 1));
    }
    for (const value of marks.slice(1)) {
      const at = { x: 0.8, y: -this.radius(value) - 0.6, class: "soft" };
      element(svg, "text", at, `${tickText(value, marks.step)} N`);
    }
  }

  radius(force) {
    return 20 + (30 * force) / this.top;
  }

  /** Give the outline of steps around the circle, and the circle within. */
  steps(sizes, share = 1) {
    const half = (Math.PI / this.places) * share;
    const at = (angle, r) => `${(r * Math.sin(angle)).toFixed(2)},${(-r * Math.cos(angle)).toFixed(2)}`;
    let d = "";
    for (let i = 0; i < this.places; i++) {
      const angle = (2 * Math.PI * (i - (this.halves - 1) / 2)) / this.places;
      const size = sizes[(i % this.halves) * this.shape.teeth + Math.floor(i / this.halves)];
      const r = this.radius(size);
      const [from, to] = [angle - half, angle + half];
      if (share < 1) {
        if (size > 0) d += `M${at(from, 20)}L${at(from, r)}A${r},${r} 0 0 1 ${at(to, r)}L${at(to, 20)}A20,20 0 0 0 ${at(from, 20)}Z`;
      } else {
        d += `${i ? "L" : "M"}${at(from, r)}A${r},${r} 0 0 1 ${at(to, r)}`;
      }
    }
    return share < 1 ? d : `${d}Z${circlePath(0, 0, 20)}`;
  }

  draw(k) {
    const { places } = this;
    const { frames } = this.shape;
    const sizes = new Float32Array(places);
    for (let i = 0; i < places; i++) {
      const j = 2 * (k * places + i);
      sizes[i] = Math.hypot(this.force[j], this.force[j + 1]);
    }
    this.bars.setAttribute("d", this.steps(sizes, 0.8));
    if (this.ideal) this.line.setAttribute("d", this.steps(this.ideal.subarray(k * places, (k + 1) * places)));
    const [x, y] = [-13 * Math.sin(frames.crank[k]), -13 * Math.cos(frames.crank[k])];
    const [tx, ty] = [-x / 13, -y / 13];
    const side = (s) => `${x + 2.2 * tx - s * ty * 1.2},${y + 2.2 * ty + s * tx * 1.2}`;
    this.hand.setAttribute("d", `M0,0L${x},${y}M${side(1)}L${x},${y}L${side(-1)}`);
  }
}

function largestForce(force) {
  let largest = 1e-9;
  for (let j = 0; j < force.length; j += 2) largest = Math.max(largest, Math.hypot(force[j], force[j + 1]));
  return largest;
}

function unit(x, y) {
  const size = Math.hypot(x, y);
  return [x / size, y / size];
}

function placed([x, y], angle) {
  return `translate(${x.toFixed(4)},${y.toFixed(4)}) rotate(${(angle * DEGREES).toFixed(4)})`;
}

function polygon(points) {
  const parts = [];
  for (let i = 0; i < points.length; i += 2) parts.push(`${points[i].toFixed(3)},${points[i + 1].toFixed(3)}`);
  return `M${parts.join("L")}Z`;
}
