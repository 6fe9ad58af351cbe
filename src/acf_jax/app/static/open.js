"use strict";

/* Step 1: a click takes a signal for force, speed or pretension; ‘look’ draws it in the chosen unit and sign. */
const factors = {
  N: 1, kN: 1e3, mN: 1e-3, kgf: 9.80665, gf: 9.80665e-3, lbf: 4.4482216152605,
  "m/s": 1, "mm/s": 1e-3, "cm/s": 1e-2, "m/min": 1 / 60, "in/s": 0.0254, m: 1, mm: 1e-3, cm: 1e-2, "µm": 1e-6, in: 0.0254,
};
const si = { force: "N", speed: "m/s", pretension: "N" };

function scaleOf(role) {
  const unit = document.getElementById(`${role}-unit`).value;
  const size = factors[unit] ?? Number(unit);
  return document.getElementById(`${role}-turned`).checked ? -size : size;
}

function unitOf(role) {
  return role === "speed" && document.getElementById("speed-kind").value === "position" ? "m" : si[role];
}

let looks = 0; // the last that was asked for is drawn, whichever answer comes last

async function look(value, which, role) {
  const mine = ++looks;
  const said = document.getElementById("preview-said");
  const [name, field] = JSON.parse(value);
  const label = field ? `${name}:${field}` : name;
  said.textContent = `Reading ${label}`;
  try {
    const box = document.getElementById("preview-box"), query = new URLSearchParams({ which, name, field: field ?? "" });
    const found = await ask(`${box.dataset.preview}?${query}`);
    if (mine !== looks) return;
    const scale = role ? scaleOf(role) : 1, unit = role ? ` ${unitOf(role)}` : "";
    const short = (number) => Number((scale * number).toPrecision(4));
    const ends = [short(found.least), short(found.largest)].sort((a, b) => a - b);
    const rate = found.seconds > 0 ? `, ${Math.round((found.count - 1) / found.seconds).toLocaleString("en")} Hz` : "";
    said.textContent = `${label}: ${found.count.toLocaleString("en")} samples in ${found.seconds.toFixed(1)} s${rate}; ` +
      `${ends[0]} to ${ends[1]}${unit}, at rest about ${short(found.median)}${unit}.`;
    box.dataset.drawn = "true";
    await put("preview", [{
      type: "scatter", mode: "lines", x: found.time, y: found.value.map((y) => (y === null ? null : scale * y)),
      name: label, line: { color: "--recalibrated", width: 1 }, hovertemplate: "%{x} s: %{y}<extra></extra>",
    }]);
    if (mine === looks) box.scrollIntoView({ block: "nearest" }); // a long list pushes it out of sight
  } catch (error) {
    said.textContent = error.message;
  }
}

/** The recording that holds a signal, as the tree has it. */
function whereIs(value) {
  return [...document.querySelectorAll("[data-look]")].find((one) => one.dataset.look === value)?.dataset.which ?? "recording";
}

/** The signal that is chosen for a role, drawn. */
function lookAt(role) {
  const value = document.getElementById(role).value;
  if (value && value !== "number") look(value, whereIs(value), role);
  else document.getElementById("preview-said").textContent = "Choose a signal first.";
}

document.addEventListener("click", ({ target }) => {
  const { look: name, which, preview: role, take, signal } = target.closest("button")?.dataset ?? {};
  if (name) look(name, which, "");
  if (role) lookAt(role);
  if (take) {
    const choice = document.getElementById(take);
    choice.value = signal;
    choice.focus();
    look(signal, whereIs(signal), take);
  }
});
document.addEventListener("change", ({ target }) => {
  const role = Object.keys(si).find((one) => [`${one}-unit`, `${one}-turned`].includes(target.id));
  if (role && !["", "number"].includes(document.getElementById(role).value)) lookAt(role);
  if (target.id !== "speed-kind") return;
  // the units of a speed are those of a velocity or of a position
  const units = target.value === "position" ? ["m", "mm", "cm", "µm", "in"] : ["m/s", "mm/s", "cm/s", "m/min", "in/s"];
  document.getElementById("speed-unit").replaceChildren(...units.map((unit) => new Option(unit, unit)));
});
document.addEventListener("input", ({ target }) => {
  const role = Object.keys(si).find((one) => target.id === `${one}-number`);
  if (role && target.value) document.getElementById(role).value = "number";
});
