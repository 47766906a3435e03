// The panel tabs.

import { $ } from "./dom.js";

/** @typedef {"charts" | "world" | "why" | "organism" | "all" | "act"} PanelName */
export const PANELS = /** @type {const} */ (["charts", "world", "why", "organism", "all", "act"]);

/** Shows one panel. @param {PanelName} name */
export function openPanel(name) {
  for (const other of PANELS) {
    $(other).hidden = other !== name;
    $(`tab-${other}`).setAttribute("aria-selected", String(other === name));
    $(`tab-${other}`).tabIndex = other === name ? 0 : -1;
  }
}

/** The displayed panel. */
export const opened = () => PANELS.find((name) => !$(name).hidden) ?? "charts";

/** Handles clicks and arrow keys. @param {(name: PanelName) => void} open */
export function listenTabs(open) {
  for (const name of PANELS) $(`tab-${name}`).addEventListener("click", () => open(name));
  $("side").querySelector("[role=tablist]").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const tabs = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("[role=tab]:not([hidden])")]);
    const at = tabs.findIndex((tab) => tab.getAttribute("aria-selected") === "true");
    const tab = tabs[(at + (event.key === "ArrowRight" ? 1 : tabs.length - 1)) % tabs.length];
    tab.click();
    tab.focus();
  });
}
