"use strict";
// Puts the figures in their places and lets them share time.

const THEORY = "var(--theory)";
const SIMULATED = "var(--simulated)";
const ERROR = "var(--error)";
const tint = (colour) => `color-mix(in srgb, ${colour} 65%, var(--paper))`;
/** Width [px] of half a page, for which a printed chart is drawn. */
const PRINTED = 340;

const data = unpacked(JSON.parse(document.getElementById("data").textContent));
const several = data.runs.length > 1;

/** Give the span that all runs have together. */
function union(key) {
  const spans = data.runs.map((run) => run.spans[key]);
  return [Math.min(...spans.map((span) => span[0])), Math.max(...spans.map((span) => span[1]))];
}

/** Give the curves of a panel: the closed forms, broad and light, under the simulations. */
function curvesOf(panel) {
  const theories = [];
  const simulations = [];
  for (const run of data.runs) {
    const base = { x: run.time, offset: run.start };
    if (panel.theory && run.curves[panel.theory]) {
      const colour = several ? tint(run.colour) : THEORY;
      const name = several ? "" : panel.theory_name;
      theories.push({ ...base, y: run.curves[panel.theory], colour, width: 4, name });
    }
    if (run.curves[panel.curve]) {
      const colour = several ? run.colour : panel.is_error ? ERROR : SIMULATED;
      const name = several ? run.name : panel.theory ? "simulation" : "";
      simulations.push({ ...base, y: run.curves[panel.curve], colour, width: 1.1, name });
    }
  }
  return [...theories, ...simulations];
}

function drawCharts(view) {
  for (const figure of data.figures) {
    const place = document.querySelector(`#figure-${figure.name} .chart`);
    const panels = figure.panels
      .map((panel) => ({ label: panel.label, height: panel.height, zero: panel.is_error, curves: curvesOf(panel) }))
      .filter((panel) => panel.curves.length);
    const shaded = several ? null : data.runs[0].spans.turn;
    new Chart(place, view, panels, { xLabel: "time [s]", shaded });
  }
}

function drawPaths() {
  for (const place of document.querySelectorAll("[data-path]")) {
    const runs = data.runs.filter((run) => run.paths[place.dataset.path]);
    const first = runs[0].paths[place.dataset.path];
    const lines = runs.flatMap((run) => {
      const { simulated, theory } = run.paths[place.dataset.path];
      const light = { points: theory, colour: several ? tint(run.colour) : THEORY, width: 4 };
      const dark = { points: simulated, colour: several ? run.colour : SIMULATED, width: 1.1 };
      return theory ? [light, dark] : [dark];
    });
    new Plane(place, lines, first.unit, first.circle ?? 0);
  }
}

function drawSpectrum() {
  const place = document.querySelector("#figure-spectrum .chart");
  const runs = data.runs.filter((run) => run.spectrum);
  if (!place || !runs.length) return;
  const highest = Math.max(...runs.map(({ spectrum }) => spectrum.order[spectrum.order.length - 1]));
  const view = new View([0, highest]);
  view.limits = view.home;
  const curvesOfPart = (part) =>
    runs.map(({ name, colour, spectrum }) => ({
      name: several ? name : "",
      x: spectrum.order,
      offset: 0,
      y: spectrum[part],
      colour: several ? colour : SIMULATED,
      width: 1.2,
    }));
  const marks = [];
  for (const mesh of new Set(runs.map((run) => run.spectrum.mesh))) {
    for (let order = mesh; order < highest; order += mesh) marks.push(order);
  }
  const panels = ["output", "gear"].map((part) => {
    return { label: `${part} [mrad/s]`, height: 1.1, fromZero: true, curves: curvesOfPart(part) };
  });
  new Chart(place, view, panels, { xLabel: "order [cycles per crank turn]", marks });
}

/** Let the buttons of the toolbar choose what is seen. */
function listenToSpans(view) {
  const buttons = [...document.querySelectorAll("[data-span]")];
  const show = () => {
    for (const button of buttons) {
      const span = union(button.dataset.span);
      const pressed = Math.abs(span[0] - view.span[0]) + Math.abs(span[1] - view.span[1]) < 1e-9;
      button.setAttribute("aria-pressed", String(pressed));
    }
  };
  for (const button of buttons) button.addEventListener("click", () => view.zoom(union(button.dataset.span)));
  view.on((what) => what === "span" && show());
  show();
}

/** Move the mechanisms: by the slider, by playing, or after the charts' cursor. */
function animate(view) {
  const mechanisms = data.runs.flatMap((run, i) =>
    run.mechanism ? [new Mechanism(document.getElementById(`mechanism-${i}`), run.mechanism)] : [],
  );
  if (!mechanisms.length) return;
  const get = (id) => document.getElementById(id);
  const [play, slider, pace, magnify, forces] = ["play", "frame", "pace", "magnify", "forces"].map(get);
  let playing = 0;
  let share = 0;
  const frameOf = (mechanism) => Math.min(mechanism.count - 1, Math.floor(share * mechanism.count));
  const show = (tellCharts) => {
    for (const mechanism of mechanisms) mechanism.draw(frameOf(mechanism));
    slider.value = String(Math.round(1000 * share));
    const { start, time } = mechanisms[0].frames;
    if (tellCharts) view.point(start + time[frameOf(mechanisms[0])], animate);
  };
  const usual = Math.min(...mechanisms.map(({ shape }) => shape.usual));
  for (const { times } of mechanisms[0].shape.magnifications) {
    const option = new Option(String(times), String(times), false, times === usual);
    magnify.add(option);
  }
  const enlarge = () => {
    for (const mechanism of mechanisms) mechanism.magnify(Number(magnify.value));
    show(false);
  };
  magnify.addEventListener("change", enlarge);
  forces.addEventListener("change", () => {
    for (const mechanism of mechanisms) mechanism.showForces = forces.checked;
    show(false);
  });
  slider.addEventListener("input", () => {
    share = Number(slider.value) / 1000;
    show(true);
  });
  const step = (last) => (now) => {
    if (!playing) return;
    share = (share + (now - last) / (1000 * Number(pace.value))) % 1;
    show(true);
    playing = requestAnimationFrame(step(now));
  };
  play.addEventListener("click", () => {
    if (playing) cancelAnimationFrame(playing);
    playing = playing ? 0 : requestAnimationFrame((now) => step(now)(now));
    play.textContent = playing ? "Pause" : "Play";
  });
  view.on((what, source) => {
    if (what !== "cursor" || source === animate || view.cursor === null || playing) return;
    const { start, time } = mechanisms[0].frames;
    const at = view.cursor - start;
    if (at >= 0 && at <= time[time.length - 1]) {
      share = nearest(time, at) / mechanisms[0].count + 1e-6;
      show(false);
    }
  });
  enlarge();
}

const view = new View(union("hold"));
view.limits = union("all");
drawCharts(view);
drawPaths();
drawSpectrum();
listenToSpans(view);
animate(view);
window.addEventListener("beforeprint", () => Chart.all.forEach((chart) => chart.draw(PRINTED)));
window.addEventListener("afterprint", () => Chart.all.forEach((chart) => chart.draw()));
document.documentElement.dataset.ready = "true";
