// Keyboard control, and a help dialog that lists the keys.

import { $, h } from "./dom.js";
import { HINTS } from "./world.js";

/**
 * @typedef {object} Key
 * @property {string[]} keys as in event.key
 * @property {string} shown
 * @property {string} about
 * @property {(event: KeyboardEvent) => void} does
 */

/**
 * Listens for keys outside input fields.
 * @param {Key[]} keys
 */
export function listen(keys) {
  document.addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const typing = target.closest("input:not([type=range]), select, textarea") !== null;
    const arrows = event.key.startsWith("Arrow") || event.key === "Home";
    if (target.matches("input[type=range]") && (arrows || event.key === "End" || event.key.startsWith("Page"))) return; // the element handles these keys
    if (typing && event.key !== "Escape") return;
    if (arrows && target.id !== "canvas" && target !== document.body) return;
    if (event.key === " " && target.closest("button, [role=tab]")) return;
    const found = keys.find((key) => key.keys.includes(event.key));
    if (!found) return;
    event.preventDefault();
    found.does(event);
  });
}

/** @param {Key[]} keys */
export function help(keys) {
  const pointer = [
    ["click", "select an organism"], ["drag", "move the ground"], ["right drag", "turn around"], ["wheel, pinch", "zoom in or out"],
    ["wheel on the timeline", "a shorter or longer period; with shift, move it"], ["shift drag there", "select a period"],
  ];
  $("help").replaceChildren(
    h("h2", { text: "Hints" }), ...Object.values(HINTS).map((text) => h("p", { text })),
    h("h2", { id: "helpTitle", text: "Keys" }),
    h("dl", { class: "keys" }, ...keys.map(({ shown, about }) => h("div", {}, h("dt", {}, ...shown.split(" ").flatMap((key, i) => [i ? " " : "", h("kbd", { text: key })])), h("dd", { text: about })))),
    h("h2", { text: "Pointer", style: "margin-top:18px" }),
    h("dl", { class: "keys" }, ...pointer.map(([what, about]) => h("div", {}, h("dt", { text: what }), h("dd", { text: about })))),
    h("form", { method: "dialog" }, h("button", { class: "button", text: "Close" })),
  );
}
