// The start form: the requirements of a drive. The answer is up to three drives, or the largest feasible torque and alternatives as buttons.

import { work, stop } from "./net.js";
import { el, number, fill, refill, announce, JUDGED } from "./dom.js";

const FIELDS = [
  ["ratio", "Ratio", ": 1", 15, { min: 3, max: 150, step: 1 }, "Input turns per output turn"],
  ["diameter_mm", "Diameter", "mm", 60, { min: 1, step: "any" }, "Outer diameter with covers, at most"],
  ["torque_nm", "Torque", "N m", 2, { min: 0, step: "any" }, "Continuous output torque; twice this is allowed as a peak"],
  ["life_h", "Life", "h", "", { min: 1, step: "any" }, "Hours at this torque"],
];
const MORE = [
  ["speed_rpm", "Crank speed", "rpm", "", { min: 1, step: "any" }, "Motor speed"],
  ["duty_percent", "Time under load", "%", "", { min: 1, max: 100, step: "any" }, "100: continuous; the rest of the time the drive cools"],
  ["length_mm", "Maximum length", "mm", "", { min: 1, step: "any" }, "Empty: no limit"],
  ["backlash_arcmin", "Maximum backlash", "arcmin", "", { min: 0, step: "any" }, "Empty: no limit. Clearances are chosen to suit"],
];
const OF_PROCESS = ["life_h", "speed_rpm", "duty_percent"]; // fields whose default depends on the process
const COOLING = { still: "still air", mounted: "mounted on a machine", fan: "fan" };
const PROCESS = { printed: ["Printed", "plastic, clearances of 0.1 mm"], milled: ["Milled", "tempered steel, 20 µm"], steel: ["Steel", "hardened and ground, 5 µm"] };
const LAYOUT = { 0: ["One or two discs", "two if one is not sufficient"], 1: ["One disc", "simplest; unbalanced"], 2: ["Two discs", "balanced"], rv: ["RV reducer", "planetary stage, two discs, two or three cranks; ratios 31 to 321"] };
const RV_RATIOS = { min: "31", max: "321" };

export class Start {
  constructor(dialog, take, open) { Object.assign(this, { dialog, take, open_: open, offers: null, job: null, search: null }); }

  offer(offers) { this.offers = offers; }

  open(required) {
    const process = required.process || "printed", layout = required.layout === "rv" ? { discs: "rv" } : {};
    this.#build({ process, discs: 1, ...Object.fromEntries([...FIELDS, ...MORE].map(([key, , , value]) => [key, value])), ...this.#usual({ process, ...layout }), material: "", ...required, ...layout });
    this.dialog.showModal();
    this.form.elements.ratio.select();
  }

  // Usual values of a process, or of RV reducers.
  #usual({ process, discs }) { return discs === "rv" ? this.offers.rv : this.offers.processes[process]; }

