"use strict";
// Puts the charts of a joint in their places: the full model broad and light, the joint over it.

/** Width [px] of half a page, for which a printed chart is drawn. */
const PRINTED = 340;
const COLOURS = ["var(--simulated)", "var(--error)"];

const data = unpacked(JSON.parse(document.getElementById("data").textContent));

data.figures.forEach((figure, index) => {
  const place = document.querySelector(`#figure-${index} .chart`);
  let joints = 0;
  const curves = figure.curves.map(({ name, x, y, theory }) => {
    const colour = theory ? "var(--theory)" : COLOURS[joints++ % COLOURS.length];
    return { name, x, y, offset: 0, colour, width: theory ? 4 : 1.3 };
  });
  const view = new View(figure.span);
  view.limits = figure.span;
  new Chart(place, view, [{ label: figure.y_label, height: 2, zero: true, curves }], { xLabel: figure.x_label });
});
window.addEventListener("beforeprint", () => Chart.all.forEach((chart) => chart.draw(PRINTED)));
window.addEventListener("afterprint", () => Chart.all.forEach((chart) => chart.draw()));
document.documentElement.dataset.ready = "true";
