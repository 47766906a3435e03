// The "Why" tab: a list of events, and the diagnosis of `ecs-eco why` for the run so far.

import { $, announce, h, number } from "./dom.js";
import { displayed } from "./tabs.js";

/** @typedef {import("./protocol.js").Entry} Entry */

const FEW = 60; // maximum number of entries in the list
const NEAR = 60; // [ticks] a larger advance means that a replay was moved, not played
const SIGNS = { extinct: "✝", crash: "▼", boom: "▲", birth: "✶", return: "↺", act: "◆", sweep: "↗" };

export class Story {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {{jump: (entry: Entry) => void, without: (entry: Entry) => void, tell: (entry: Entry) => void, ask: () => void, play: () => void, colourOf: (name: string) => string}} calls
   */
  constructor(hello, calls) {
    this.hello = hello;
    this.calls = calls;
    this.tick = hello.tick;
    /** @type {Entry[]} */
    this.entries = [];
    /** @type {Entry[]} */
    this.acts = [];
    this.asked = false;
    this.begun = this.marked = false; // whether earlier entries and marks have arrived
    this.list = h("ol", { class: "story", "aria-label": "What happened" });
    this.account = h("div", { class: "account" });
    this.again = h("button", { class: "plain", type: "button", text: "update", onclick: () => this.explain() });
    this.player = h("button", { id: "playStory", class: "toggle", type: "button", "aria-pressed": "false", onclick: () => calls.play(),
      text: hello.mode === "live" ? "Follow the story" : "▶ Play the story", title: "The camera flies to each boom, crash, first birth and extinction" });
    $("why").replaceChildren(h("div", { class: "part-head" }, h("h2", { text: "What happened" }), this.player), this.list,
      h("section", { class: "part" }, h("div", { class: "part-head" }, h("h2", { text: "Diagnosis so far" }), this.again), this.account));
    this.draw();
  }

  /** The tick of a kind's latest extinction so far, or null. @param {string} name */
  extinct(name) {
    const ends = this.entries.filter(({ kind, species, tick }) => kind === "extinct" && species === name && tick <= Math.max(this.tick, 0));
    return ends.length ? ends[ends.length - 1].tick : null;
  }

  /** Stores all entries so far, and announces new ones. @param {Entry[]} entries */
  add(entries) {
    const last = this.entries.length ? this.entries[this.entries.length - 1].tick : this.begun ? -1 : Infinity;
    this.begun = true;
    const known = this.entries.filter(({ tick }) => tick === last).length;
    const later = entries.filter(({ tick }) => tick > last);
    const fresh = [...entries.filter(({ tick }) => tick === last).slice(known), ...later];
    this.entries = entries;
    this.draw();
    if (this.hello.mode === "live") for (const entry of fresh) this.tell(entry);
  }

  /** Stores the interventions. @param {import("./protocol.js").Mark[]} marks */
  mark(marks) {
    const before = this.acts.length;
    this.acts = marks.map(({ tick, text }) => ({ tick, kind: "act", species: "", n: 0, text, cause: "" }));
    this.draw();
    if (this.marked && this.hello.mode === "live") for (const entry of this.acts.slice(before)) this.tell(entry);
    this.marked = true;
  }

  /** Called when time reaches a tick. @param {number} tick */
  at(tick) {
    if (tick === this.tick) return;
    const passed = this.hello.mode === "replay" && tick > this.tick && tick - this.tick < NEAR;
    for (const entry of passed ? this.all().filter((one) => one.tick > this.tick && one.tick <= tick) : []) this.tell(entry);
    this.tick = tick;
    if (this.hello.mode === "replay" && displayed("why")) for (const row of this.list.children) row.classList.toggle("later", Number(/** @type {HTMLElement} */ (row).dataset.tick) > tick);
  }

  /** @param {Entry} entry */
  tell(entry) {
    announce(`${entry.text}. ${entry.cause}`);
    this.calls.tell(entry);
  }

  all() {
    return [...this.entries, ...this.acts].sort((a, b) => a.tick - b.tick);
  }

  draw() {
    const rows = this.all().slice(-FEW).reverse().map((entry) => this.row(entry));
    this.list.replaceChildren(...(rows.length ? rows : [h("li", { class: "none", text: "No booms, crashes or extinctions yet." })]));
  }

  /** @param {Entry} entry */
  row(entry) {
    const colour = entry.species ? this.calls.colourOf(entry.species) : "var(--soft)";
    return h("li", { class: `${entry.kind}${entry.tick > this.tick && this.hello.mode === "replay" ? " later" : ""}`, "data-tick": entry.tick },
      h("button", { type: "button", class: "jump", title: "Go there", onclick: () => this.calls.jump(entry) },
        h("i", { style: `--c:${colour}`, text: SIGNS[entry.kind], "aria-hidden": "true" }),
        h("time", { text: number(entry.tick) }), h("b", { text: entry.text })),
      entry.cause && h("p", { text: entry.cause }),
      entry.sweep !== undefined && h("p", {}, h("button", { type: "button", class: "plain", text: "Show this world next to one in which no organism has this allele", onclick: () => this.calls.without(entry) })));
  }

  /** Requests the diagnosis when the tab is first opened. */
  open() {
    if (!this.asked) this.explain();
    this.at(this.tick);
  }

  explain() {
    this.asked = true;
    this.again.disabled = true;
    if (!this.account.childElementCount) this.account.replaceChildren(h("p", { class: "about", text: "Analyzing …" }));
    this.calls.ask();
  }

  /** @param {import("./protocol.js").Why} why */
  show({ tick, first, sections, turns }) {
    this.again.disabled = false;
    const span = this.hello.mode === "replay" ? "The whole recorded run." : `Ticks ${number(first)} to ${number(tick)}.`;
    this.account.replaceChildren(h("p", { class: "about", text: span }),
      ...Object.entries(sections).map(([head, lines]) => h("section", {}, h("h3", { text: head }), h("ul", {}, ...lines.map((text) => h("li", { text }))))));
    if (turns.length) {
      const row = (/** @type {import("./protocol.js").TurnTo} */ { key, value, turn, effect }) => h("li", {}, h("code", { text: key }), ` = ${typeof value === "number" ? number(value) : value}, ${turn}: ${effect}`);
      this.account.append(h("section", {}, h("h3", { text: "What to change" }), h("ul", {}, ...turns.map(row))));
    }
  }

  /** Called when a request was refused. */
  refuse() {
    this.again.disabled = false;
  }
}
