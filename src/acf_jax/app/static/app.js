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

  const send = (file, where) => new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch tells no progress of what it sends
    const query = new URLSearchParams({ name: file.name, ...where });
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

  /** `found`: files, or the promise of them. `folder`: the name of the folder that holds them, where one was given. */
  const sendAll = async (found, folder) => {
    bar.hidden = false;
    try {
      const files = await found;
      if (!files.length) throw new Error(`${folder}: holds no files; give the folder that holds the recording itself.`);
      let answer = {};
      for (const file of files) {
        said.textContent = `Reading ${file.name}`;
        answer = await send(file, answer.session ? { session: answer.session } : folder ? { folder } : {});
      }
      location.assign(answer.next);
    } catch (error) {
      bar.hidden = true;
      said.textContent = error.message;
    }
  };

  const isShown = (file) => !file.name.startsWith(".");
  document.getElementById("files").addEventListener("change", ({ target }) => { if (target.files.length) sendAll([...target.files]); });
  document.getElementById("folder").addEventListener("change", ({ target }) => {
    const paths = [...target.files].map((file) => [file, file.webkitRelativePath.split("/")]);
    if (paths.length) sendAll(paths.filter(([file, parts]) => parts.length === 2 && isShown(file)).map(([file]) => file), paths[0][1][0]);
  });

  /** The files that lie in a folder itself. */
  const filesIn = async (folder) => {
    const reader = folder.createReader(), found = [];
    for (let some; (some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject))).length;) found.push(...some);
    return Promise.all(found.filter((entry) => entry.isFile && isShown(entry))
      .map((entry) => new Promise((resolve, reject) => entry.file(resolve, reject))));
  };

  for (const kind of ["dragenter", "dragover"]) {
    drop.addEventListener(kind, (event) => { event.preventDefault(); drop.classList.add("over"); });
  }
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    const files = [...event.dataTransfer.files]; // both now: behind the event they are gone
    const folder = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).find((entry) => entry?.isDirectory);
    if (files.length > 1 && folder) said.textContent = "Drop one folder, or the files of one recording.";
    else if (folder) sendAll(filesIn(folder), folder.name);
    else if (files.length) sendAll(files);
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
