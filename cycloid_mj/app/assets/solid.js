// The drive in 3-D: triangles of its parts in WebGL, rotated by mouse or keys, with a section plane and steps of assembly.

import { el, announce } from "./dom.js";

const VERTEX = `attribute vec3 corner, normal; uniform mat4 pose, view; uniform vec2 aspect; varying vec3 n, world;
void main() { vec4 there = pose * vec4(corner, 1.0); world = there.xyz; vec4 at = view * there; n = mat3(view) * mat3(pose) * normal; gl_Position = vec4(at.xy * aspect, at.z * 0.25, 1.0); }`;
// What lies before the section plane is left out; the inside of a part that is cut open is drawn as its cut face.
const FRAGMENT = `precision mediump float; uniform vec4 colour; uniform vec2 cut; varying vec3 n, world;
void main() { if (world.x > cut.x) discard; vec3 m = normalize(n); bool inside = m.z > 0.0; if (inside) m = -m;
float light = 0.5 + 0.45 * max(0.0, dot(m, normalize(vec3(0.35, 0.6, -0.7)))) + 0.16 * max(0.0, dot(m, normalize(vec3(-0.7, 0.1, -0.5))));
gl_FragColor = vec4(colour.rgb * (inside && cut.y > 0.5 ? 0.8 : min(light, 1.1)), colour.a); }`;
const CREASE = 0.8; // cosine of the angle between two faces above which their edge is drawn sharp

// Normals at the corners of triangles: the mean of the faces that meet there without a sharp edge.
function normalsOf(corners) {
  const faces = [], meeting = new Map(), normals = new Float32Array(corners.length);
  const spot = at => `${corners[at].toFixed(3)} ${corners[at + 1].toFixed(3)} ${corners[at + 2].toFixed(3)}`;
  for (let at = 0; at < corners.length; at += 9) {
    const [ax, ay, az] = [0, 1, 2].map(k => corners[at + 3 + k] - corners[at + k]), [bx, by, bz] = [0, 1, 2].map(k => corners[at + 6 + k] - corners[at + k]);
    const n = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], size = Math.hypot(...n) || 1;
    const face = { size, n: n.map(one => one / size) };
    faces.push(face);
    for (const corner of [at, at + 3, at + 6]) meeting.set(spot(corner), [...(meeting.get(spot(corner)) || []), face]);
  }
  faces.forEach(({ n }, index) => {
    for (let corner = 9 * index; corner < 9 * index + 9; corner += 3) {
      for (const other of meeting.get(spot(corner))) {
        if (n[0] * other.n[0] + n[1] * other.n[1] + n[2] * other.n[2] < CREASE) continue;
        for (let k = 0; k < 3; k += 1) normals[corner + k] += other.size * other.n[k];
      }
    }
  });
  return normals;
}

// Rotation by an angle about the axis, then a translation.
const columns = (angle, x, y, z) => { const [c, s] = [Math.cos(angle), Math.sin(angle)]; return [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x, y, z, 1]; };

const SPEED = 0.8; // of the crank [rad/s]

