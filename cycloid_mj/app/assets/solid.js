// The assembly in 3-D: triangles of the parts in WebGL, rotated by mouse or arrow keys, with a running crank.

import { el } from "./dom.js";

const VERTEX = `attribute vec3 corner, normal; uniform mat4 place, view; uniform vec2 aspect; varying vec3 n;
void main() { vec4 at = view * place * vec4(corner, 1.0); n = mat3(view) * mat3(place) * normal; gl_Position = vec4(at.xy * aspect, at.z * 0.25, 1.0); }`;
const FRAGMENT = `precision mediump float; uniform vec4 colour; varying vec3 n;
void main() { vec3 m = normalize(n); if (m.z > 0.0) m = -m; float light = 0.5 + 0.45 * max(0.0, dot(m, normalize(vec3(0.35, 0.6, -0.7)))) + 0.16 * max(0.0, dot(m, normalize(vec3(-0.7, 0.1, -0.5)))); gl_FragColor = vec4(colour.rgb * min(light, 1.1), colour.a); }`;
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
  faces.forEach(({ n }, place) => {
    for (let corner = 9 * place; corner < 9 * place + 9; corner += 3) {
      for (const other of meeting.get(spot(corner))) {
        if (n[0] * other.n[0] + n[1] * other.n[1] + n[2] * other.n[2] < CREASE) continue;
        for (let k = 0; k < 3; k += 1) normals[corner + k] += other.size * other.n[k];
      }
    }
  });
  return normals;
}

const columns = (angle, x, y) => { const [c, s] = [Math.cos(angle), Math.sin(angle)]; return [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x, y, 0, 1]; };

export class Solid {
  constructor(data) {
    Object.assign(this, { data, yaw: -0.6, pitch: -1.0, size: 1, crank: 0, cut: true, turns: !matchMedia("(prefers-reduced-motion: reduce)").matches });
    this.canvas = el("canvas", { tabindex: "0", role: "img", class: "solid", "aria-label": "The assembly in 3-D. Drag or use the arrow keys to rotate it, + and − to zoom" });
    this.gl = this.canvas.getContext("webgl", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    const toggle = (key, words) => el("label", {}, el("input", { type: "checkbox", checked: this[key], onchange: event => { this[key] = event.target.checked; this.#draw(); } }), words);
    this.element = el("div", {}, this.gl ? [this.canvas, el("div", { class: "shows" }, toggle("turns", "Rotate crank"), toggle("cut", "Transparent housing"), el("span", { class: "soft" }, "Drag or arrow keys: rotate; + and −: zoom"))]
      : el("p", { class: "near" }, "This browser has no WebGL. The STEP file (tab Export) shows the assembly in a CAD program."));
    if (!this.gl) return;
    this.#upload();
    this.#hands();
    let before = performance.now();
    const frame = now => {
      if (this.ended) return;
      if (this.turns && this.element.isConnected) { this.crank += (now - before) / 1000 * 0.8; this.#draw(); }
      before = now;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
  }

  end() { this.ended = true; this.gl?.getExtension("WEBGL_lose_context")?.loseContext(); }

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
    this.at = Object.fromEntries(["place", "view", "aspect", "colour"].map(name => [name, gl.getUniformLocation(program, name)]));
    let reach = 0, low = Infinity, high = -Infinity;
    this.bodies = this.data.bodies.map(body => {
      const bytes = Uint8Array.from(atob(body.corners), one => one.charCodeAt(0)), corners = new Float32Array(bytes.buffer);
      for (let at = 0; at < corners.length; at += 3) {
        reach = Math.max(reach, Math.hypot(corners[at], corners[at + 1]));
        low = Math.min(low, corners[at + 2]);
        high = Math.max(high, corners[at + 2]);
      }
      const buffers = [corners, normalsOf(corners)].map(data => { const buffer = gl.createBuffer(); gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW); return buffer; });
      return { ...body, corners: null, buffers, count: corners.length / 3 };
    });
    this.names = ["corner", "normal"].map(name => gl.getAttribLocation(program, name));
    this.scale = 0.88 / Math.hypot(reach, (high - low) / 2);
    this.middle = (low + high) / 2;
    gl.enable(gl.DEPTH_TEST);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA); // for a page behind the canvas
    gl.polygonOffset(2, 4); // what is seen through lies behind what touches it
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
    const s = this.scale * this.size, [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    // turned about the reducer's axis, then tilted: z of the screen looks away from us
    const view = [cy * s, cp * sy * s, -sp * sy * s, 0, -sy * s, cp * cy * s, -sp * cy * s, 0, 0, -sp * s, -cp * s, 0, 0, sp * s * this.middle, cp * s * this.middle, 1];
    gl.uniformMatrix4fv(this.at.view, false, new Float32Array(view));
    gl.uniform2f(this.at.aspect, Math.min(1, tall / wide), Math.min(1, wide / tall));
    const { orbit, gear_rate: rate } = this.data;
    const glass = body => body.colour[3] < 1 || (this.cut && body.name === "housing");
    for (const clear of [false, true]) {
      for (const body of this.bodies) {
        if (glass(body) !== clear) continue;
        for (const what of [gl.BLEND, gl.POLYGON_OFFSET_FILL]) (clear ? gl.enable : gl.disable).call(gl, what);
        gl.depthMask(!clear);
        const [r, g, b, a] = body.colour;
        gl.uniform4f(this.at.colour, r, g, b, this.cut && body.name === "housing" ? 0.28 : a);
        this.names.forEach((name, at) => { gl.bindBuffer(gl.ARRAY_BUFFER, body.buffers[at]); gl.enableVertexAttribArray(name); gl.vertexAttribPointer(name, 3, gl.FLOAT, false, 0, 0); });
        const at = this.crank + body.phase;
        const pose = { crank: [this.crank, 0, 0], disc: [rate * this.crank, -orbit * Math.sin(at), orbit * Math.cos(at)], output: [rate * this.crank, 0, 0] }[body.moves];
        for (const [x, y] of body.places) {
          gl.uniformMatrix4fv(this.at.place, false, new Float32Array(pose ? columns(...pose) : columns(0, x, y)));
          gl.drawArrays(gl.TRIANGLES, 0, body.count);
        }
      }
    }
    gl.depthMask(true);
  }
}
