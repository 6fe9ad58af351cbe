"use strict";

/* Step 4: how many trials the sliders mean. */
const plan = document.getElementById("plan");
function count() {
  const of = (name) => Number(document.getElementById(name).value);
  const speeds = of("slowest") === of("fastest") ? 1 : of("speeds"), levels = of("least") === of("most") ? 1 : of("pretensions");
  document.getElementById("plan-count").textContent = `${speeds * levels * of("repeats")} trials at ${speeds * levels} conditions.`;
}
plan.addEventListener("input", count);
count();
