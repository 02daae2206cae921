// The page: its state, which is kept in the address; requests after a change; undo and redo; files.

import { ask, newest, work, download } from "./net.js";
import { el, byId, number, toast, announce, fill, refill, JUDGED } from "./dom.js";
import { Section } from "./section.js";
import { showControls, markControl, filterControls } from "./controls.js";
import { Tabs } from "./tabs.js";
import { Start } from "./start.js";

const state = { design: {}, required: {}, name: "", shown: null, statics: null, life: null, checks: null, remedies: {} };
const history = { past: [], at: -1, key: "", time: 0 };
const COALESCED = 900; // ms: changes of one slider within this time are undone together
const ADDRESSED = 250; // ms from a change to the update of the address

const section = new Section(byId("section"), byId("crank-row"), byId("controls"), byId("legend"));
const tabs = new Tabs(byId("tabs"), () => state, apply);
const start = new Start(byId("start"), take, open);

// --- requests

const solved = {
  statics: newest("statics", data => { state.statics = data; showHead(); tabs.receive("statics", data); }, words => { state.statics = null; showHead(); tabs.receiveError("statics", words); }),
  forces: newest("forces", data => { section.forces(data); tabs.receive("forces", data); }, words => { section.forces(null); tabs.receiveError("forces", words); }),
  checks: newest("checks", data => { state.checks = data; showRemedies(); showHead(); askRemedies(); }, words => showChecks([], { judgement: "failed", words: "The checks could not run" }, words)),
  life: newest("life", data => { state.life = data; showHead(); tabs.receive("life", data); }, words => { state.life = null; showHead(); tabs.receiveError("life", words); }),
};
// After the checks, a question for each warning: none of them holds up the results of the next change for long.
const remediesOf = newest("remedies", data => { state.remedies[data.name] = data.changes; showRemedies(); askRemedies(); }, toast);

section.nextTurn = turn => ask("forces", { design: state.design, turn });

let pending = null, drawing = false;

export async function apply(changes, { step = true } = {}) {
  pending = { ...pending, ...changes };
  if (drawing) return;
  drawing = true;
  while (pending) {
    const sent = pending;
    pending = null;
    let data;
    try {
      data = await ask("draw", { design: state.design, changes: sent, play: section.play, required: state.required });
    } catch (error) {
      refuse(sent, error.message);
      continue;
    }
    show(data);
    if (step) remember(Object.keys(sent).join());
  }
  drawing = false;
}

function show(data) {
  state.design = data.design;
  state.name = data.name;
  state.shown = data;
  state.remedies = {};
  remediesOf.drop();
  if (!data.errors.length) for (const one of Object.values(solved)) one.ask({ design: state.design, required: state.required, options: tabs.options() }); // solved by the workers while the browser draws
  showControls(byId("parameters"), data.controls, apply);
  find();
  section.show(data.section, data.errors);
  byId("name").value = data.name;
  document.title = `${data.name}: ${data.head.ratio}:1, ${number(data.head.diameter_mm)} mm – cycloid_mj`;
  showWrong(data.errors);
  if (data.errors.length) {
    state.statics = state.life = state.checks = null;
    for (const one of Object.values(solved)) one.drop();
    section.forces(null);
    showChecks(data.errors, { judgement: "failed", words: `This design cannot be built: ${data.errors.length} ${data.errors.length > 1 ? "errors" : "error"}` });
    tabs.broken(data.errors);
  } else {
    for (const id of ["head", "checks"]) byId(id).classList.add("old");
    tabs.changed();
  }
  showHead();
}

// Remove everything that belongs to the previous design: another one replaces it.
function another() {
  state.statics = state.life = state.checks = null;
  fill(byId("checks"), el("p", { class: "soft" }, "Checking …"));
  tabs.another();
}

function refuse(changes, words) {
  if (Object.keys(changes).length && state.shown) {
    showControls(byId("parameters"), state.shown.controls, apply);
    for (const key of Object.keys(changes)) markControl(key, words);
  }
  toast(words);
}

// --- the header

