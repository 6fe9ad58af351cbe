"use strict";

/* What a user decides about the contacts of a recording, and cuts.yaml made of it. Runs before page.js draws. */
const decided = JSON.parse(document.getElementById("cuts-data").textContent);
const cutOf = new Map(decided.cuts.map((cut) => [cut.trial, { ...cut, was: cut.contact_s }]));
const MARK = 10, STILL = 3; // px: the reach of a mark, and how far a press may move and be no drag

function figureOf(name) { return JSON.parse(document.getElementById(`${name}-data`).textContent); }
function store(name, figure) { document.getElementById(`${name}-data`).textContent = JSON.stringify(figure); }

/** All cuts in one figure, from the samples that the page holds already. */
function layOver() {
  const all = figureOf("all");
  all.variants[0].data = figureOf("cut").variants.map((variant, i) => {
    const cut = cutOf.get(decided.cuts[i].trial);
    return {
      type: "scatter", mode: "lines", x: variant.data[0].x, y: variant.data[0].y, name: cut.trial,
      line: { width: 1.2, color: cut.shown ? "--recalibrated" : "--bad", dash: cut.shown ? "solid" : "dash" },
      opacity: 0.75, hovertemplate: `${cut.trial}: %{y} N at %{x} ms<extra></extra>`,
    };
  });
  store("all", all);
}
layOver();

function say(text) { document.getElementById("cuts-said").textContent = text; }

function change(trial, what) {
  const cut = cutOf.get(trial);
  Object.assign(cut, what);
  if ("shown" in what) cut.keep = what.shown;
  const box = document.querySelector(`[data-keep="${CSS.escape(trial)}"]`);
  if (box) box.checked = cut.shown;
  const time = document.querySelector(`[data-contact="${CSS.escape(trial)}"]`);
  if (time && Number(time.value) !== cut.contact_s) time.value = cut.contact_s.toFixed(6);
  const moved = cut.contact_s !== cut.was ? `, at ${cut.contact_s.toFixed(6)} s` : "";
  say(`${trial}: ${cut.shown ? "kept" : "not kept"}${moved}. Not saved yet.`);
  document.getElementById("save-cuts").disabled = false;
}

/** By dt, s; cut and band in the figures follow. */
function move(trial, dt) {
  const cut = cutOf.get(trial);
  change(trial, { contact_s: Math.max(0, cut.contact_s + dt) });
}

function cutsYaml() {
  const lines = [...cutOf.values()].map((cut) =>
    `  - {trial: ${JSON.stringify(cut.trial)}, contact_s: ${cut.contact_s.toFixed(9)}, keep: ${cut.keep}}`);
  return [`schema: ${decided.schema}`, `recording: ${JSON.stringify(decided.recording)}`, "cuts:", ...lines, ""].join("\n");
}

document.getElementById("save-cuts").addEventListener("click", () => {
  if (window.parent !== window) { // acf-jax app writes the file and imports again
    const cuts = [...cutOf.values()].map(({ trial, contact_s, keep }) => ({ trial, contact_s, keep }));
    window.parent.postMessage({ acf: "cuts", cuts }, "*");
    say("Saved; the recording is cut again.");
    return;
  }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([cutsYaml()], { type: "text/yaml" }));
  link.download = "cuts.yaml";
  link.click();
  say("cuts.yaml is saved where the browser puts downloads: import again with --review cuts.yaml.");
});

for (const box of document.querySelectorAll("[data-keep]")) {
  box.addEventListener("change", () => change(box.dataset.keep, { shown: box.checked }));
}
for (const time of document.querySelectorAll("[data-contact]")) {
  time.addEventListener("change", () => {
    if (time.validity.valid && time.value) change(time.dataset.contact, { contact_s: Number(time.value) });
  });
}

/** Figures take clicks and drags once Plotly has drawn them. */
function listen() {
  const whole = document.getElementById("whole"), all = document.getElementById("all"), one = document.getElementById("cut");
  let pressed = null; // the line that is dragged lies over its mark and keeps Plotly's own click from it
  whole.addEventListener("pointerdown", ({ clientX, clientY }) => { pressed = [clientX, clientY]; }, true);
  window.addEventListener("pointerup", ({ clientX, clientY }) => {
    const still = pressed && Math.hypot(clientX - pressed[0], clientY - pressed[1]) < STILL;
    pressed = null;
    const trial = still ? markAt(whole, clientX, clientY) : undefined;
    if (trial) change(trial, { shown: !cutOf.get(trial).shown });
  }, true);
  all.on("plotly_click", ({ points: [point] }) => {
    const choice = document.getElementById("cut-choice");
    if (choice) { choice.selectedIndex = point.curveNumber; choice.dispatchEvent(new Event("change")); }
  });
  const dragged = (plot, seconds) => (event) => {
    const key = Object.keys(event).find((name) => /^shapes\[\d+\]\.x0$/.test(name));
    if (!key) return;
    const i = Number(key.match(/\d+/)[0]);
    const name = plot.layout.shapes[i].name, from = starts(plot)[i];
    move(name, seconds * (event[key] - from));
    plot.dataset.starts = JSON.stringify(plot.layout.shapes.map((shape) => shape.x0));
    Plotly.relayout(plot, { [`shapes[${i}].y0`]: 0, [`shapes[${i}].y1`]: 1 }); // it moves sideways alone
  };
  whole.on("plotly_relayout", dragged(whole, 1));
  one.on("plotly_relayout", dragged(one, 1e-3));
  document.getElementById("cut-choice")?.addEventListener("change", () => { delete one.dataset.starts; });
}

/** The cut whose mark is at a place of the page, px, if there is one. */
function markAt(plot, x, y) {
  const trials = plot.data.filter(({ mode }) => mode === "markers").flatMap(({ customdata }) => [...customdata]);
  const away = (mark) => {
    const { left, right, top, bottom, width } = mark.getBoundingClientRect();
    return width ? Math.hypot((left + right) / 2 - x, (top + bottom) / 2 - y) : Infinity;
  };
  const distances = [...plot.querySelectorAll(".scatterlayer .points path")].map(away);
  const least = Math.min(...distances);
  return least < MARK ? trials[distances.indexOf(least)] : undefined;
}

/** Where the shapes of a figure began before the drag that has just ended. */
function starts(plot) {
  if (plot.dataset.starts) return JSON.parse(plot.dataset.starts);
  const figure = figureOf(plot.id), choice = document.getElementById(`${plot.id}-choice`);
  return figure.variants[choice ? choice.selectedIndex : 0].layout.shapes.map((shape) => shape.x0);
}

const whenDrawn = new MutationObserver(() => {
  if (document.documentElement.dataset.drawn) { whenDrawn.disconnect(); listen(); }
});
whenDrawn.observe(document.documentElement, { attributes: true, attributeFilter: ["data-drawn"] });
