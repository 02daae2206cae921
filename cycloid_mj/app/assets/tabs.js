// The tabs next to the cross-section: figures and charts of the design, long studies, the comparison of A and B, exports.

import { ask, newest, work, stop, download } from "./net.js";
import { el, number, toast, refill, announce, JUDGED } from "./dom.js";
import { lines, spikes, histogram, bars, judgedBars } from "./charts.js";
import { Solid } from "./solid.js";

const TABS = { figures: "Figures", turn: "Loads", error: "Accuracy", losses: "Losses", life: "Life", scatter: "Tolerances", stress: "Stress", solid: "3-D", compare: "A | B", make: "Export" };
const STUDIES = ["scatter", "stress"]; // tabs whose results stay until they are computed again
const METHODS = { // of the studies, by layout
  central: {
    scatter: "clearances, pin positions and eccentricity vary within this tolerance (uniform distribution, seed 0).",
    solved: "Each sample is solved over all crank angles; the charts are updated as samples arrive.",
    stress: "contact pressure by the rating, next to the largest bulk stress by finite elements on coarse grids, from a MuJoCo run of one crank turn.",
    bulk: "Bulk (finite elements)",
  },
  rv: {
    scatter: "eccentrics, crank bores, crank axes, planets and the axis of the carrier vary within this tolerance (uniform distribution, seed 0).",
    solved: "The transmission error of each sample is a closed form; backlash and forces of the samples are not computed.",
    stress: "contact pressure by the rating, next to the largest bulk stress under the forces of static equilibrium over a turn of the cranks: disc, ring and pins by finite elements on coarse grids, cranks and gears by closed forms.",
    bulk: "Bulk (finite elements or closed form)",
  },
};

export class Tabs {
  constructor(container, state, apply) {
    Object.assign(this, { container, state, apply, open: "figures", last: {}, jobs: {}, other: null, printer: {}, printed: true });
    this.choseMotor = () => {};
    this.solved = {
      error: newest("error", data => this.receive("error", data), words => this.receiveError("error", words)),
      solid: newest("solid", data => this.receive("solid", data), words => this.receiveError("solid", words)),
      make: newest("build", data => { this.printed = data.printed; this.receive("make", data); }, words => this.receiveError("make", words)),
    };
    this.list = el("div", { role: "tablist", "aria-label": "Results", onkeydown: event => this.#keys(event) }, Object.entries(TABS).map(([key, word]) =>
      el("button", { role: "tab", id: `tab-${key}`, "aria-controls": "panel", "aria-selected": String(key === this.open), tabindex: key === this.open ? "0" : "-1", onclick: () => this.choose(key) }, word)));
    this.panel = el("div", { role: "tabpanel", id: "panel", tabindex: "0", "aria-labelledby": "tab-figures" });
    container.append(this.list, this.panel);
  }

  offer(offers) { this.offers = offers; this.#draw(); }

  // Open a tab; a study of the tab that is left is stopped.
  choose(key) {
    const left = this.jobs[this.open];
    if (key !== this.open && STUDIES.includes(this.open) && left?.number) stop(left.number).catch(() => {});
    this.open = key;
    for (const tab of this.list.children) {
      const mine = tab.id === `tab-${key}`;
      tab.setAttribute("aria-selected", String(mine));
      tab.tabIndex = mine ? 0 : -1;
    }
    this.panel.setAttribute("aria-labelledby", `tab-${key}`);
    this.#want();
    this.#draw();
  }

  #keys(event) {
    const keys = [...this.list.children].map(tab => tab.id.slice(4)), at = keys.indexOf(this.open);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: keys.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.choose(keys[(to + keys.length) % keys.length]);
    document.getElementById(`tab-${this.open}`).focus();
  }

