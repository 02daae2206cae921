// The cross-section: parts at a crank angle, force arrows, load bars, magnified clearances, dimensions, zoom, animation.

import { el, svg, number, fill } from "./dom.js";

const SECONDS = 8; // duration of one crank turn of the animation
const FRAME = 1.34; // half the picture over the outer radius of the reducer: leaves space for the load bars

export class Section {
  constructor(picture, crank, controls, legend) {
    Object.assign(this, { picture, legend, crank: 17, play: 1, drawn: null, acting: null, wrong: [], zoom: 1, middle: [0, 0], ahead: new Map() });
    this.nextTurn = null;
    this.changedPlay = () => {};
    this.shows = { arrows: true, bars: true, dimensions: false };
    this.#controls(crank, controls);
    this.#mouse();
  }

  // Draw new outlines; the forces of the previous design are removed.
  show(drawn, errors) {
    this.drawn = drawn;
    this.acting = null;
    this.ahead.clear();
    this.wrong = errors;
    this.#build();
    this.#move();
  }

  forces(data) {
    this.acting = data;
    this.ahead.clear();
    if (data) this.ahead.set(data.turn, data);
    this.#move();
  }

  marks(failed) {
    this.wrong = failed;
    this.#build();
    this.#move();
  }

  #controls(crank, container) {
    const toggle = (key, words) => el("label", {}, el("input", { type: "checkbox", checked: this.shows[key], onchange: event => { this.shows[key] = event.target.checked; this.#build(); this.#move(); } }), words);
    this.button = el("button", { "aria-pressed": "false", title: "Rotate the crank (space)", onclick: () => this.#toggle() }, "▶ Rotate");
    this.angle = el("input", { id: "crank", type: "range", min: 0, max: 360, step: 1, "aria-label": "Crank angle", oninput: event => { this.#halt(); this.crank = event.target.valueAsNumber; this.#move(); } });
    this.degrees = el("span", { class: "degrees", "aria-hidden": "true" });
    this.factor = el("select", { id: "play", onchange: event => { this.play = +event.target.value; this.changedPlay(); } },
      [1, 5, 20, 50, 200].map(times => el("option", { value: times }, times === 1 ? "true scale" : `× ${times}`)));
    crank.append(el("div", { class: "crank" }, this.button, this.angle, this.degrees));
    container.append(
      el("div", { class: "shows" }, toggle("arrows", "Forces"), toggle("bars", "Load bars"), toggle("dimensions", "Dimensions"),
        el("label", { title: "Factor by which clearances are magnified in the drawing" }, "Clearances ", this.factor),
        el("span", { class: "zooms" },
          el("button", { title: "Zoom in (+)", "aria-label": "Zoom in", onclick: () => this.#nearer(1.4) }, "+"),
          el("button", { title: "Zoom out (−)", "aria-label": "Zoom out", onclick: () => this.#nearer(1 / 1.4) }, "−"),
          el("button", { title: "Show everything (0)", onclick: () => this.#whole() }, "All"))));
  }

  #mouse() {
    const at = event => {
      const box = this.picture.getBoundingClientRect(), half = this.half / this.zoom;
      const size = Math.min(box.width, box.height);
      return [(event.clientX - box.left - box.width / 2) / size * 2 * half, (event.clientY - box.top - box.height / 2) / size * 2 * half];
    };
    this.picture.addEventListener("wheel", event => {
      if (!(event.ctrlKey || event.metaKey || this.zoom > 1) && event.deltaY > 0) return;
      event.preventDefault();
      this.#nearer(Math.exp(-event.deltaY / 500), at(event));
    }, { passive: false });
    this.picture.addEventListener("pointerdown", event => {
      if (this.zoom <= 1) return;
      this.picture.setPointerCapture(event.pointerId);
      this.from = [at(event), [...this.middle]];
    });
    this.picture.addEventListener("pointermove", event => {
      if (!this.from) return;
      const here = at(event), [start, middle] = this.from;
      this.middle = [middle[0] + start[0] - here[0], middle[1] + start[1] - here[1]];
      this.#frame();
    });
    for (const end of ["pointerup", "pointercancel"]) this.picture.addEventListener(end, () => { this.from = null; });
    this.picture.addEventListener("keydown", event => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const step = 0.12 * this.half / this.zoom;
      const move = (x, y) => { this.middle = [this.middle[0] + x * step, this.middle[1] + y * step]; this.#frame(); };
      const does = {
        "+": () => this.#nearer(1.4), "=": () => this.#nearer(1.4), "-": () => this.#nearer(1 / 1.4), 0: () => this.#whole(), " ": () => this.#toggle(),
        ArrowLeft: () => move(-1, 0), ArrowRight: () => move(1, 0), ArrowUp: () => move(0, -1), ArrowDown: () => move(0, 1),
      }[event.key];
      if (does) { event.preventDefault(); does(); }
    });
  }

  // Size of text of so many pixels, in units of the picture.
  #text(pixels) {
    const box = this.picture.getBoundingClientRect();
    return pixels * 2 * this.half / this.zoom / (Math.min(box.width, box.height) || 500);
  }

  get half() { return FRAME * (this.drawn ? this.drawn.reach : 50); }

  #nearer(times, about = [0, 0]) {
    const before = this.zoom;
    this.zoom = Math.min(60, Math.max(1, this.zoom * times));
    const share = 1 - before / this.zoom;
    this.middle = this.zoom === 1 ? [0, 0] : [this.middle[0] + about[0] * share, this.middle[1] + about[1] * share];
    this.#build();
    this.#move();
  }

  #whole() {
    Object.assign(this, { zoom: 1, middle: [0, 0] });
    this.#build();
    this.#move();
  }

  #frame() {
    const half = this.half / this.zoom;
    this.picture.setAttribute("viewBox", `${this.middle[0] - half} ${this.middle[1] - half} ${2 * half} ${2 * half}`);
  }

  #toggle() {
    if (this.playing) { this.#halt(); return; }
    this.playing = performance.now() - this.crank / 360 * SECONDS * 1000;
    this.button.textContent = "❚❚ Stop";
    this.button.setAttribute("aria-pressed", "true");
    const frame = now => {
      if (!this.playing) return;
      this.crank = (now - this.playing) / 1000 / SECONDS * 360;
      this.#move();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  #halt() {
    this.playing = 0;
    this.crank %= 360;
    this.button.textContent = "▶ Rotate";
    this.button.setAttribute("aria-pressed", "false");
  }

  // Create the elements of the parts; `#move` moves them.
  #build() {
    const d = this.drawn;
    if (!d) return;
    this.#frame();
    const bad = part => { const check = this.wrong.find(one => one.part === part); return check ? ` ${check.severity}` : ""; };
    const circle = (at, r, look) => svg("circle", { cx: at[0], cy: at[1], r, class: look });
    this.discs = d.discs.map((path, disc) => svg("g", { class: `disc${disc ? " behind" : ""}` }, svg("path", { d: path, class: `gear${bad("gear")}`, "fill-rule": "evenodd" }),
      ["bore", "hole"].map(part => bad(part) && !d.cranks && (part === "bore" ? circle([0, 0], d.bore_radius, `mark-of${bad(part)}`) : d.holes.map(at => circle(at, d.hole_radius, `mark-of${bad(part)}`))))));
    if (d.cranks) this.#cranks(circle, bad);
    else this.#shaft(circle, bad);
    this.arm = svg("line", { class: "arm" });
    this.over = svg("g", { class: "forces" });
    this.bars = svg("g", { class: "bars" });
    fill(this.picture,
      svg("defs", {}, svg("marker", { id: "tip", viewBox: "0 0 10 10", refX: 9, refY: 5, markerWidth: 5, markerHeight: 5, orient: "auto-start-reverse" }, svg("path", { d: "M0,0L10,5L0,10z", fill: "context-stroke" }))),
      svg("g", { transform: "scale(1,-1)", class: d.whole ? "" : "unmade" },
        svg("path", { d: d.ring, class: `ring${bad("ring")}`, "fill-rule": "evenodd" }),
        this.bars,
        d.pins.map(at => circle(at, d.pin_radius, `pin${bad("pin")}`)),
        [...this.discs].reverse(), this.output, this.inner, this.arm, this.over),
      this.shows.dimensions ? this.#dimensions() : null, this.#badges());
    this.picture.style.setProperty("--line", `${this.half / this.zoom / 330}px`);
  }

  // Output pins, cam and shaft of a central crank.
  #shaft(circle, bad) {
    const d = this.drawn;
    this.output = svg("g", {}, d.holes.map(at => circle(at, d.output_radius, `output${bad("output")}`)));
    this.cam = circle([0, 0], d.bore_radius, `cam${bad("bore")}`);
    this.inner = svg("g", {}, this.cam, circle([0, 0], d.shaft_radius, `shaft${bad("shaft")}`));
  }

  // Posts of the carrier, eccentrics of the first disc, cranks with their planets, and the sun of an RV reducer.
  #cranks(circle, bad) {
    const d = this.drawn, outline = points => svg("path", { d: points.length ? `M${points.map(at => at.join()).join(" ")}Z` : "", class: `planet${bad("shaft")}` });
    this.output = svg("g", {}, d.posts.map(at => circle(at, d.post_radius, `output${bad("output")}`)));
    this.eccentrics = d.cranks.map(() => svg("g", {}, circle([0, 0], d.bore_radius, "needles"), circle([0, 0], d.eccentric_radius, `cam${bad("bore")}`)));
    this.journals = d.cranks.map(() => svg("g", {}, circle([0, 0], d.journal_radius, `shaft${bad("shaft")}`), outline(d.planet), svg("line", { class: "arm", x1: 0, y1: 0, x2: 0, y2: d.journal_radius })));
    this.sun = svg("g", {}, outline(d.sun));
    this.inner = svg("g", {}, this.eccentrics, this.journals, this.sun);
  }

  #badges() {
    const d = this.drawn, seen = {}, [first] = d.cranks ?? d.holes;
    const spots = {
      gear: [-0.62, 0.5], pin: [0.62, 0.66], ring: [0.74, -0.78], bore: [d.bore_radius / d.reach, -0.08], shaft: [0, 0.06],
      hole: [first[0] / d.reach, -first[1] / d.reach], output: [first[0] / d.reach + 0.1, -first[1] / d.reach + 0.06],
    };
    const size = Math.max(0.055 * this.half / this.zoom, this.#text(9));
    return svg("g", { class: "badges" }, this.wrong.map((one, index) => {
      const spot = spots[one.part];
      if (!spot) return null;
      const shift = 2.1 * size * (seen[one.part] = (seen[one.part] ?? -1) + 1);
      return svg("g", { class: one.severity, transform: `translate(${spot[0] * d.reach + shift},${spot[1] * d.reach})` },
        svg("title", {}, `${one.name}: ${one.what}`), svg("circle", { r: size }), svg("text", { "font-size": 1.25 * size }, String(index + 1)));
    }));
  }

  #dimensions() {
    const d = this.drawn, size = Math.max(0.036 * this.half / this.zoom, this.#text(12));
    return svg("g", { class: "dimensions" }, d.dimensions.map((one, row) => {
      const angle = (-70 + 38 * row) * Math.PI / 180, r = one.diameter / 2, [x, y] = [r * Math.cos(angle), r * Math.sin(angle)];
      const words = `⌀ ${number(one.diameter)} ${one.name}`, wide = 0.52 * size * words.length;
      return svg("g", {}, svg("circle", { r, class: "centreline" }),
        svg("line", { x1: -x, y1: -y, x2: x, y2: y, "marker-start": "url(#tip)", "marker-end": "url(#tip)" }),
        svg("g", { transform: `translate(${0.62 * x},${0.62 * y})` }, svg("rect", { x: -wide / 2 - size / 3, y: -0.8 * size, width: wide + 0.66 * size, height: 1.6 * size, rx: size / 3 }), svg("text", { "font-size": size }, words)));
    }));
  }

  // Forces at the crank angle, interpolated between the angles at which they were solved.
  #now() {
    const turn = Math.floor(this.crank / 360 + 1e-9);
    const data = this.ahead.get(turn) || (this.playing ? null : this.acting);
    if (this.playing && this.nextTurn && this.acting && !this.ahead.has(turn + 1)) {
      const present = this.acting;
      this.ahead.set(turn + 1, null);
      this.nextTurn(turn + 1).then(next => { if (this.acting === present) { this.ahead.set(turn + 1, next); this.ahead.delete(turn - 1); } }, () => {});
    }
    if (!data) return null;
    const count = data.discs.length - 1, position = (this.crank / 360 - turn) * count, low = Math.min(count - 1, Math.floor(position));
    return { data, low, share: position - low };
  }

  #move() {
    const d = this.drawn;
    if (!d) return;
    const angle = this.crank * Math.PI / 180, turn = d.gear_rate * this.crank, now = this.#now();
    this.degrees.textContent = `${Math.round(this.crank % 360)}°`;
    this.angle.value = this.crank % 360;
    this.angle.setAttribute("aria-valuetext", `${Math.round(this.crank % 360)} degrees`);
    const between = values => values[now.low] + now.share * (values[now.low + 1] - values[now.low]);
    this.discs.forEach((disc, index) => {
      const at = angle + d.phases[index];
      let [x, y, z] = [-d.orbit * Math.sin(at), d.orbit * Math.cos(at), turn];
      if (now) {
        const part = axis => between(now.data.discs.map(row => row[index][axis]));
        [x, y, z] = [x + d.play * part(0), y + d.play * part(1), z + d.play * part(2) * 180 / Math.PI];
      }
      disc.setAttribute("transform", `translate(${x},${y}) rotate(${z})`);
    });
    const lag = now ? d.play * between(now.data.output_turn) * 180 / Math.PI : 0;
    this.output.setAttribute("transform", `rotate(${turn + lag})`);
    const centre = [-d.orbit * Math.sin(angle), d.orbit * Math.cos(angle)];
    if (d.cranks) this.#turnCranks(angle, turn * Math.PI / 180, centre);
    else this.cam.setAttribute("transform", `translate(${centre})`);
    for (const [key, value] of Object.entries({ x1: 0, y1: 0, x2: centre[0] * 3, y2: centre[1] * 3 })) this.arm.setAttribute(key, value);
    this.#forces(now, centre, lag);
  }

  #turnCranks(angle, turned, centre) {
    const d = this.drawn, degrees = 180 / Math.PI;
    d.cranks.forEach(([x, y], at) => {
      const axis = [x * Math.cos(turned) - y * Math.sin(turned), x * Math.sin(turned) + y * Math.cos(turned)];
      this.eccentrics[at].setAttribute("transform", `translate(${axis[0] + centre[0]},${axis[1] + centre[1]})`);
      this.journals[at].setAttribute("transform", `translate(${axis}) rotate(${angle * degrees})`);
    });
    this.sun.setAttribute("transform", `rotate(${d.sun_rate * angle * degrees})`);
  }

  #forces(now, centre, lag) {
    fill(this.over);
    fill(this.bars);
    if (!now) { this.legend.textContent = this.drawn.whole ? "" : "No forces: this design cannot be built."; return; }
    const d = this.drawn, { data } = now, row = now.share < 0.5 ? now.low : now.low + 1;
    const largest = kind => Math.max(...data[kind].force.map(discs => Math.max(...discs.map(one => Math.max(...one)))));
    const most = { teeth: largest("teeth"), output: largest("output"), cam: data.cam ? Math.max(...data.cam.map(discs => Math.max(...discs.map(([x, y]) => Math.hypot(x, y))))) : 0 };
    const long = 0.3 * d.reach, here = { teeth: 0, output: 0, cam: 0 };
    const arrow = (tail, tip, look) => svg("line", { x1: tail[0], y1: tail[1], x2: tip[0], y2: tip[1], class: look, "marker-end": "url(#tip)" });
    const spin = lag * Math.PI / 180, turned = ([x, y]) => [x * Math.cos(spin) - y * Math.sin(spin), x * Math.sin(spin) + y * Math.cos(spin)];
    for (const kind of ["teeth", "output"]) {
      data[kind].force[row].forEach((forces, disc) => forces.forEach((force, at) => {
        here[kind] = Math.max(here[kind], force);
        if (force < 0.004 * most[kind] || !this.shows.arrows) return;
        const size = long * force / most[kind], direction = data[kind].direction[row][disc][at];
        const tip = kind === "output" ? turned(data[kind].position[row][disc][at]) : data[kind].position[row][disc][at];
        this.over.append(arrow([tip[0] - size * direction[0], tip[1] - size * direction[1]], tip, `${kind}${disc ? " second" : ""}`));
      }));
    }
    (data.cam?.[row] ?? []).forEach((force, disc) => {
      const size = Math.hypot(...force);
      here.cam = Math.max(here.cam, size);
      const from = disc ? centre.map(one => -one) : centre;
      if (this.shows.arrows && size > 0.004 * most.cam) this.over.append(arrow(from, [from[0] + long * force[0] / most.cam, from[1] + long * force[1] / most.cam], "cam-force"));
    });
    if (this.shows.bars) {
      const count = data.teeth.force[row][0].length, wide = Math.min(0.05, 1.6 / count) * d.reach;
      for (let at = 0; at < count; at += 1) {
        const force = Math.max(...data.teeth.force[row].map(disc => disc[at]));
        const angle = Math.PI / 2 - 2 * Math.PI * at / count, from = 1.03 * d.reach, to = from + 0.26 * d.reach * force / most.teeth;
        this.bars.append(svg("line", { x1: from * Math.cos(angle), y1: from * Math.sin(angle), x2: (from + 0.27 * d.reach) * Math.cos(angle), y2: (from + 0.27 * d.reach) * Math.sin(angle), class: "rail", "stroke-width": wide }));
        if (force > 0.004 * most.teeth) this.bars.append(svg("line", { x1: from * Math.cos(angle), y1: from * Math.sin(angle), x2: to * Math.cos(angle), y2: to * Math.sin(angle), class: "bar", "stroke-width": wide }));
      }
    }
    const force = (kind, words) => `${words} ${number(here[kind], 3)} N (maximum over the turn ${number(most[kind], 3)} N)`;
    this.legend.textContent = `Largest forces at this angle under ${number(data.load_nm, 3)} N m: ${Object.entries(data.words).map(([kind, words]) => force(kind, words)).join(", ")}. Arrows of each kind have their own scale.${d.play > 1 ? ` Clearances are magnified ${d.play} times.` : ""}`;
  }
}
