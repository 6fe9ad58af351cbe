"use strict";

/* Step 2: the page of the import, in its frame, asks for its cuts to be saved. */
window.addEventListener("message", async ({ data, source }) => {
  const cuts = document.getElementById("cuts");
  if (!cuts || data?.acf !== "cuts" || source !== cuts.querySelector("iframe").contentWindow) return;
  try {
    const body = JSON.stringify({ cuts: data.cuts, version: cuts.dataset.version });
    const answer = await ask(cuts.dataset.save, { method: "POST", body, headers: { "Content-Type": "application/json" } });
    location.assign(answer.next);
  } catch (error) {
    const told = document.createElement("div");
    told.className = "box faults";
    told.role = "alert";
    told.textContent = error.message;
    cuts.prepend(told);
    told.scrollIntoView();
  }
});
