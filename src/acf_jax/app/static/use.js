"use strict";

/* Step 6: the peak follows the sliders; one question at a time is on its way, and the last position is asked again. */
let isAsking = false, isStale = false;

function show(found, where) {
  const x = found.v_e, line = { type: "scatter", mode: "lines", hovertemplate: "%{x} m/s: %{y} N<extra></extra>" };
  const at = found.at, tried = found.force.map((y, i) => (found.beyond[i] ? null : y));
  const drawn = put("peak", [
    { ...line, x, y: found.upper, line: { width: 0 }, showlegend: false, hoverinfo: "skip" },
    { ...line, x, y: found.lower, line: { width: 0 }, fill: "tonexty", fillcolor: "--band", name: "band", hoverinfo: "skip" },
    { ...line, x, y: found.force, name: "extrapolated", line: { color: "--corrected", width: 2.5, dash: "dot" } },
    { ...line, x, y: tried, name: "expected", line: { color: "--corrected", width: 2.5 } },
    { ...line, x: [x[0], x.at(-1)], y: [where.limit, where.limit], name: "limit", line: { color: "--bad", dash: "dash", width: 2 } },
    { type: "scatter", mode: "markers", x: [where.v_e], y: [at.force], name: "here", marker: { size: 11, color: "--measured" } },
  ]);
  const force = at.force === null ? `No answer here: ${found.none}.` : `${at.force.toFixed(1)} ± ${at.std.toPrecision(2)} N`;
  document.getElementById("peak-said").replaceChildren(force,
    Object.assign(document.createElement("span"), { className: "muted", textContent: found.allowed }));
  document.getElementById("peak-notes").replaceChildren(
    ...found.notes.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  return drawn;
}

async function update() {
  const sliders = document.getElementById("sliders");
  if (!sliders) return;
  if (isAsking) { isStale = true; return; }
  isAsking = true;
  const where = Object.fromEntries([...new FormData(sliders)].map(([name, value]) => [name, Number(value)]));
  try {
    const begun = performance.now();
    await show(await ask(`${sliders.dataset.curve}?${new URLSearchParams(where)}`), where);
    sliders.dataset.took = (performance.now() - begun).toFixed(1);
    sliders.dataset.drawn = Number(sliders.dataset.drawn ?? 0) + 1;
  } catch (error) {
    document.getElementById("peak-said").textContent = error.message;
    document.getElementById("peak-notes").replaceChildren(); // of the answer before
    put("peak", []);
  }
  isAsking = false;
  if (isStale) { isStale = false; update(); }
}
document.addEventListener("input", ({ target }) => { if (target.closest("#sliders")) update(); });
document.addEventListener("renewed", update);
if (document.getElementById("peak-said")) document.getElementById("peak-said").textContent = "Getting the model ready";
update();

document.addEventListener("submit", async (event) => {
  const form = event.target;
  if (form.id === "sliders") event.preventDefault();
  if (!form.matches(".ask")) return;
  event.preventDefault();
  const out = document.getElementById(form.id.replace("ask", "answer")), button = form.querySelector("button");
  button.disabled = true;
  out.textContent = "Asking the model";
  try {
    const answer = await ask(form.action, { method: "POST", body: new URLSearchParams(new FormData(form)) });
    out.innerHTML = answer.html; // escaped by the server
  } catch (error) {
    out.textContent = error.message;
  }
  button.disabled = false;
});