export class Solid {
  constructor(data) {
    Object.assign(this, { data, yaw: -0.6, pitch: -1.0, size: 1, crank: 0, cut: true, at: 0, apart: 0, step: data.steps.length, turns: false });
    this.canvas = el("canvas", { tabindex: "0", role: "img", class: "solid", "aria-label": "The drive in 3-D, cut open. Drag or use the arrow keys to rotate it, + and − to zoom" });
    this.gl = this.canvas.getContext("webgl", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!this.gl) {
      this.element = el("p", { class: "near" }, "This browser has no WebGL. The STEP file (tab Export) shows the assembly in a CAD program.");
      return;
    }
    this.#upload();
    this.element = el("div", {}, this.canvas, this.#controls());
    this.#hands();
    let before = performance.now();
    const frame = now => {
      if (this.ended) return;
      if (this.turns && this.element.isConnected) { this.crank += (now - before) / 1000 * SPEED; this.#draw(); }
      before = now;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
  }

  end() { this.ended = true; this.gl?.getExtension("WEBGL_lose_context")?.loseContext(); }

  #controls() {
    const { steps, reason } = this.data;
    const toggle = (key, words) => el("label", {}, el("input", { type: "checkbox", checked: this[key], onchange: event => { this[key] = event.target.checked; this.#draw(); } }), words);
    const range = (words, limits, value, change) => el("label", { class: "range" }, words, el("input", { type: "range", ...limits, value: String(value), oninput: event => { change(event.target.valueAsNumber); this.#draw(); } }));
    const says = el("p", { class: "soft", id: "step-words" });
    const show = step => {
      this.step = step;
      says.textContent = step < steps.length ? `Step ${step} of ${steps.length}: ${steps[step - 1] ?? "nothing yet"}` : `All ${steps.length} steps: the drive is assembled. The written order is in the tab Export.`;
    };
    show(steps.length);
    return el("div", { class: "solid-controls" },
      el("div", { class: "shows" }, toggle("turns", "Rotate crank"), toggle("cut", "Section"), range("Section plane", { min: "-1", max: "1", step: "0.02" }, 0, value => { this.at = value; })),
      el("div", { class: "shows" }, range("Exploded", { min: "0", max: "1", step: "0.02" }, 0, value => { this.apart = value; }),
        steps.length ? range("Assembly step", { min: "1", max: String(steps.length), step: "1" }, steps.length, value => { show(value); announce(says.textContent); }) : null),
      steps.length ? says : el("p", { class: "near" }, reason));
  }

  #upload() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.uniforms = Object.fromEntries(["pose", "view", "aspect", "colour", "cut"].map(name => [name, gl.getUniformLocation(program, name)]));
    this.reach = 0;
    const ends = [[Infinity, -Infinity], [Infinity, -Infinity]]; // assembled, exploded
    this.parts = this.data.parts.map(part => {
      const bytes = Uint8Array.from(atob(part.corners), one => one.charCodeAt(0)), corners = new Float32Array(bytes.buffer);
      let [reach, low, high] = [0, Infinity, -Infinity];
      for (let at = 0; at < corners.length; at += 3) {
        reach = Math.max(reach, Math.hypot(corners[at], corners[at + 1]));
        low = Math.min(low, corners[at + 2]);
        high = Math.max(high, corners[at + 2]);
      }
      for (const copy of part.copies) {
        this.reach = Math.max(this.reach, reach + Math.hypot(copy.at[0], copy.at[1]));
        ends.forEach((end, apart) => { end[0] = Math.min(end[0], low + copy.at[2] + apart * copy.apart); end[1] = Math.max(end[1], high + copy.at[2] + apart * copy.apart); });
      }
      const buffers = [corners, normalsOf(corners)].map(data => { const buffer = gl.createBuffer(); gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW); return buffer; });
      return { ...part, corners: null, buffers, count: corners.length / 3 };
    });
    this.ends = ends;
    this.names = ["corner", "normal"].map(name => gl.getAttribLocation(program, name));
    gl.enable(gl.DEPTH_TEST);
  }

  #hands() {
    let from = null;
    this.canvas.addEventListener("pointerdown", event => { from = [event.clientX, event.clientY]; this.canvas.setPointerCapture(event.pointerId); });
    this.canvas.addEventListener("pointermove", event => {
      if (!from) return;
      this.yaw += (event.clientX - from[0]) / 150;
      this.pitch += (event.clientY - from[1]) / 150;
      from = [event.clientX, event.clientY];
      this.#draw();
    });
    this.canvas.addEventListener("pointerup", () => { from = null; });
    this.canvas.addEventListener("keydown", event => {
      const does = { ArrowLeft: () => { this.yaw -= 0.12; }, ArrowRight: () => { this.yaw += 0.12; }, ArrowUp: () => { this.pitch -= 0.12; }, ArrowDown: () => { this.pitch += 0.12; }, "+": () => { this.size *= 1.15; }, "-": () => { this.size /= 1.15; } }[event.key];
      if (does) { event.preventDefault(); does(); this.#draw(); }
    });
  }

  #draw() {
    const gl = this.gl, canvas = this.canvas, sharp = Math.min(2, devicePixelRatio || 1);
    const [wide, tall] = [Math.round(canvas.clientWidth * sharp), Math.round(canvas.clientHeight * sharp)];
    if (!wide || this.ended) return;
    if (canvas.width !== wide || canvas.height !== tall) Object.assign(canvas, { width: wide, height: tall });
    gl.viewport(0, 0, wide, tall);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [low, high] = [0, 1].map(end => this.ends[0][end] + this.apart * (this.ends[1][end] - this.ends[0][end]));
    // the exploded drive lies along the longer side of the view
    const long = 1 + this.apart * (Math.max(1, wide / tall) - 1), middle = (low + high) / 2;
    const s = 0.88 / Math.hypot(this.reach, (high - low) / 2 / long) * this.size;
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    // turned about the reducer's axis, then tilted: z of the screen looks away from us
    const roll = -0.5 * Math.PI * this.apart, [cr, sr] = [Math.cos(roll), Math.sin(roll)];
    const column = (x, y, z, w) => [cr * x - sr * y, sr * x + cr * y, z, w];
    const view = [column(cy * s, cp * sy * s, -sp * sy * s, 0), column(-sy * s, cp * cy * s, -sp * cy * s, 0), column(0, -sp * s, -cp * s, 0), column(0, sp * s * middle, cp * s * middle, 1)].flat();
    gl.uniformMatrix4fv(this.uniforms.view, false, new Float32Array(view));
    gl.uniform2f(this.uniforms.aspect, Math.min(1, tall / wide), Math.min(1, wide / tall));
    gl.uniform2f(this.uniforms.cut, this.cut ? this.at * this.reach : 1e9, this.cut ? 1 : 0);
    for (const part of this.parts) {
      const [r, g, b] = part.colour;
      this.names.forEach((name, at) => { gl.bindBuffer(gl.ARRAY_BUFFER, part.buffers[at]); gl.enableVertexAttribArray(name); gl.vertexAttribPointer(name, 3, gl.FLOAT, false, 0, 0); });
      for (const copy of part.copies) {
        if (copy.step > this.step) continue;
        const fresh = copy.step === this.step && this.step < this.data.steps.length; // the part of this step is brighter
        gl.uniform4f(this.uniforms.colour, ...(fresh ? [0.95, 0.55, 0.15] : [r, g, b]), 1);
        gl.uniformMatrix4fv(this.uniforms.pose, false, new Float32Array(this.#pose(copy)));
        gl.drawArrays(gl.TRIANGLES, 0, part.count);
      }
    }
  }

  // The pose of a part at the crank angle: rotated about its axis, which itself turns about that of the reducer.
  #pose({ at: [x, y, z], axis: [ax, ay], angle, moves, apart }) {
    const [spin, carry] = this.data.motions[moves].map(rate => rate * this.crank), up = z + this.apart * apart;
    const turned = (by, u, v) => { const [c, s] = [Math.cos(by), Math.sin(by)]; return [c * u - s * v, s * u + c * v]; };
    const [px, py] = turned(spin, x, y), [qx, qy] = turned(carry, ax, ay);
    return columns(angle + spin, px + qx, py + qy, up);
  }
}
