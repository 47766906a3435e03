// Figures below the charts: the phase plane of two species, and the distribution of the value by which organisms are colored.

import { BOTTOM, HIGH, LEFT, RIGHT, TOP, WIDE, grid } from "./axes.js";
import { h, number, s } from "./dom.js";
import { Flows } from "./flows.js";
import { WORDS } from "./frame.js";
import { saves } from "./print.js";
import { Scatter } from "./scatter.js";
import { css } from "./theme.js";

/** @typedef {import("./charts.js").Charts} Charts */
/** @typedef {{layers: () => import("./layer.js").Layer[], scales: () => Record<string, [number, number]>, by: () => string, colours: string[], colour: (name: string) => void, ask: (x: string, y: string) => void, select: (uid: number) => void}} Scene access to the current scene */

export const FIGURES = [{ key: "flows", title: "Who eats whom" }, { key: "plane", title: "Phase plane" }, { key: "spread", title: "Distribution" }, { key: "scatter", title: "Organisms" }];

const KEPT = "ecs-eco-plane"; // in localStorage: the two species of the phase plane
const MOST = 1500; // maximum number of points in the curve
const BINS = 25;
const PACE = 250; // [ms] between updates of a distribution

export class Figures {
  /**
   * @param {Charts} charts
   * @param {Scene} scene
   */
  constructor(charts, scene) {
    this.charts = charts;
    this.scene = scene;
    this.names = charts.hello.species.map(({ name }) => name);
    const moving = charts.hello.species.filter(({ moves }) => moves).map(({ name }) => name);
    /** @type {string[]} */
    this.pair = recalled(this.names) ?? [...moving, ...this.names.filter((name) => !moving.includes(name))].slice(0, 2);
    this.scatter = new Scatter({ ask: scene.ask, select: scene.select, colourOf: (name) => charts.colourOf(name), shown: (name) => !charts.away.has(name) });
    this.flows = new Flows(charts);
    this.root = h("div");
    this.waiting = 0;
  }

  /** Whether the world has the data for a figure. @param {string} key */
  has(key) {
    if (key === "flows") return this.flows.has();
    if (key === "scatter") return this.names.length > 0 && !this.charts.hello.file;
    return key === "plane" ? this.names.length > 1 : this.scene.colours.length > 1;
  }

  shown() {
    return FIGURES.filter(({ key }) => this.has(key) && !this.charts.hidden.has(key)).map(({ key }) => key);
  }

  /** Builds the frames of the figures that are shown. */
  rebuild() {
    this.root.replaceChildren();
    /** @type {HTMLElement | null} */
    this.plane = this.spread = null;
    this.scatter.place = null;
    const shown = this.shown();
    this.flows.rebuild(shown.includes("flows"));
    for (const key of shown.filter((key) => key !== "flows")) {
      if (key === "scatter") {
        this.root.append(this.scatter.frame());
        continue;
      }
      const place = h("div", { class: "figure" });
      if (key === "plane") {
        this.plane = place;
        const choice = (/** @type {number} */ axis) => h("select", { class: "input", "aria-label": axis ? "Species on the vertical axis" : "Species on the horizontal axis", onchange: (/** @type {Event} */ event) => {
          this.pair[axis] = /** @type {HTMLSelectElement} */ (event.currentTarget).value;
          remember(this.pair);
          this.draw();
        } }, ...this.names.map((name) => h("option", { value: name, text: name, selected: name === this.pair[axis] })));
        this.root.append(h("div", { class: "chart" }, h("div", { class: "chart-head" }, h("h2", { text: "Phase plane" }), h("span", { class: "unit", text: "organisms" }), choice(1), "against", choice(0), h("span", { class: "grow" }), saves("Phase plane", null, () => ({ body: place.querySelector("svg"), unit: "organisms" }))), place));
      } else {
        this.spread = place;
        const choice = h("select", { class: "input", "aria-label": "Value of the distribution", onchange: () => this.scene.colour(choice.value) },
          ...this.scene.colours.map((name) => h("option", { value: name, text: name === "species" ? "choose …" : name.replace("gene:", "gene "), selected: name === this.scene.by() })));
        this.choice = choice;
        this.root.append(h("div", { class: "chart" }, h("div", { class: "chart-head" }, h("h2", { text: "Distribution" }), h("span", { class: "unit", text: "share of a species, by" }), choice, h("span", { class: "grow" }), saves("Distribution", null, () => ({ body: place.querySelector("svg"), unit: `share of a species, by ${this.scene.by().replace("gene:", "gene ")}` }))), place));
      }
    }
    this.draw();
  }

  /** Updates after new points or at another tick: immediately at first, then at a fixed pace. */
  at() {
    this.scatter.time(this.charts.tick);
    if (!this.flows.place && this.shown().includes("flows")) this.flows.rebuild(true);
    if (this.waiting || !(this.plane || this.spread || this.flows.place)) return;
    this.draw();
    this.waiting = setTimeout(() => {
      this.waiting = 0;
      this.draw();
    }, PACE);
  }

  draw() {
    this.flows.draw();
    this.plane?.replaceChildren(this.curve());
    this.spread?.replaceChildren(this.histogram());
  }