function showHead() {
  const { shown, statics, life } = state;
  if (!shown) return;
  const broken = shown.errors.length > 0;
  const head = shown.head, cased = life?.cased;
  const verdicts = { ...head.verdicts, ...(broken ? {} : { ...statics?.verdicts, ...life?.verdicts }) };
  const covers = cased ? `with covers ${number(cased.diameter_mm)} mm` : life?.no_covers ? "no covers fit" : null;
  const mass = cased ? cased.mass_kg : head.mass_kg;
  const figures = [
    ["ratio", `${head.ratio}:1`, "ratio"],
    ["diameter", `${number(head.diameter_mm)} mm`, "diameter_mm", covers],
    ...(verdicts.length_mm || cased || life?.length_mm ? [["length", cased || life?.length_mm ? `${number(cased?.length_mm ?? life.length_mm)} mm` : "–", "length_mm", life?.length_mm ? null : "with covers"]] : []),
    ["mass", mass === null ? "–" : `${number(mass, 3)} kg`, "", cased && `with covers, mechanism ${number(head.mass_kg, 3)} kg`],
    ["rated torque", broken ? "–" : life ? `${number(life.rated_torque_nm, 3)} N m` : "…", "torque_nm", life && !broken && `emergency stop ${number(life.momentary_torque_nm, 3)} N m`],
    ["backlash", broken ? "–" : statics ? `${number(statics.backlash_arcmin, 3)} arcmin` : "…", "backlash_arcmin"],
    [`life at ${number(shown.load_nm, 3)} N m`, broken ? "–" : life ? life.life : "…", "life_h"],
  ];
  byId("head").classList.toggle("old", !broken && !(statics && life));
  if (!broken && statics && life && state.checks) sayResults(figures, verdicts);
  fill(byId("head"), ...figures.map(([name, value, field, also]) => {
    const verdict = verdicts[field], judged = verdict && JUDGED[verdict.judgement];
    return el("div", { class: `figure ${judged?.look ?? ""}` },
      el("b", {}, value, judged ? el("span", { class: "mark", role: "img", "aria-label": judged.word }, ` ${judged.mark}`) : null),
      el("small", {}, name, verdict ? el("i", {}, ` · required: ${verdict.words}`) : null, also ? el("i", {}, ` · ${also}`) : null));
  }));
}

// Announce the results once they are complete and no slider has moved for a moment; equal words are not said again.
function sayResults(figures, verdicts) {
  const judged = field => (verdicts[field] ? ` (${JUDGED[verdicts[field].judgement].word})` : "");
  announce(`${figures.slice(1).map(([name, value, field]) => `${name} ${value}${judged(field)}`).join(", ")}. ${state.checks.words}.`);
}

// --- the search among the parameters

let finding = 0;

async function find() {
  const text = byId("find").value.trim(), mine = finding += 1;
  const count = filterControls(byId("parameters"), text);
  let others = [];
  if (text) try { others = (await ask("find", { design: state.design, text })).controls; } catch (error) { toast(error.message); }
  if (mine !== finding) return;
  byId("others").hidden = !others.length;
  if (others.length) showControls(byId("others"), others, apply);
  byId("none").hidden = Boolean(count || others.length);
}

byId("find").addEventListener("input", async () => {
  await find();
  const shown = document.querySelectorAll("#parameters-of .control:not([hidden])").length - (byId("others").hidden ? byId("others").querySelectorAll(".control").length : 0);
  announce(`${shown} parameters`);
});

// On a narrow screen the parameters follow the picture, in the order of the keys as on the screen.
const narrow = matchMedia("(max-width: 760px)");
function order() {
  const [parameters, picture] = [byId("parameters-of"), document.querySelector(".picture")];
  if (narrow.matches) picture.after(parameters); else picture.before(parameters);
  byId("parameters-open").open = !narrow.matches;
}
narrow.addEventListener("change", order);
order();

// --- failures and warnings

function showWrong(errors) {
  const box = byId("wrong");
  if (!errors.length && box.contains(document.activeElement)) byId("checks").focus();
  box.hidden = !errors.length;
  if (!errors.length) return;
  const [first, ...others] = errors;
  refill(box,
    el("b", {}, "This design cannot be built."), el("p", {}, `${first.what}: ${first.why}`),
    remedies(first), others.length ? el("small", {}, `and ${others.length} more in the list of checks`) : null);
}

function remedies(check) {
  return el("div", { class: "remedies" }, check.changes.map(change => el("button",
    { class: "remedy", title: `Sets ${Object.entries(change.changes).map(([key, value]) => `${key} = ${value}`).join(", ")}`, onclick: () => apply(change.changes) }, change.words)));
}

// The checks, with the remedies that were tried for those without one; either may arrive first.
function showRemedies() {
  if (!state.checks) return;
  for (const one of state.checks.failed) one.changes = state.remedies[one.name] ?? one.changes;
  showChecks(state.checks.failed, state.checks);
}

function askRemedies() {
  const next = state.checks?.failed.find(one => !one.remedy && !one.changes.length && !state.remedies[one.name]);
  if (next) remediesOf.ask({ design: state.design, check: next.name });
}

