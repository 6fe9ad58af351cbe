"use strict";

/* A page is renewed in place: what the server now shows differently is changed, and all else stays as it is, with focus,
   scroll position, what is open, and what was typed. This script comes before those that draw into the page. */
const main = document.getElementById("main");
const onPage = new WeakMap(); // node as the server sent it: the same on the page
let sent = main.cloneNode(true);
pair(sent, main);

function pair(node, there) {
  onPage.set(node, there);
  node.childNodes.forEach((child, i) => pair(child, there.childNodes[i]));
}

function keep(before, after) {
  onPage.set(after, onPage.get(before));
  after.childNodes.forEach((child, i) => keep(before.childNodes[i], child));
}

const nameOf = (node) => [node.nodeName, node.id, node.getAttribute?.("aria-labelledby"), node.getAttribute?.("action")].join();

function change(before, after) {
  if (before.isEqualNode(after)) { keep(before, after); return; }
  const there = onPage.get(before);
  onPage.set(after, there);
  if (!(after instanceof Element)) { there.data = after.data; return; }
  for (const { name } of [...before.attributes, ...after.attributes]) {
    const value = after.getAttribute(name);
    if (value === before.getAttribute(name)) continue;
    if (value === null) there.removeAttribute(name);
    else there.setAttribute(name, value);
  }
  let rest = [...before.childNodes], last = null;
  for (const child of after.childNodes) {
    let i = child instanceof Element ? rest.findIndex((one) => one.isEqualNode(child)) : 0;
    if (i < 0) i = rest.findIndex((one) => nameOf(one) === nameOf(child));
    if (rest[i]?.nodeName === child.nodeName) {
      for (const gone of rest.slice(0, i)) onPage.get(gone).remove();
      change(rest[i], child);
      rest = rest.slice(i + 1);
      last = onPage.get(child);
    } else {
      const fresh = document.importNode(child, true);
      pair(child, fresh);
      there.insertBefore(fresh, last ? last.nextSibling : there.firstChild);
      last = fresh;
    }
  }
  for (const gone of rest) onPage.get(gone).remove();
}

const dataOf = (plot) => document.getElementById(`${plot.id}-data`)?.textContent;
let isRenewing = false, isOld = false;

async function renew() {
  if (isRenewing) { isOld = true; return; }
  isRenewing = true;
  try {
    const answer = await fetch(location.href);
    const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
    const after = fresh.getElementById("main");
    if (after) {
      const focused = document.activeElement, drawn = new Map([...main.querySelectorAll(".plot")].map((one) => [one, dataOf(one)]));
      change(sent, after);
      sent = after;
      document.title = fresh.title;
      if (!focused.isConnected) { // what had the focus is no longer there
        const title = main.querySelector("h1");
        title.tabIndex = -1;
        title.focus({ preventScroll: true });
      }
      for (const plot of main.querySelectorAll(".plot")) if (drawn.get(plot) !== dataOf(plot)) draw(plot);
      document.dispatchEvent(new Event("renewed"));
    }
  } catch { /* the app has ended: the page stays as it is */ }
  isRenewing = false;
  if (isOld) { isOld = false; await renew(); }
}