  /** The population of one species plotted against that of another; older ticks are paler. */
  curve() {
    const { charts, pair } = this;
    const end = charts.hello.mode === "replay" ? charts.ticks.findLastIndex((tick) => tick <= charts.tick) : charts.ticks.length - 1;
    const [from] = charts.range();
    const first = Math.max(0, charts.ticks.findIndex((tick) => tick >= Math.min(from, charts.tick)));
    const every = Math.max(1, Math.ceil((end - first) / MOST));
    /** @type {number[][]} */
    const points = [];
    for (let i = end; i >= first; i -= every) {
      const [x, y] = pair.map((name) => charts.lines.n[name]?.[i]);
      if (x != null && y != null) points.unshift([x, y]);
    }
    const most = [0, 1].map((axis) => Math.max(1, ...points.map((point) => point[axis])) * 1.05);
    const place = (/** @type {number[]} */ [x, y]) => [LEFT + ((WIDE - LEFT - RIGHT) * x) / most[0], HIGH - BOTTOM - ((HIGH - BOTTOM - TOP) * y) / most[1]];
    const parts = 8;
    const root = axes(pair[0], pair[1], most, `${pair[1]} against ${pair[0]}: ${points.length} points`);
    for (let part = 0; part < parts; part++) {
      const some = points.slice(Math.floor((points.length * part) / parts), Math.floor((points.length * (part + 1)) / parts) + 1);
      root.append(s("polyline", { points: some.map((point) => place(point).map((v) => v.toFixed(1)).join()).join(" "), fill: "none", stroke: css("--accent"), "stroke-width": 1.6, "stroke-linejoin": "round", opacity: (0.25 + (0.75 * (part + 1)) / parts).toFixed(2) }));
    }
    const now = points[points.length - 1];
    if (now) {
      const [cx, cy] = place(now);
      root.append(s("circle", { cx, cy, r: 4.5, fill: css("--accent"), stroke: css("--card"), "stroke-width": 2, "data-now": now.join() }));
    }
    return root;
  }

  /** A histogram of the value, for each species that has it. */
  histogram() {
    const by = this.scene.by();
    if (this.choice && this.choice.value !== by) this.choice.value = by;
    if (by === "species") return h("p", { class: "about", text: "Color organisms by a value to see its distribution here." });
    const scales = this.scene.scales();
    const found = this.scene.layers().filter(({ kind, block, shown }) => !kind.inanimate && shown && block.n && scales[kind.name]).map(({ kind, block }) => ({ name: kind.name, range: scales[kind.name], ...binned(block) })).filter(({ n }) => n);
    if (!found.length) return h("p", { class: "about", text: "No organism has this value." });
    const low = Math.min(...found.map(({ range }) => range[0])), high = Math.max(...found.map(({ range }) => range[1]), low + 1e-9);
    const most = Math.max(...found.flatMap(({ bins, n }) => bins.map((count) => count / n)));
    const root = axes(by.replace("gene:", "gene "), "share", [high, 100 * most], `Distribution of ${by}`, low);
    const x = (/** @type {number} */ value) => LEFT + ((WIDE - LEFT - RIGHT) * (value - low)) / (high - low);
    for (const { name, range, bins, n } of found) {
      const corners = bins.flatMap((count, i) => {
        const y = HIGH - BOTTOM - ((HIGH - BOTTOM - TOP) * count) / n / most;
        return [0, 1].map((end) => `${x(range[0] + ((range[1] - range[0]) * (i + end)) / BINS).toFixed(1)},${y.toFixed(1)}`);
      });
      const ends = [range[0], range[1]].map((value) => `${x(value).toFixed(1)},${HIGH - BOTTOM}`);
      const colour = this.charts.colourOf(name);
      root.append(s("polygon", { points: [ends[0], ...corners, ends[1]].join(" "), fill: colour, "fill-opacity": 0.18, stroke: colour, "stroke-width": 1.6, "data-kind": name, "data-n": n }, s("title", {}, `${name}: ${number(n)}`)));
    }
    return root;
  }
}

/** Counts organisms by value, excluding organisms without a value. @param {import("./frame.js").Block} block */
function binned({ n, words }) {
  const bins = Array(BINS).fill(0);
  let counted = 0;
  for (let row = 0; row < n; row++) {
    const value = words[WORDS * row + 3] >> 8;
    if (!value) continue;
    bins[Math.min(BINS - 1, Math.floor(((value - 1) * BINS) / 255))]++;
    counted++;
  }
  return { bins, n: counted };
}

/**
 * Draws axes with titles and numbers.
 * @param {string} right
 * @param {string} up
 * @param {number[]} most values at the ends of the axes
 * @param {string} label
 * @param {number} low value at the start of the first axis
 */
function axes(right, up, most, label, low = 0) {
  const root = s("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, class: "figure-axes", role: "img", "aria-label": label });
  const [line, soft] = [css("--line"), css("--soft")];
  const x = (/** @type {number} */ value) => LEFT + ((WIDE - LEFT - RIGHT) * (value - low)) / (most[0] - low);
  const y = (/** @type {number} */ value) => HIGH - BOTTOM - ((HIGH - BOTTOM - TOP) * value) / most[1];
  root.append(...grid([low, most[0]], x, [0, most[1]], y, up === "share" ? "%" : ""), s("path", { d: `M${LEFT},${TOP}V${HIGH - BOTTOM}H${WIDE - RIGHT}`, fill: "none", stroke: line }));
  root.append(s("text", { x: (LEFT + WIDE - RIGHT) / 2, y: HIGH - 4, "text-anchor": "middle", fill: soft }, right));
  if (up !== "share") root.append(s("text", { x: 11, y: HIGH / 2, "text-anchor": "middle", fill: soft, transform: `rotate(-90 11 ${HIGH / 2})` }, up));
  return root;
}

/** @param {string[]} names @returns {string[] | null} */
function recalled(names) {
  try {
    const pair = JSON.parse(localStorage.getItem(KEPT) ?? "null");
    return Array.isArray(pair) && pair.length === 2 && pair.every((name) => names.includes(name)) ? pair : null;
  } catch {
    return null;
  }
}

/** @param {string[]} pair */
function remember(pair) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(pair));
  } catch {} // storage may be unavailable in private windows
}
