// A scatter plot of two values, with points in the color of the species; a click selects an organism.

import { BOTTOM, HIGH, LEFT, RIGHT, TOP, WIDE, grid } from "./axes.js";
import { h, s } from "./dom.js";
import { saves } from "./print.js";
import { css } from "./theme.js";

/** @typedef {import("./protocol.js").ScatterMessage} ScatterMessage */

const KEPT = "ecs-eco-scatter"; // in localStorage: the two values
const PACE = 1500; // [ms] between requests while time passes

export class Scatter {
  /** @param {{ask: (x: string, y: string) => void, select: (uid: number) => void, colourOf: (name: string) => string, shown: (name: string) => boolean}} calls */
  constructor(calls) {
    this.calls = calls;
    this.pair = recalled();
    this.at = 0;
    this.tick = -1;
    /** @type {ScatterMessage | null} */
    this.message = null;
    /** @type {HTMLElement | null} the element that contains the figure; null if it is not shown */
    this.place = null;
    this.choices = [0, 1].map((axis) => {
      const choice = h("select", { class: "input", "aria-label": axis ? "Value on the vertical axis" : "Value on the horizontal axis", onchange: () => {
        this.pair[axis] = choice.value;
        remember(this.pair);
        this.ask();
      } });
      return choice;
    });
  }

  /** The frame of the figure. */
  frame() {
    this.place = h("div", { class: "figure" });
    this.ask();
    this.draw();
    return h("div", { class: "chart" }, h("div", { class: "chart-head" }, h("h2", { text: "Organisms" }), h("span", { class: "unit", text: "one point per organism" }), this.choices[1], "against", this.choices[0],
      h("span", { class: "grow" }), saves("Organisms", null, () => ({ body: this.place?.querySelector("svg"), unit: "one point per organism" }))), this.place);
  }

  ask() {
    this.at = performance.now();
    this.calls.ask(this.pair[0], this.pair[1]);
  }

  /** Called when time reaches a tick. @param {number} tick */
  time(tick) {
    if (!this.place?.checkVisibility() || tick === this.tick || performance.now() - this.at < PACE) return;
    this.tick = tick;
    this.ask();
  }

  /** Reports that this world does not have the chosen values. */
  refuse() {
    if (this.pair.join() === "age,energy") return;
    this.pair = ["age", "energy"];
    this.ask();
  }

  /** @param {ScatterMessage} message */
  show(message) {
    this.message = message;
    this.choices.forEach((choice, axis) => {
      if (choice.childElementCount !== message.names.length) choice.replaceChildren(...message.names.map((name) => h("option", { value: name, text: name.replace("gene:", "gene ") })));
      choice.value = this.pair[axis];
    });
    this.draw();
  }

  draw() {
    const { message, place } = this;
    if (!place || !message) return;
    const found = Object.entries(message.points).filter(([name]) => this.calls.shown(name));
    const values = (/** @type {"x" | "y"} */ axis) => found.flatMap(([, points]) => points[axis]);
    const ends = /** @type {const} */ (["x", "y"]).map((axis) => {
      const all = values(axis);
      const low = all.reduce((a, b) => Math.min(a, b), Infinity), high = all.reduce((a, b) => Math.max(a, b), -Infinity);
      return Number.isFinite(low) ? [low, high > low ? high : low + 1] : [0, 1];
    });
    const x = (/** @type {number} */ value) => LEFT + ((WIDE - LEFT - RIGHT) * (value - ends[0][0])) / (ends[0][1] - ends[0][0]);
    const y = (/** @type {number} */ value) => HIGH - BOTTOM - ((HIGH - BOTTOM - TOP) * (value - ends[1][0])) / (ends[1][1] - ends[1][0]);
    const total = found.reduce((sum, [, { uid }]) => sum + uid.length, 0);
    const root = s("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, class: "figure-axes", role: "img", "aria-label": `${message.y} against ${message.x}: ${total} organisms` });
    root.append(...grid(ends[0], x, ends[1], y));
    for (const [name, points] of found) {
      const group = s("g", { fill: this.calls.colourOf(name), "fill-opacity": 0.65, "data-kind": name, "data-n": points.uid.length });
      points.uid.forEach((uid, i) => group.append(s("circle", { cx: x(points.x[i]).toFixed(1), cy: y(points.y[i]).toFixed(1), r: 2.2, "data-uid": uid })));
      root.append(group);
    }
    root.append(s("text", { x: (LEFT + WIDE - RIGHT) / 2, y: HIGH - 4, "text-anchor": "middle", fill: css("--soft") }, words(message.x)),
      s("text", { x: 11, y: HIGH / 2, "text-anchor": "middle", fill: css("--soft"), transform: `rotate(-90 11 ${HIGH / 2})` }, words(message.y)));
    root.addEventListener("click", (event) => {
      const uid = Number(/** @type {Element} */ (event.target).getAttribute("data-uid"));
      if (uid) this.calls.select(uid);
    });
    place.replaceChildren(root);
  }
}

const UNITS = /** @type {Record<string, string>} */ ({ age: "age [s]", x: "x [m]", y: "y [m]", z: "z [m]", born: "tick of birth", family: "uid of the founder" });

/** @param {string} name */
const words = (name) => UNITS[name] ?? name.replace("gene:", "gene ");

/** @returns {string[]} */
function recalled() {
  try {
    const pair = JSON.parse(localStorage.getItem(KEPT) ?? "null");
    if (Array.isArray(pair) && pair.length === 2 && pair.every((name) => typeof name === "string")) return pair;
  } catch {} // treated as if nothing were stored
  return ["age", "energy"];
}

/** @param {string[]} pair */
function remember(pair) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(pair));
  } catch {} // storage may be unavailable in private windows
}
