"use strict";

/** JSON of this server; `faults` in an Error where something is wrong. */
async function ask(address, options = {}) {
  const answer = await fetch(address, { ...options, headers: { Accept: "application/json", ...options.headers } });
  let content = null;
  try { content = await answer.json(); } catch { /* no JSON: the server is gone, or the token is */ }
  if (!answer.ok) throw new Error((content?.faults ?? ["The app does not answer: start it again."]).join("\n"));
  return content;
}

/** What a figure holds from now on. */
function put(plotId, data, layout = {}) {
  const holder = document.getElementById(`${plotId}-data`);
  const figure = JSON.parse(holder.textContent);
  figure.variants = [{ data, layout }];
  holder.textContent = JSON.stringify(figure);
  return draw(document.getElementById(plotId));
}

function seconds(value) {
  return value < 90 ? `${Math.round(value)} s` : `${Math.round(value / 60)} min`;
}

/* A job that runs: its progress, until it has ended; then the page shows what came of it. */
function watch() {
  const job = document.getElementById("job");
  if (!job) return;
  const bar = document.getElementById("job-progress"), said = document.getElementById("job-said");
  const list = document.getElementById("job-stages"), clock = document.getElementById("job-clock");
  const events = new EventSource(job.dataset.events);
  let told = "";
  list.replaceChildren();
  events.onmessage = async ({ data }) => {
    const state = JSON.parse(data);
    if (state.state !== "running") {
      events.close();
      await renew();
      watch(); // another may have begun meanwhile
      return;
    }
    while (list.children.length < state.stages.length) list.append(document.createElement("li"));
    state.stages.forEach((name, i) => {
      if (list.children[i].textContent !== name) list.children[i].textContent = name;
      list.children[i].toggleAttribute("aria-current", i === state.stages.length - 1);
    });
    if (state.left !== null) bar.value = state.elapsed / (state.elapsed + state.left || 1);
    else bar.removeAttribute("value");
    const stage = state.stages.at(-1) ?? "starting";
    const left = state.left === null ? "" : `, about ${seconds(state.left)} left`;
    if (stage !== told) { said.textContent = `${stage}${left}`; told = stage; }
    clock.textContent = `${seconds(state.elapsed)} so far${left}`;
    if (String(state.known) !== job.dataset.known) renew();
  };
}
watch();

/* A page that a command wrote tells its height. */
window.addEventListener("message", ({ data, source }) => {
  if (data?.acf !== "height" || !Number.isFinite(data.height)) return;
  const frame = [...document.querySelectorAll("iframe.embedded")].find((one) => one.contentWindow === source);
  if (frame) frame.style.height = `${Math.min(Math.max(data.height + 24, 200), 60000)}px`;
});

/* A slider and its number are one. */
document.addEventListener("input", ({ target }) => {
  if (target.dataset.pair) document.getElementById(target.dataset.pair).value = target.value;
  const range = target.type === "number" && document.querySelector(`[data-pair="${target.id}"]`);
  if (range && target.validity.valid && target.value) range.value = target.value;
});

/* Files that are dropped or chosen go to the server one after the other. */
const drop = document.getElementById("drop");
if (drop) {
  const said = document.getElementById("upload-said"), bar = document.getElementById("upload-progress");

  const send = (file, session) => new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch tells no progress of what it sends
    const query = new URLSearchParams({ name: file.name, ...(session ? { session } : {}) });
    request.open("PUT", `${drop.dataset.upload}?${query}`);
    request.setRequestHeader("Accept", "application/json");
    request.upload.onprogress = (event) => { bar.value = event.loaded / (event.total || 1); };
    request.onload = () => {
      let answer = {};
      try { answer = JSON.parse(request.responseText); } catch { /* told below */ }
      if (request.status === 200) resolve(answer);
      else reject(new Error((answer.faults ?? ["The app does not answer: start it again."]).join("\n")));
    };
    request.onerror = () => reject(new Error("The upload broke off: the file is too large, or the app has ended."));
    request.send(file);
  });

  const sendAll = async (files) => {
    if (!files.length) return;
    bar.hidden = false;
    try {
      let answer = {};
      for (const file of files) {
        said.textContent = `Reading ${file.name}`;
        answer = await send(file, answer.session);
      }
      location.assign(answer.next);
    } catch (error) {
      bar.hidden = true;
      said.textContent = error.message;
    }
  };

  document.getElementById("files").addEventListener("change", (event) => sendAll([...event.target.files]));
  for (const kind of ["dragenter", "dragover"]) {
    drop.addEventListener(kind, (event) => { event.preventDefault(); drop.classList.add("over"); });
  }
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    sendAll([...event.dataTransfer.files]);
  });
  for (const kind of ["dragover", "drop"]) document.addEventListener(kind, (event) => event.preventDefault());
}

/* A form is sent once. */
document.addEventListener("submit", ({ target }) => {
  if (target.matches(".ask, #sliders")) return;
  setTimeout(() => {
    for (const button of target.querySelectorAll("button[type=submit]")) button.disabled = true;
  });
});
window.addEventListener("pageshow", (event) => { if (event.persisted) location.reload(); });