  // The design has changed: results of the previous one are no longer shown.
  changed() {
    this.errors = null;
    for (const key in this.solved) delete this.last[key];
    for (const key of STUDIES) if (this.last[key]) this.last[key].old = true;
    this.#want();
    if ([...STUDIES, "compare"].includes(this.open)) this.#draw();
    this.panel.classList.toggle("old", ![...STUDIES, "make"].includes(this.open));
  }

  another() { this.last = {}; this.errors = null; this.#draw(); }

  broken(errors) {
    this.errors = errors;
    this.last = {};
    for (const one of Object.values(this.solved)) one.drop();
    this.#draw();
  }

  receive(key, content) { this.last[key] = { data: content }; this.#again(key); }
  receiveError(key, words) { this.last[key] = { words }; this.#again(key); }

  #again(key) {
    const needs = { figures: ["statics"], turn: ["forces"], losses: ["statics"], life: ["life"], error: ["error"], solid: ["solid"], make: ["make"], compare: ["statics", "life"] };
    if (needs[this.open]?.includes(key)) this.#draw();
  }

  #want() {
    if (this.open in this.solved && !this.errors && !this.last[this.open] && !(this.open === "make" && !this.state().shown?.files.includes("3mf"))) this.solved[this.open].ask({ design: this.state().design, options: this.options() });
  }

  // Choices that are not in the design file: the motor of the requirements, and those of the printer.
  options() { return { motor: this.state().required.motor || "auto", ...this.printer }; }

  #draw() {
    this.panel.classList.remove("old");
    if (this.open !== "solid" && this.solid) { this.solid.end(); this.solid = null; }
    const draws = { figures: this.#figures, turn: this.#turn, error: this.#error, losses: this.#losses, life: this.#life, scatter: this.#scatter, stress: this.#stress, solid: this.#solid, compare: this.#compare, make: this.#make };
    if (this.errors && !["compare", "make"].includes(this.open)) {
      refill(this.panel, el("p", { class: "soft" }, "No results: this design cannot be built. The errors and their remedies are listed above."));
      return;
    }
    refill(this.panel, ...[draws[this.open].call(this)].flat(3).filter(Boolean));
  }

  #of(key, draw) {
    const last = this.last[key];
    if (!last) return el("p", { class: "soft waits" }, "…");
    return last.words ? el("p", { class: "fails" }, last.words) : draw(last.data);
  }

