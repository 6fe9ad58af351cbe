"use strict";

/* Step 4: how many trials the sliders mean. */
function count() {
  const told = document.getElementById("plan-count");
  if (!told) return;
  const of = (name) => Number(document.getElementById(name).value);
  const speeds = of("slowest") === of("fastest") ? 1 : of("speeds"), levels = of("least") === of("most") ? 1 : of("pretensions");
  told.textContent = `${speeds * levels * of("repeats")} trials at ${speeds * levels} conditions.`;
}
document.addEventListener("input", count);
document.addEventListener("renewed", count);
count();
