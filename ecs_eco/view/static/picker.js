// Starts a new world with a chosen seed, in the "World" tab.

import { $, h } from "./dom.js";

/** @typedef {import("./protocol.js").Hello} Hello */

/** Whether the server now runs a different world from the one on this page. @param {Hello} here @param {Hello} there */
export const another = (here, there) => identity(here) !== identity(there);

/** The properties that distinguish a world from others at the same address. @param {Hello} hello */
export const identity = ({ world, seed, size, species, begins }) => JSON.stringify([world, seed, begins?.begun ?? 0, size, species]);

/** Shows the new world, and drops the view that a link requested for the previous world. */
export function anew() {
  history.replaceState(history.state, "", location.pathname);
  location.reload();
}

/**
 * Adds a choice of worlds to the "World" tab, or the reason why there is none.
 * @param {Hello} hello
 * @param {import("./connection.js").Connection} connection
 */
export function picker({ begins, seed }, connection) {
  if (!begins) return;
  const title = h("legend", { text: "Start a new world" });
  if (!begins.worlds) return void $("world").append(h("fieldset", { class: "begin" }, title, h("p", { class: "about", text: begins.why ?? "" })));
  const worlds = h("select", { class: "input", "aria-label": "World to start" }, ...begins.worlds.map(({ name, title }) => h("option", { value: name, text: title || name })));
  worlds.value = begins.world ?? "";
  const number = h("input", { class: "input", type: "number", min: 0, max: Number.MAX_SAFE_INTEGER, step: 1, value: seed ?? "", placeholder: "from the world file", "aria-label": "Seed" });
  const button = h("button", { class: "button primary", type: "button", text: "Start", onclick: () => {
    if (number.reportValidity()) connection.send({ kind: "begin", world: worlds.value, seed: number.value === "" ? null : Number(number.value) });
  } });
  worlds.addEventListener("change", () => (number.value = worlds.value === begins.world ? String(seed ?? "") : ""));
  $("world").append(h("fieldset", { class: "begin" }, title, h("div", { class: "form" }, h("label", { text: "world" }), worlds, h("label", { text: "seed" }), number,
    h("p", { class: "about", text: "This replaces the current world on all pages, at the same address." }), h("div", { class: "row full" }, button))));
}