  #figures() {
    return this.#of("statics", data => [
      el("p", { class: "soft" }, `Static equilibrium at ${data.condition}.`),
      el("table", { class: "figures" }, el("tbody", {}, data.rows.map(row => el("tr", {}, el("th", { scope: "row" }, el("details", {}, el("summary", {}, row.name), el("p", { class: "soft" }, row.note))), el("td", {}, row.value))))),
      el("details", {}, el("summary", {}, "Assumptions"), el("ul", {}, data.assumptions.map(one => el("li", {}, one))))]);
  }

  #turn() {
    return this.#of("forces", data => {
      const count = data.discs.length, x = Array.from({ length: count }, (_, at) => at * 360 / (count - 1));
      const largest = kind => x.map((_, at) => Math.max(...data[kind].force[at].flat()));
      const carrying = x.map((_, at) => { const all = data.teeth.force[at].flat(), most = Math.max(...all); return all.filter(one => one > 0.01 * most).length; });
      const forceOn = at => data.teeth.force.map(row => row[0][at]);
      const pins = data.teeth.force[0][0].length;
      return [
        lines("Largest forces over the turn", x, Object.entries(data.words).map(([kind, name]) => ({ name, y: kind === "cam" ? data.cam.map(row => Math.max(...row.map(([a, b]) => Math.hypot(a, b)))) : largest(kind), look: kind })), ["crank angle [°]", "force [N]"]),
        lines("Force on three ring teeth of the first disc", x, [0, Math.floor(pins / 4), Math.floor(pins / 2)].map((at, row) => ({ name: `tooth ${at + 1}`, y: forceOn(at), look: ["teeth", "output", "cam"][row] })), ["crank angle [°]", "force [N]"]),
        lines("Loaded teeth", x, [{ name: "force above 1 % of the largest", y: carrying, look: "teeth" }], ["crank angle [°]", "teeth"])];
    });
  }

  #error() {
    return this.#of("error", data => {
      const [loaded, idle] = data.curves;
      return [
        lines("Transmission error of the output", data.crank_deg, [{ name: `${loaded.name}: ${number(loaded.peak_to_peak, 3)} arcsec peak to peak`, y: loaded.arcsec, look: "teeth" }, { name: `${idle.name}: ${number(idle.peak_to_peak, 3)} arcsec`, y: idle.arcsec, look: "output" }], ["crank angle [°]", "error [arcsec]"]),
        spikes("Orders at the load", data.orders, data.amplitudes, ["order [per crank turn]", "amplitude [arcsec]"], data.named),
        el("p", { class: "soft" }, "Static equilibrium without friction, mean value subtracted. Manufacturing errors are those of the design.")];
    });
  }

  #losses() {
    return this.#of("statics", data => {
      const { parts, input_power: supplied, output_power: out } = data.losses, lost = parts.reduce((sum, one) => sum + one.watts, 0);
      return [
        el("p", {}, "Losses ", el("b", {}, `${number(lost, 3)} W`), ` of ${number(supplied, 3)} W input power; output power ${number(Math.abs(out), 3)} W. ${data.condition}.`),
        bars(parts.map(one => ({ name: one.name, share: one.watts / Math.max(lost, 1e-12), text: `${number(one.watts, 3)} W · ${number(100 * one.watts / Math.max(lost, 1e-12), 3)} %`, look: "cam" })))];
    });
  }

  #life() {
    return this.#of("life", rating => [
      el("p", {}, `At ${rating.condition}; required life ${number(rating.required_h)} h. Rated torque `, el("b", {}, `${number(rating.rated_torque_nm, 3)} N m`), `, limited by: ${rating.limited_by}.`),
      judgedBars(rating.items, true),
      el("p", { class: "soft" }, "Bars show the margin on a logarithmic scale; at the line the requirement is just met. ✓ passed, ! warning, ✗ failed.")]);
  }

  // Progress of a job, and a button that stops it; created once and updated in place.
  #progress(job, data) {
    if (data) Object.assign(job, { number: data.job, progress: data.progress });
    if (!job.row) {
      job.bar = el("progress", { max: "1" });
      job.says = el("span", { class: "soft" });
      job.row = el("div", { class: "go" }, job.bar, job.says, el("button", { onclick: () => job.number && stop(job.number) }, "Stop"));
    }
    if (job.progress?.share === undefined) job.bar.removeAttribute("value");
    else job.bar.value = job.progress.share;
    job.says.textContent = `${job.words}: ${job.progress?.doing || "queued"}`;
    return job.row;
  }

  // Long studies: started by a button; intermediate results are shown as they arrive.
  #study(key, label, content, draw, before = null) {
    const last = this.last[key], job = this.jobs[key];
    const begin = async () => {
      const mine = this.jobs[key] = { design: this.state().design, words: label };
      this.last[key] = null;
      this.#draw();
      let seen = "";
      try {
        const done = await work({ kind: key, design: this.state().design, ...content() }, data => {
          this.#progress(mine, data);
          const found = data.progress?.seen || (data.progress?.parts && { parts: data.progress.parts });
          if (!found || JSON.stringify(found) === seen) return;
          seen = JSON.stringify(found);
          this.last[key] = { data: found };
          if (this.open === key && this.jobs[key] === mine) this.#draw();
        });
        if (done.result) this.last[key] = { data: done.result, old: mine.design !== this.state().design };
        announce(done.result ? `${TABS[key]}: finished` : `${TABS[key]}: stopped`);
        if (!done.result) mine.stopped = true;
      } catch (error) { this.last[key] = { words: error.message }; announce(`${TABS[key]}: ${error.message}`); }
      if (mine.stopped && this.last[key]) this.last[key].stopped = true;
      if (this.jobs[key] === mine) delete this.jobs[key];
      if (this.open === key) this.#draw();
    };
    return [
      job ? this.#progress(job) : el("div", { class: "go" }, before, el("button", { class: "strong", onclick: begin }, label)),
      last?.stopped ? el("p", { class: "near" }, `${JUDGED.warning.mark} Stopped before the end: these results are of the part that was computed.`) : null,
      last?.old ? el("p", { class: "near" }, `${JUDGED.warning.mark} The design has changed: these results are out of date.`) : null,
      last ? (last.words ? el("p", { class: "fails" }, last.words) : el("div", { class: last.old ? "old" : null }, draw(last.data))) : null];
  }

  #scatter() {
    const { shown } = this.state(), own = shown?.toleranced ?? false, method = METHODS[shown?.layout ?? "central"];
    const usual = this.spread ?? (own ? "" : Math.max(1, Math.round((shown?.controls.find(one => one.key.startsWith("clearance."))?.value || 4) / 4)));
    const typed = el("input", { type: "number", min: "0.1", step: "any", value: String(usual), placeholder: own ? "own" : "", id: "spread", oninput: event => { this.spread = event.target.value; } });
    const before = el("label", {}, "Tolerance of each size ± ", typed, " µm ");
    return [el("p", { class: "soft" }, `Monte Carlo study: ${method.scatter}${own ? " If the field is empty, the tolerances of the design are used." : ""} ${method.solved}`),
      ...this.#study("scatter", "Run Monte Carlo", () => ({ spread_um: typed.value === "" ? null : Number(typed.value) }), data => [
        el("p", {}, el("b", {}, `${data.samples} samples`), `, ${data.jam ? `of which ${number(100 * data.jam, 3)} % jam` : "none of which jams"}.`, el("span", { class: "sentence soft" }, `${data.condition}.`)),
        data.charts.map(one => histogram(one.name, one.edges, one.counts, one.unit, [[one.p05, "5 %"], [one.p50, "50 %"], [one.p95, "95 %"]])),
        data.budget?.length ? [el("h3", {}, `Share of each tolerance in the variance of: ${data.budget_of}`), bars(data.budget.map(one => ({ name: one.source.replaceAll("_", " "), share: one.share, text: `${number(100 * one.share, 2)} %`, look: "teeth" })))] : data.no_budget ? el("p", { class: "soft" }, `No error budget: ${data.no_budget}.`) : null], before)];
  }

  #stress() {
    const method = METHODS[this.state().shown?.layout ?? "central"];
    return [el("p", { class: "soft" }, `Stress of each part under the load: ${method.stress} This takes 15 s of CPU time or more.`),
      ...this.#study("stress", "Compute stresses", () => ({}), found => [
        el("p", { class: "scale" }, el("span", {}, "0"), el("span", { class: "colours", role: "img", "aria-label": "Colours from 0 to the limit of each part" }), el("span", {}, "limit")),
        el("table", { class: "stresses" }, el("thead", {}, el("tr", {}, ["Part", "Contact or fatigue (rating)", method.bulk].map(head => el("th", { scope: "col" }, head)))),
          el("tbody", {}, found.parts.map(part => el("tr", {}, el("th", { scope: "row" }, part.name), ["rated", "bulk"].map(kind => el("td", {}, part[kind].length ? bars(part[kind].map(row => ({ ...row, colour: row.colour, text: `${JUDGED[row.judgement].mark} ${row.text}`, look: JUDGED[row.judgement].look }))) : "–"))))))])];
  }

  #solid() {
    return this.#of("solid", data => {
      if (this.solid) this.solid.end();
      this.solid = new Solid(data);
      return this.solid.element;
    });
  }

  // The values in which A and B differ, in words; requested again when one of the designs has changed.
  #differences(a, b) {
    const key = JSON.stringify([a, b]);
    if (this.differing?.key !== key) {
      this.differing = { key, rows: null };
      const mine = this.differing;
      ask("compare", { a, b }).then(answer => { mine.rows = answer.rows; }, error => { toast(error.message); })
        .finally(() => { if (this.differing === mine && this.open === "compare") this.#draw(); });
    }
    return this.differing.rows;
  }

  #compare() {
    const { shown, statics, life, design, required } = this.state();
    const mine = { name: shown?.name, head: shown?.head, statics, life, design: { ...design }, required: { ...required } };
    const keep = el("button", { class: "strong", onclick: () => { this.other = mine; this.#draw(); } }, this.other ? "Keep this design as A instead" : "Keep this design as A");
    if (!this.other) return [el("p", {}, "Keep the present design as A, then change it: A and B are compared here."), keep];
    const rows = [["Ratio", one => one.head?.ratio, ":1"], ["Diameter", one => one.head?.diameter_mm, "mm"], ["Mass", one => one.head?.mass_kg, "kg"], ["Rated torque", one => one.life?.rated_torque_nm, "N m"], ["Life", one => one.life?.life_h, "h"]];
    const named = row => one => Number.parseFloat(one.statics?.rows.find(other => other.name === row.name)?.value);
    for (const row of statics?.rows || this.other.statics?.rows || []) rows.push([row.name, named(row), row.value.replace(/^[^ ]+ /, "")]);
    const differing = this.#differences(this.other.design, design);
    return [
      el("table", { class: "figures both" }, el("thead", {}, el("tr", {}, el("th", {}), el("th", { scope: "col" }, `A: ${this.other.name}`), el("th", { scope: "col" }, `B: ${mine.name}`), el("th", { scope: "col" }, "B / A"))),
        el("tbody", {}, rows.map(([name, value, unit]) => { const [a, b] = [value(this.other), value(mine)]; return el("tr", {}, el("th", { scope: "row" }, `${name} [${unit}]`), el("td", {}, number(a)), el("td", {}, number(b)), el("td", { class: "soft" }, a && b ? number(b / a, 3) : "–")); }),
          differing?.length ? el("tr", {}, el("th", { colspan: "4", class: "heading" }, "Values that differ")) : null,
          (differing || []).map(one => el("tr", {}, el("th", { scope: "row", class: "sentence", title: one.key }, one.label), el("td", {}, one.a), el("td", {}, one.b), el("td", {}))))),
      el("div", { class: "go" }, keep, el("button", { onclick: async () => { const a = this.other; this.other = mine; await this.swap(a); } }, "Swap A and B"))];
  }

  // Start a job that makes files; its progress is shown at the end of the tab.
  async #begin(kind, words) {
    this.wrong = "";
    const mine = this.jobs.make = { words };
    this.#draw();
    try {
      const done = await work({ kind, design: this.state().design, options: this.options() }, data => this.#progress(mine, data));
      if (done.files.length) download(done);
      if (done.page) this.report = done.job;
      announce(done.state === "done" ? `${words}: finished` : `${words}: stopped`);
    } catch (error) { toast(error.message); this.wrong = error.message; }
    delete this.jobs.make;
    if (this.open === "make") this.#draw();
  }

  #make() {
    const { motors = {}, beds = [], files: all = {} } = this.offers || {}, { shown } = this.state();
    const files = Object.fromEntries((shown?.files ?? []).map(kind => [kind, all[kind]])), closed = "3mf" in files; // only a drive with covers is printed and closed
    const running = this.jobs.make, blocked = Boolean(this.errors || running);
    const button = (kind, words, look = "") => el("button", { class: look, disabled: blocked && kind !== "toml", onclick: () => this.#begin(kind, words) }, words);
    const choice = (words, options, value, change) => el("label", { class: "choose" }, el("span", {}, words), el("select", { onchange: event => change(event.target.value) }, options.map(([key, word]) => el("option", { value: key, selected: key === value }, word))));
    const { printed } = this; // without parts of plastic there is no printer to choose
    const printer = change => { Object.assign(this.printer, change); };
    return [
      closed ? [
      el("h3", {}, "Drive"),
      el("div", { class: "go" }, choice("Motor", Object.entries(motors), this.options().motor, motor => { delete this.last.make; delete this.last.solid; this.choseMotor(motor); this.#want(); this.#draw(); }),
        printed ? choice("Printer bed", beds.map(bed => [bed, bed ? `${bed.split("x").join(" × ")} mm` : "one plate"]), this.printer.bed ?? "", bed => printer({ bed })) : null,
        printed ? el("label", { class: "choose" }, el("span", {}, "Printer offset [µm]"), el("input", { type: "number", min: "0", max: "500", step: "10", value: String(this.printer.offset_um ?? 0), onchange: event => printer({ offset_um: event.target.valueAsNumber || 0 }) })) : null),
      el("div", { class: "go" }, button("drive", "All files to build it (ZIP)", "strong"), el("span", { class: "soft" }, `${printed ? "Print plates with covers, test coupon" : "Shapes of all parts (3MF)"}, bill of materials, drawings, order of assembly, STEP`))]
        : el("p", { class: "soft" }, "Motor flange, print plate, bill of materials and order of assembly do not apply: an RV reducer is modelled without covers, and its parts are machined."),
      running ? this.#progress(running) : null,
      this.wrong ? el("p", { class: "fails" }, this.wrong) : null,
      this.errors ? el("p", { class: "fails" }, "This design cannot be built. Resolve its errors first: the buttons above the tabs do so.") : null,
      el("h3", {}, "Single files"), el("div", { class: "make" }, Object.entries(files).map(([kind, words]) => button(kind, words))),
      el("h3", {}, "Simulation"), el("div", { class: "go" }, button("run", "Run in MuJoCo"),
        this.report ? el("a", { href: `/report/${this.report}`, target: "_blank" }, "Report of the run") : el("span", { class: "soft" }, "One crank turn at full speed under the load. The report opens in a new window.")),
      this.errors || !closed ? null : this.#of("make", data => this.#drive(data))];
  }

  // Size, bill and order of assembly of the drive with its covers.
  #drive(data) {
    return [
      data.reason ? el("p", { class: "near" }, `${JUDGED.warning.mark} The covers do not fit, so that the drive cannot be closed: ${data.reason}`)
        : el("p", {}, "With covers for ", el("b", {}, data.motor), `: ${number(data.diameter_mm)} mm diameter, ${number(data.length_mm)} mm long, `, el("b", {}, `${number(data.mass_kg, 3)} kg`), " without motor and grease."),
      el("h3", {}, "Bill of materials"),
      el("div", { class: "wide", role: "region", tabindex: "0", "aria-label": "Bill of materials" }, el("table", { class: "bill" }, el("thead", {}, el("tr", {}, ["Part", "Number", "Source", "Material or designation", "Mass [g]", "Price of a piece"].map(head => el("th", { scope: "col" }, head)))),
        el("tbody", {}, data.bill.map(row => el("tr", {}, el("th", { scope: "row" }, row.item, el("small", {}, row.size)), el("td", {}, String(row.count)), el("td", { class: `source ${row.source}` }, row.source), el("td", {}, [row.material, row.designation].filter(Boolean).join(", ")), el("td", {}, number(row.mass_g, 3)), el("td", {}, row.price)))))),
      el("p", { class: "soft" }, "Made: turned, milled or ground in a workshop. Prices are classes assumed by kind and mass, not quotations. The mass is that of all pieces."),
      data.consumables.length ? el("p", { class: "soft" }, `Also needed: ${data.consumables.join("; ")}.`) : null,
      data.order.length ? [el("h3", {}, "Order of assembly"), el("ol", { class: "order" }, data.order.map(step => el("li", {}, step.replaceAll("_", " "))))] : null];
  }
}
