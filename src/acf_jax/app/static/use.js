"use strict";

/* Step 6: the peak follows the sliders; one question at a time is on its way, and the last position is asked again. */
const sliders = document.getElementById("sliders");
if (sliders) {
  const said = document.getElementById("peak-said"), notes = document.getElementById("peak-notes");
  let isAsking = false, isStale = false;

  const show = (found, where) => {
    const x = found.v_e, line = { type: "scatter", mode: "lines", hovertemplate: "%{x} m/s: %{y} N<extra></extra>" };
    const at = found.at, tried = found.force.map((y, i) => (found.beyond[i] ? null : y));
    put("peak", [
      { ...line, x, y: found.upper, line: { width: 0 }, showlegend: false, hoverinfo: "skip" },
      { ...line, x, y: found.lower, line: { width: 0 }, fill: "tonexty", fillcolor: "--band", name: "95 %", hoverinfo: "skip" },
      { ...line, x, y: found.force, name: "expected, beyond the trials", line: { color: "--corrected", width: 2.5, dash: "dot" } },
      { ...line, x, y: tried, name: "expected, between the trials", line: { color: "--corrected", width: 2.5 } },
      { ...line, x: [x[0], x.at(-1)], y: [where.limit, where.limit], name: "limit", line: { color: "--bad", dash: "dash", width: 2 } },
      { type: "scatter", mode: "markers", x: [where.v_e], y: [at.force], name: "here", marker: { size: 11, color: "--measured" } },
    ]);
    const force = at.force === null ? `No answer here: ${found.none}.` : `${at.force.toFixed(1)} ± ${at.std.toPrecision(2)} N`;
    said.replaceChildren(force, document.createElement("br"),
      Object.assign(document.createElement("span"), { className: "muted", textContent: found.allowed }));
    notes.replaceChildren(...found.notes.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  };

  const update = async () => {
    if (isAsking) { isStale = true; return; }
    isAsking = true;
    const where = Object.fromEntries([...new FormData(sliders)].map(([name, value]) => [name, Number(value)]));
    try {
      const begun = performance.now();
      show(await ask(`${sliders.dataset.curve}?${new URLSearchParams(where)}`), where);
      sliders.dataset.took = (performance.now() - begun).toFixed(1);
    } catch (error) {
      said.textContent = error.message;
      notes.replaceChildren(); // of the answer before
      put("peak", []);
    }
    isAsking = false;
    if (isStale) { isStale = false; update(); }
  };
  sliders.addEventListener("input", update);
  sliders.addEventListener("submit", (event) => event.preventDefault());
  said.textContent = "Getting the model ready";
  update();
}

for (const form of document.querySelectorAll("form.ask")) {
  form.addEventListener("submit", async (event) => {
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
}