  #build(values) {
    values.process ??= "printed";
    const field = ([key, label, unit, , range, hint]) => el("label", { class: "field" }, el("span", {}, label),
      el("span", { class: "entry" }, el("input", { name: key, type: "number", value: String(values[key] ?? ""), ...Object.fromEntries(Object.entries(range).map(([a, b]) => [a, String(b)])), inputmode: "decimal", required: FIELDS.some(one => one[0] === key) }), el("span", { class: "unit" }, unit)),
      el("small", {}, hint));
    const choice = (name, options, chosen) => el("div", { class: "choice" }, Object.entries(options).map(([value, [word, hint]]) => el("label", {},
      el("input", { type: "radio", name, value, checked: String(chosen) === value }), el("span", {}, el("b", {}, word), el("small", {}, hint)))));
    this.answer = el("div", { class: "answer" });
    this.material = el("select", { name: "material" });
    const materials = () => {
      const before = values.material;
      const usual = this.#usual(values);
      fill(this.material, el("option", { value: "" }, `default: ${usual.material}`), ...this.offers.materials.map(name => el("option", { value: name, selected: name === before }, name)));
    };
    // Another process or layout: fields with the default of the previous one get its own.
    const defaults = () => {
      const before = this.#usual(values);
      Object.assign(values, { process: this.form.elements.process.value, discs: this.form.elements.discs.value });
      const now = this.#usual(values);
      for (const key of OF_PROCESS) if (this.form.elements[key].value === String(before[key] ?? "")) this.form.elements[key].value = String(now[key] ?? "");
      materials();
      suit();
    };
    // Fields that the search for RV reducers does not support are hidden.
    const suit = () => {
      const rv = values.discs === "rv";
      for (const name of ["process", "motor", "backlash_arcmin", "material"]) {
        const [one] = [this.form.elements[name]].flatMap(item => (item instanceof RadioNodeList ? [...item] : [item]));
        (one.closest("fieldset") ?? one.closest(".field")).hidden = rv;
      }
      Object.assign(this.form.elements.ratio, rv ? RV_RATIOS : { min: "3", max: "150" });
    };
    const select = (name, label, options, hint) => el("label", { class: "field" }, el("span", {}, label), el("select", { name }, options.map(([key, words]) => el("option", { value: key, selected: key === (values[name] ?? "") }, words))), el("small", {}, hint));
    this.form = el("form", { novalidate: false, onsubmit: event => { event.preventDefault(); this.#find(this.#read()); }, onchange: event => ["process", "discs"].includes(event.target.name) && defaults() },
      el("div", { class: "fields" }, FIELDS.map(field)),
      el("fieldset", {}, el("legend", {}, "Manufacturing process"), choice("process", PROCESS, values.process)),
      el("fieldset", {}, el("legend", {}, "Layout"), choice("discs", LAYOUT, values.discs)),
      el("details", { open: MORE.some(([key, , , usual]) => (values[key] ?? "") !== (this.#usual(values)[key] ?? usual)) || Boolean(values.material) || (values.motor ?? "auto") !== "auto" }, el("summary", {}, "More: motor, speed, duty, length, backlash, material"),
        el("div", { class: "fields" }, select("motor", "Motor", Object.entries(this.offers.motors), "Its flange and shaft are part of the covers"), MORE.map(field), select("cooling", "Cooling", this.offers.cooling.map(name => [name, COOLING[name] ?? name]), "Of the housing"), el("label", { class: "field" }, el("span", {}, "Material"), this.material, el("small", {}, "Material of disc and housing")))),
      el("div", { class: "go" }, el("button", { class: "strong", type: "submit" }, "Find drives"), el("span", { class: "soft" }, "Search by static load and life calculation, with standard pins and bearings")));
    fill(this.dialog,
      el("form", { method: "dialog", class: "close" }, el("button", { "aria-label": "Close" }, "×")),
      el("h2", { id: "start-title" }, "Requirements of the drive"), this.form, this.answer,
      el("p", { class: "instead" }, "Or start from ", this.offers.presets.map((name, index) => [index ? ", " : "", el("button", { class: "link", type: "button", onclick: async () => { if (await this.open_({ preset: name })) this.#shut(); } }, name)]),
        " or ", el("button", { class: "link", type: "button", onclick: () => { this.dialog.close(); document.getElementById("open").click(); } }, "a design file"), "."));
    materials();
    suit();
    this.dialog.onclose = () => this.#stop();
  }

  #read() {
    const form = {};
    for (const input of this.form.elements) {
      if (!input.name || (input.type === "radio" && !input.checked) || input.value === "" || input.closest("[hidden]")) continue;
      form[input.name] = input.type === "number" || input.name === "discs" ? Number(input.value) : input.value;
    }
    if (this.form.elements.discs.value !== "rv") return form;
    delete form.discs;
    return { ...form, layout: "rv" };
  }

  // A drive was chosen: move the focus to its checks.
  #shut() {
    this.dialog.close();
    document.getElementById("checks").focus();
  }

  #stop() {
    if (this.job) stop(this.job).catch(() => {});
    this.job = this.search = null;
    clearInterval(this.clock);
  }

  // Search with other values, and show them in the form.
  #instead(required) {
    required = { ...required, motor: this.form.elements.motor.value };
    this.#build({ ...required, material: required.material || "", ...(required.layout === "rv" ? { discs: "rv" } : {}) });
    this.form.querySelector("[type=submit]").focus(); // the button of the alternative is gone
    this.#find(Object.fromEntries(Object.entries({ ...required, motor: required.motor || "auto" }).filter(([, value]) => value !== null && value !== "")));
  }

  async #find(form) {
    this.#stop();
    const began = performance.now(), focused = document.activeElement;
    const time = el("span", {}), doing = el("span", {}, "searching"), found = el("div", {});
    fill(this.answer,
      el("div", { class: "busy" }, el("span", { class: "spinner", "aria-hidden": "true" }), doing, " · ", time, el("button", { type: "button", onclick: () => { this.#stop(); fill(this.answer); } }, "Stop")), found);
    const tick = () => { time.textContent = `${Math.round((performance.now() - began) / 1000)} s`; };
    tick();
    this.clock = setInterval(tick, 500);
    const look = () => (found.firstChild ? found : this.answer).scrollIntoView({ block: "nearest" });
    look();
    // Move the focus to the answer, but not while the user is typing, or has already chosen.
    const attend = () => { if ([focused, document.body, this.dialog].includes(document.activeElement)) found.querySelector("button")?.focus(); };
    const search = this.search = {};
    let listed = -1;
    try {
      const job = await work({ kind: "size", form }, data => {
        if (this.search !== search) return stop(data.job).catch(() => {}); // another one has replaced it
        this.job = data.job;
        if (data.progress?.doing) doing.textContent = data.progress.doing;
        const answer = data.progress?.answer;
        if (!answer) return;
        doing.textContent = answer.drives.length ? "comparing it with stiffer drives and longer lives" : "searching for alternatives: life, duty, speed, cooling, material, size";
        const count = answer.drives.length || answer.remedies.length;
        if (count === listed) return; // the buttons stay: one may just be about to be pressed
        const first = listed < 0;
        listed = count;
        if (answer.drives.length) this.#drives(found, answer);
        else this.#refused(found, answer, false);
        if (!first) return; // later ones must not move the text that is being read
        announce(found.querySelector("h3").textContent);
        look();
        if (answer.drives.length) attend();
      });
      if (this.search !== search || !job.result) return;
      this.job = null;
      clearInterval(this.clock);
      this.answer.firstChild.remove();
      if (job.result.drives.length) this.#drives(found, job.result);
      else this.#refused(found, job.result, true);
      announce(found.querySelector("h3").textContent);
      attend();
    } catch (error) {
      if (this.search !== search) return;
      clearInterval(this.clock);
      this.job = null;
      fill(this.answer, el("p", { class: "refusal fails" }, el("b", {}, `${JUDGED.failed.mark} `), error.message), el("p", { class: "soft" }, "Change a value above and search again."));
    }
  }

  #drives(container, answer) {
    const rows = [["mass_kg", "Mass", "kg"], ["drive_diameter_mm", "Diameter with covers", "mm", "diameter_mm"], ["drive_length_mm", "Length", "mm", "length_mm"], ["rated_torque_nm", "Rated torque", "N m", "torque_nm"], ["momentary_torque_nm", "Emergency-stop torque", "N m"],
      ["stiffness_nm_per_arcmin", "Stiffness", "N m/arcmin"], ["backlash_arcmin", "Backlash", "arcmin", "backlash_arcmin"], ["temperature_c", "Housing temperature", "°C"]];
    const { mark, look } = JUDGED[answer.verdict.judgement];
    const judged = (drive, field) => { const verdict = drive.verdicts[field]; return verdict && verdict.judgement !== "passed" ? { class: JUDGED[verdict.judgement].look, title: `required: ${verdict.words}` } : {}; };
    refill(container, el("h3", { class: look }, `${mark} ${answer.verdict.words}`),
      el("div", { class: "drives" }, answer.drives.map((drive, at) => el("article", { class: at ? "" : "first" },
        el("h4", {}, drive.title), el("p", { class: "soft" }, drive.why),
        drive.verdict.words ? el("p", { class: JUDGED[drive.verdict.judgement].look }, `${JUDGED[drive.verdict.judgement].mark} ${drive.verdict.words}`) : null,
        el("dl", {}, rows.map(([key, word, unit, field]) => [el("dt", {}, word), el("dd", judged(drive, field), `${number(drive.figures[key], 3)} ${unit}`)]), el("dt", {}, "Life"), el("dd", judged(drive, "life_h"), drive.life)),
        el("button", { type: "button", class: at ? "" : "strong", onclick: async () => { if (await this.take(drive, { ...answer.required, motor: this.form.elements.motor.value })) this.#shut(); } }, "Use this drive")))));
  }

  #refused(container, answer, done) {
    const most = answer.max_torque_nm ? `${number(answer.max_torque_nm, 3)} N m` : "";
    refill(container,
      el("h3", { class: "fails" }, `${JUDGED.failed.mark} No design reaches ${number(answer.required.torque_nm)} N m with these requirements`),
      el("p", {}, answer.max_torque_nm ? ["Maximum: ", el("b", {}, most), `, limited by: ${answer.limit}.`] : `${answer.limit}.`),
      el("h4", {}, done ? "Alternatives" : "Alternatives so far"),
      el("div", { class: "alternatives" },
        answer.remedies.map(remedy => el("button", { type: "button", class: "alternative", onclick: () => this.#instead(remedy.required) }, el("b", {}, remedy.words), el("small", {}, this.#also(remedy.required)))),
        answer.max_torque_nm ? el("button", { type: "button", class: "alternative less", onclick: () => this.#instead({ ...answer.required, torque_nm: answer.max_torque_nm }) }, el("b", {}, most), el("small", {}, "the same requirements with less torque")) : null,
        !answer.remedies.length && done && !answer.max_torque_nm ? el("p", { class: "soft" }, "No alternative was found. Try a larger diameter, a smaller torque or another process.") : null));
  }

  #also(required) {
    return `${required.ratio}:1, ${number(required.diameter_mm)} mm, ${number(required.torque_nm)} N m, ${required.layout === "rv" ? LAYOUT.rv[0] : PROCESS[required.process]?.[0].toLowerCase() ?? required.process}`;
  }
}
