"use strict";

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
const isNarrow = matchMedia("(max-width: 700px)");
const isTouched = matchMedia("(pointer: coarse)");

/** The value with every colour name of the style sheet replaced by the colour it has now. */
function coloured(value, style) {
  if (typeof value === "string") return value.startsWith("--") ? style.getPropertyValue(value).trim() : value;
  if (Array.isArray(value)) return value.map((item) => coloured(item, style));
  if (value && typeof value === "object") {
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, coloured(item, style)]));
  }
  return value;
}

function layoutOf(own) {
  const axis = { gridcolor: "--line", zerolinecolor: "--line", linecolor: "--muted", automargin: true };
  const layout = {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", autosize: true, hovermode: "closest",
    font: { family: getComputedStyle(document.body).fontFamily, size: isNarrow.matches ? 12 : 13, color: "--ink" },
    margin: { l: isNarrow.matches ? 44 : 58, r: 10, t: 10, b: 44 },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    hoverlabel: { bgcolor: "--panel", bordercolor: "--muted", font: { color: "--ink" } },
    dragmode: isTouched.matches ? false : "zoom",
    ...own, xaxis: own.xaxis ?? {}, yaxis: own.yaxis ?? {},
  };
  for (const key of Object.keys(layout).filter((name) => /^[xy]axis\d*$/.test(name))) {
    layout[key] = { ...axis, ...layout[key] };
    if (isTouched.matches) layout[key].fixedrange = true; // a finger scrolls the page
  }
  return layout;
}

function draw(plot) {
  const figure = JSON.parse(document.getElementById(`${plot.id}-data`).textContent);
  const choice = document.getElementById(`${plot.id}-choice`);
  const shown = figure.variants[choice ? choice.selectedIndex : Number(plot.dataset.first)];
  const style = getComputedStyle(document.documentElement);
  const isMoved = (shown.layout?.shapes ?? []).some((shape) => shape.editable);
  const config = { edits: { shapePosition: isMoved }, responsive: true, displaylogo: false, displayModeBar: isTouched.matches ? false : "hover" };
  const layout = layoutOf({ ...figure.layout, ...shown.layout });
  return Plotly.react(plot, coloured(switched(plot, shown.data), style), coloured(layout, style), config);
}

/** The traces of a figure with those shown that its switches ask for. */
function switched(plot, traces) {
  const boxes = [...document.querySelectorAll(`[data-switch="${plot.id}"]`)];
  if (!boxes.length) return traces;
  const on = boxes.filter((box) => box.checked).map((box) => box.dataset.cause);
  const isShown = ({ causes, cause }) => (causes ? causes.join() === on.join() : on.includes(cause));
  return traces.map((trace) => (trace.meta ? { ...trace, visible: isShown(trace.meta) } : trace));
}

const drawAll = () => Promise.all([...document.querySelectorAll(".plot")].map(draw));
for (const choice of document.querySelectorAll("select[data-plot]")) {
  choice.addEventListener("change", () => draw(document.getElementById(choice.dataset.plot)));
}

for (const box of document.querySelectorAll("[data-switch]")) {
  box.addEventListener("change", () => draw(document.getElementById(box.dataset.switch)));
}

/** Numbers by value, texts by the alphabet, what is not there last. */
function compare(a, b, sign) {
  if (a === undefined || b === undefined) return (a === undefined) - (b === undefined);
  return sign * (isNaN(a) || isNaN(b) ? a.localeCompare(b) : a - b);
}
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head, column) => head.firstChild.addEventListener("click", () => {
    const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
    for (const other of heads) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
    const key = (row) => row.cells[column].dataset.key;
    const body = table.tBodies[0];
    body.append(...[...body.rows].sort((a, b) => compare(key(a), key(b), sign)));
  }));
}
prefersDark.addEventListener("change", drawAll);
isNarrow.addEventListener("change", drawAll);
drawAll().then(() => {
  document.getElementById("made-of-bars")?.on("plotly_click", ({ points: [point] }) => {
    const box = document.getElementById(`cause-${point.id}`);
    if (!box) return; // what no cause of the library explains
    box.checked = !box.checked;
    box.dispatchEvent(new Event("change"));
    box.scrollIntoView({ block: "center" });
  });
  document.documentElement.dataset.drawn = "true";
});

/** In a frame of `acf-jax app` a page has no frame of its own to scroll: it tells its height. */
if (window.parent !== window) {
  document.documentElement.classList.add("embedded");
  const tell = () => window.parent.postMessage({ acf: "height", height: document.body.offsetHeight }, "*");
  new ResizeObserver(tell).observe(document.body);
}
