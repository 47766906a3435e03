// Classroom mode: large text and few controls, for a screen watched by a group.

import { $, h } from "./dom.js";

const KEPT = "ecs-eco-classroom"; // in localStorage: whether the mode is on

/** Adds the button and restores the previous choice. */
export function classroom() {
  const button = h("button", { id: "classroom", class: "icon", type: "button", text: "Aa", title: "Classroom mode: large text, few controls", "aria-label": "Classroom mode: large text, few controls", onclick: () => turn(!document.documentElement.hasAttribute("data-classroom")) });
  const turn = (/** @type {boolean} */ on) => {
    document.documentElement.toggleAttribute("data-classroom", on);
    button.setAttribute("aria-pressed", String(on));
    if (on && ["tab-all", "tab-act"].some((id) => $(id).getAttribute("aria-selected") === "true")) $("tab-charts").click();
    try {
      localStorage.setItem(KEPT, on ? "on" : "off");
    } catch {} // storage may be unavailable in private windows
    window.dispatchEvent(new Event("resize"));
  };
  $("theme").before(button);
  try {
    turn(localStorage.getItem(KEPT) === "on");
  } catch {
    turn(false);
  }
}
