// The "All" tab: the organisms of a species as a table, sorted by a column, filtered by comparisons.

import { $, h, number } from "./dom.js";
import { displayed } from "./tabs.js";

/** @typedef {import("./protocol.js").TableMessage} TableMessage */

const PACE = 1000; // [ms] between requests while time passes

export class All {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {{ask: (request: {species: string, sort: string, down: boolean, where: string, from: number}) => void, select: (uid: number) => void}} calls
   */
  constructor(hello, calls) {
    this.calls = calls;
    this.root = $("all");
    const names = hello.species.map(({ name }) => name);
    const first = hello.species.find(({ moves }) => moves) ?? hello.species[0];
    this.asked = { species: first?.name ?? "", sort: "uid", down: false, where: "", from: 0 };
    /** @type {number | null} */
    this.selected = null;
    this.tick = -1;
    this.at = 0;
    const choice = h("select", { class: "input", style: "width:auto", "aria-label": "Species in the table", onchange: () => this.again({ species: choice.value, from: 0, sort: "uid", down: false }) },
      ...names.map((name) => h("option", { value: name, text: name, selected: name === this.asked.species })));
    const where = h("input", { class: "input", type: "search", placeholder: "energy < 0.3, age > 100", "aria-label": "Filter: show only organisms that match", spellcheck: "false", onchange: () => this.again({ where: where.value, from: 0 }) });
    this.where = where;
    this.note = h("p", { class: "about", role: "status" });
    this.head = h("tr");
    this.body = h("tbody");
    this.back = h("button", { class: "button", type: "button", text: "‹ previous", onclick: () => this.again({ from: Math.max(0, this.asked.from - 100) }) });
    this.on = h("button", { class: "button", type: "button", text: "next ›", onclick: () => this.again({ from: this.asked.from + 100 }) });
    this.root.replaceChildren(h("div", { class: "row table-tools" }, choice, where), this.note,
      h("div", { class: "table-box", tabindex: "0", role: "region", "aria-label": "All organisms" }, h("table", { class: "all" }, h("thead", {}, this.head), this.body)),
      h("div", { class: "row" }, this.back, this.on));
  }

  /** Requests the table again, with some parameters changed. @param {Partial<All["asked"]>} [change] */
  again(change = {}) {
    Object.assign(this.asked, change);
    this.at = performance.now();
    if (this.asked.species) this.calls.ask(this.asked);
  }

  /** Called at each tick: refreshes the table at intervals while it is shown. @param {number} tick */
  time(tick) {
    if (!displayed("all") || tick === this.tick || performance.now() - this.at < PACE) return;
    this.tick = tick;
    this.again();
  }

  /** @param {string} why */
  refuse(why) {
    this.note.textContent = why;
    this.where.setAttribute("aria-invalid", "true");
  }

  /** @param {TableMessage} table */
  show(table) {
    if (table.species !== this.asked.species) return;
    this.where.removeAttribute("aria-invalid");
    const names = Object.keys(table.columns);
    const count = table.columns.uid?.length ?? 0;
    const rows = count ? `, rows ${number(table.from + 1)} to ${number(table.from + count)}` : "";
    this.note.textContent = `${number(table.found)} of ${number(table.n)} ${table.species}${rows}`;
    this.head.replaceChildren(...names.map((name) => {
      const sorted = name === table.sort;
      const title = `${name.replace("gene:", "gene ")}${sorted ? (table.down ? " ↓" : " ↑") : ""}`;
      return h("th", { scope: "col", "aria-sort": sorted ? (table.down ? "descending" : "ascending") : null }, h("button", { class: "plain", type: "button", text: title, "data-column": name,
        onclick: () => this.again({ sort: name, down: sorted ? !table.down : name !== "uid", from: 0 }) }));
    }));
    this.body.replaceChildren(...Array.from({ length: count }, (_, row) => {
      const uid = Number(table.columns.uid[row]);
      const cells = names.slice(1).map((name) => h("td", { text: name === "family" ? `#${table.columns[name][row]}` : number(table.columns[name][row]) }));
      return h("tr", { class: uid === this.selected ? "chosen" : null }, h("td", {}, h("button", { class: "uid", type: "button", text: `#${uid}`, onclick: () => this.calls.select(uid) })), ...cells);
    }));
    this.back.disabled = table.from === 0;
    this.on.disabled = table.from + count >= table.found;
  }
}