function showChecks(failed, verdict, words = "") {
  const open = new Set([...byId("checks").querySelectorAll("details[open]")].map(one => one.dataset.name));
  const { mark, look } = JUDGED[verdict.judgement];
  byId("checks").classList.remove("old");
  refill(byId("checks"),
    el("h2", { class: look }, el("span", { class: "mark" }, mark), verdict.words),
    words ? el("p", {}, words) : null,
    ...failed.map((one, index) => el("details", { class: one.severity, "data-name": one.name, open: index < 1 || open.has(one.name) },
      el("summary", {}, el("span", { class: "badge" }, String(index + 1)), one.name),
      el("p", {}, `${one.what}: ${one.why}.`),
      one.changes.length ? remedies(one) : el("p", { class: "soft" }, one.remedy || (state.remedies[one.name] ? "No single change was found that resolves it." : "Searching for a change that resolves it …")))));
  section.marks(failed);
}

// --- history and address

function remember(key) {
  const now = performance.now();
  const entry = { design: { ...state.design }, required: { ...state.required } };
  if (JSON.stringify(entry) !== JSON.stringify(history.past[history.at])) {
    if (!(key && key === history.key && now - history.time < COALESCED)) history.at += 1;
    history.past.splice(history.at, Infinity, entry);
    Object.assign(history, { key, time: now });
  }
  address();
}

// The address is updated after the drawing: changing it takes the browser as long as everything else.
function address() {
  byId("undo").disabled = history.at < 1;
  byId("redo").disabled = history.at >= history.past.length - 1;
  clearTimeout(history.timer);
  history.timer = setTimeout(writeAddress, ADDRESSED);
}

function writeAddress() {
  clearTimeout(history.timer);
  const values = new URLSearchParams();
  for (const [key, value] of Object.entries(state.design)) values.set(key, typeof value === "string" ? value : JSON.stringify(value));
  for (const [key, value] of Object.entries(state.required)) if (value !== null && value !== "") values.set(`required.${key}`, typeof value === "string" ? value : JSON.stringify(value));
  window.history.replaceState(null, "", `#${values}`);
}

function fromAddress() {
  const design = {}, required = {};
  for (const [name, text] of new URLSearchParams(location.hash.slice(1))) {
    const key = name.replace(/^asked\./, "required."); // addresses of version 0.2
    let value = text;
    try { value = JSON.parse(text); } catch { /* not JSON: a word */ }
    if (key.startsWith("required.")) required[key.slice(9)] = value; else design[key] = value;
  }
  return { design, required };
}

// Show the design that answers a question; return whether there is one.
async function replace(question, content, required) {
  let data;
  try {
    data = await ask(question, { ...content, play: section.play, required });
  } catch (error) {
    toast(error.message);
    return false;
  }
  state.required = { ...required };
  another();
  show(data);
  return true;
}

async function put(entry, step = true) {
  const shown = await replace("draw", { design: entry.design, changes: {} }, entry.required);
  if (shown && step) remember("");
  else if (shown) address();
  return shown;
}

async function back(by) {
  const entry = history.past[history.at + by];
  if (!entry) return;
  history.at += by;
  history.key = "";
  await put(entry, false);
}

function take(drive, form) { return put({ design: drive.design, required: form }); }

// --- files

async function open(content) {
  const shown = await replace("open", content, {});
  if (shown) remember("");
  return shown;
}

async function save() {
  try {
    download(await work({ kind: "toml", design: state.design }));
  } catch (error) { toast(error.message); }
}

byId("file").addEventListener("change", async event => {
  const file = event.target.files[0];
  if (file) await open({ text: await file.text(), name: file.name });
  event.target.value = "";
});
byId("open").addEventListener("click", () => byId("file").click());
byId("save").addEventListener("click", save);
byId("new").addEventListener("click", () => start.open(state.required));
byId("undo").addEventListener("click", () => back(-1));
byId("redo").addEventListener("click", () => back(1));
byId("skip").addEventListener("click", () => byId("tabs").querySelector("[aria-selected=true]").focus());
byId("name").addEventListener("change", event => apply({ name: event.target.value.trim() }));
section.changedPlay = () => apply({}, { step: false });

document.addEventListener("keydown", event => {
  if (!(event.ctrlKey || event.metaKey)) return;
  const key = event.key.toLowerCase();
  const does = { z: () => back(event.shiftKey ? 1 : -1), y: () => back(1), s: save, o: () => byId("file").click() }[key];
  if (does) { event.preventDefault(); does(); }
});
window.addEventListener("hashchange", () => put(fromAddress()));
window.addEventListener("pagehide", writeAddress);

tabs.swap = entry => put(entry);
tabs.choseMotor = motor => {
  state.required = { ...state.required, motor };
  if (!state.shown.errors.length) solved.life.ask({ design: state.design, required: state.required, options: tabs.options() });
  remember("motor");
};

// --- start

const offers = await ask("start");
start.offer(offers);
tabs.offer(offers);
const given = location.hash.length > 1 ? fromAddress() : null;
const entry = given || { design: offers.design, required: {} };
if (!(await put(entry)) && given) await put({ design: offers.design, required: {} });
if (!given && offers.fresh) start.open({});
