// The user's own panels: a number, or a picture. Pictures are shown as images, so nothing in them becomes part of the page.

import { h, number } from "./dom.js";
import { addPanel, displayed } from "./tabs.js";

export class OwnPanels {
  /** @param {string[]} names @param {(shown: number[]) => void} ask */
  constructor(names, ask) {
    this.names = names;
    this.ask = ask;
    this.roots = names.map((name, i) => addPanel(`own${i}`, name));
    this.shown = ""; // the panels that the server makes
    for (const root of this.roots) root.append(h("p", { class: "empty", text: "Waiting for the world …" }));
  }

  /** Requests the panels that are displayed. @param {boolean} [again] after a reconnection */
  look(again = false) {
    const shown = this.names.flatMap((_, i) => (displayed(`own${i}`) ? [i] : []));
    if (!again && JSON.stringify(shown) === this.shown) return;
    this.shown = JSON.stringify(shown);
    if (this.names.length) this.ask(shown);
  }

  /** @param {import("./protocol.js").PanelMessage} message */
  show({ name, tick, number: value, svg, error }) {
    const root = this.roots[this.names.indexOf(name)];
    if (!root) return;
    let content = root.querySelector("img") ?? h("img", { alt: name });
    if (svg !== undefined) {
      URL.revokeObjectURL(content.src);
      content.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
    }
    root.replaceChildren(h("p", { class: "unit", text: `tick ${number(tick)}` }), svg !== undefined ? content : error !== undefined
      ? h("p", { class: "problem", text: `${name}: ${error}` }) : h("p", { class: "figure", text: number(value, 4) }));
  }
}
