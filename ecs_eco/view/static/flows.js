// Energy flows: a band from each food to its eater, with a width proportional to the energy or number of organisms eaten in the displayed period.

import { h, number, s } from "./dom.js";
import { kindsOf } from "./marks.js";
import { saves } from "./print.js";
import { csv } from "./series.js";
import { css } from "./theme.js";
import { eats, levels } from "./world.js";

/** @typedef {import("./charts.js").Charts} Charts */
/** @typedef {{from: string, to: string, energy: number, meals: number | null}} Meal */
/** @typedef {{name: string, level: number, colour: string, light: number, other: number, burnt: number, dead: number, died: number, given: number}} Node the flows of a species per tick */

const KEPT = "ecs-eco-flows"; // in localStorage: whether bands show energy or numbers
const UNITS = [["energy", "energy per tick"], ["meals", "organisms eaten per tick"]];
const [BAR, TOP, GAP, STUB, TALL] = [9, 18, 24, 30, 76]; // [px] dimensions of the drawing
const THIN = 1.2; // [px] width of the narrowest band

export class Flows {
  /** @param {Charts} charts */
  constructor(charts) {
    this.charts = charts;
    this.unit = recalled();
    /** @type {HTMLElement | null} the element that contains the figure; null if it is not shown */
    this.place = null;
    this.root = h("div");
    this.wide = 0; // [px] width of the last drawing
    new ResizeObserver(() => this.place && this.place.clientWidth !== this.wide && this.draw()).observe(this.root);
  }

  /** Whether this world has feeding relations and data about them. */
  has() {
    return Object.values(this.charts.hello.foods ?? {}).some((foods) => foods.length) && Object.keys(this.charts.lines.flows).length > 0;
  }

  /** Builds or removes the figure's frame. @param {boolean} shown */
  rebuild(shown) {
    this.place = null;
    this.root.replaceChildren();
    if (!shown) return;
    const choice = h("select", { class: "input", "aria-label": "Width of bands", onchange: () => {
      this.unit = choice.value;
      remember(this.unit);
      this.draw();
    } }, ...UNITS.map(([value, text]) => h("option", { value, text, selected: value === this.unit })));
    this.place = h("div", { class: "flows" });
    this.table = h("tbody");
    this.about = h("p", { class: "about" });
    this.keys = h("span", { class: "row" });
    const heads = ["from", "to", "energy per tick", "organisms per tick"].map((text) => h("th", { scope: "col", text }));
    const numbers = h("details", {}, h("summary", { text: "show as a table" }), h("table", { class: "all" }, h("thead", {}, h("tr", {}, ...heads)), this.table));
    this.root.append(h("div", { class: "chart" },
      h("div", { class: "chart-head" }, h("h2", { text: "Who eats whom" }), choice, this.keys, h("span", { class: "grow" }),
        saves("Who eats whom", () => this.csv(), () => ({
          body: this.place?.querySelector("svg"), unit: choice.selectedOptions[0].text,
          legend: [...(this.keys?.children ?? [])].map((one) => ({ name: one.textContent?.trim() ?? "", mark: /** @type {SVGElement} */ (one.children[0].cloneNode(true)) })),
        }))),
      this.place, this.about, numbers));
    this.draw();
  }

  /** How many ticks the number of a point is ahead of the last tick that it includes. */
  get ahead() {
    return this.charts.hello.mode === "replay" ? 0 : 1;
  }

  /** First and last tick of the displayed period. @returns {[number, number]} */
  period() {
    const [from, to] = this.charts.range().map(Math.round);
    return [Math.max(0, from), Math.min(to, this.charts.ticks.at(-1) ?? 0) - this.ahead];
  }

  /** The mean per tick over the displayed period. @param {(number | null)[] | undefined} line rates since the previous point, at the first point of one tick; null before the first event */
  mean(line) {
    const [from, to] = this.period(), ends = this.charts.ticks.map((tick) => tick - this.ahead);
    let sum = 0, span = 0;
    for (let i = line?.[0] == null ? 1 : 0; line && i < line.length; i++) {
      const length = Math.min(ends[i], to) - Math.max(ends[i - 1] ?? ends[0] - 1, from - 1);
      if (length <= 0) continue;
      sum += (line[i] ?? 0) * length;
      span += length;
    }
    return span ? sum / span : null;
  }

  /** The species and the flows between them. @returns {{nodes: Node[], meals: Meal[]}} */
  found() {
    const { charts } = this, foods = eats(charts.hello, Object.keys(charts.lines.causes));
    const eaten = new Set(Object.values(foods).flat());
    const kinds = kindsOf(charts.hello).filter(({ name, inanimate }) => eaten.has(name) || (!inanimate && foods[name]?.length));
    const names = kinds.map(({ name }) => name), shown = names.filter((name) => !charts.away.has(name)), level = levels(shown, foods);
    const flow = (/** @type {string} */ name, /** @type {string} */ what) => this.mean(charts.lines.flows[`${name}: ${what}`]);
    const meals = names.flatMap((to) => names.filter((food) => foods[to]?.includes(food)).map((from) => ({
      from, to, energy: flow(to, `eaten: ${from}`) ?? 0, meals: this.mean(charts.lines.causes[`${from}: eaten by ${to}`]),
    })));
    const nodes = shown.map((name) => {
      const all = meals.filter(({ to }) => to === name).reduce((sum, { energy }) => sum + energy, 0);
      const passed = meals.filter(({ from }) => from === name).reduce((sum, { energy }) => sum + Math.max(0, energy), 0);
      const taken = flow(name, "taken in") ?? 0, rest = Math.max(0, taken - all) > 1e-6 * Math.max(taken, 1e-9) ? taken - all : 0;
      const died = Object.keys(charts.lines.causes).filter((key) => key.startsWith(`${name}: `) && !key.includes(": eaten by "));
      return { name, level: level[name], colour: charts.colourOf(name), light: foods[name]?.length ? 0 : rest, other: foods[name]?.length ? rest : 0,
        burnt: flow(name, "burnt") ?? 0, given: flow(name, "given") ?? 0, dead: Math.max(0, (flow(name, "lost") ?? 0) - passed),
        died: died.reduce((sum, key) => sum + (this.mean(charts.lines.causes[key]) ?? 0), 0) };
    });
    return { nodes, meals: meals.filter(({ from, to }) => shown.includes(from) && shown.includes(to)) };
  }

  draw() {
    if (!this.place?.isConnected) return;
    const { nodes, meals } = this.found();
    const [from, to] = this.period();
    const words = sentences(nodes, meals);
    this.wide = this.place.clientWidth;
    const svg = picture(nodes, meals, this.unit === "energy", Math.max(260, this.wide || 300));
    svg.setAttribute("aria-label", `Who eats whom, ticks ${from} to ${to}: ${words.join("; ") || "no organism was eaten"}`);
    this.place.replaceChildren(svg);
    const shared = this.charts.shared ? " Energy per food was not recorded, so it is divided among foods by the number eaten." : "";
    if (this.about) this.about.textContent = `Means of ticks ${number(from)} to ${number(to)}. Energy is what eaters gain; energy left over at death is what dead organisms still had, minus what eaters gained from them.${shared}`;
    this.keys?.replaceChildren(...keysOf(nodes, meals, this.unit === "energy"));
    this.table?.replaceChildren(...rows(nodes, meals).map((row) => h("tr", {}, ...row.map((cell, i) => (i < 2 ? h("th", { scope: "row", text: cell }) : h("td", { text: typeof cell === "number" ? number(cell) : cell ?? "–" }))))));
  }

  /** The data as comma-separated values. */
  csv() {
    const { nodes, meals } = this.found();
    return csv([["from", "to", "energy per tick", "organisms per tick"], ...rows(nodes, meals)]);
  }
}

/** The flows as sentences for screen readers. @param {Node[]} nodes @param {Meal[]} meals */
function sentences(nodes, meals) {
  const eats = meals.filter(({ meals: n, energy }) => n || energy).map(({ from, to, energy, meals: n }) => `${to} eats ${n === null ? "" : `${number(n)} `}${from} and gains ${number(energy)} energy per tick`);
  return [...nodes.filter(({ light }) => light).map(({ name, light }) => `${name} gains ${number(light)} energy per tick from light`), ...eats,
    ...nodes.filter(({ burnt }) => burnt).map(({ name, burnt }) => `${name} burns ${number(burnt)} energy per tick`)];
}

/** @param {Node[]} nodes @param {Meal[]} meals @returns {(string | number | null)[][]} */
function rows(nodes, meals) {
  return [
    ...nodes.filter(({ light }) => light).map(({ name, light }) => ["light", name, light, null]),
    ...nodes.filter(({ other }) => other).map(({ name, other }) => ["parents and reactions", name, other, null]),
    ...meals.map(({ from, to, energy, meals: n }) => [from, to, energy, n]),
    ...nodes.flatMap(({ name, burnt, given, dead, died }) => [[name, "burned", burnt, null], [name, "young", given, null], [name, "left over at death", dead, null], [name, "died of other causes", null, died]])
      .filter(([, , energy, n]) => energy || n),
  ];
}

/** @param {Node[]} nodes @param {Meal[]} meals @param {boolean} energy */
function keysOf(nodes, meals, energy) {
  const key = (/** @type {string} */ fill, /** @type {string} */ text, opacity = 0.9) => h("span", { class: "key" }, s("svg", { viewBox: "0 0 18 8", "aria-hidden": "true" }, s("rect", { width: 18, height: 8, rx: 2, fill, opacity })), text, " ");
  if (!energy) return nodes.some(({ died }) => died) ? [key(css("--soft"), "died of other causes")] : [];
  return [nodes.some(({ light }) => light) && key(css("--light"), "light"), nodes.some(({ burnt }) => burnt) && key(css("--soft"), "burned", 0.35),
    nodes.some(({ dead }) => dead) && key(css("--soft"), "left over at death"), meals.some((meal) => meal.energy < 0) && key(css("--minus"), "harms the eater", 0.5)].filter((one) => one !== false);
}

/**
 * The drawing, with eaters to the right of their foods.
 * @param {Node[]} nodes
 * @param {Meal[]} meals
 * @param {boolean} energy whether bands show energy instead of numbers
 * @param {number} wide [px]
 */
function picture(nodes, meals, energy, wide) {
  const size = (/** @type {Meal} */ meal) => Math.abs((energy ? meal.energy : meal.meals) ?? 0);
  const enters = (/** @type {Node} */ node) => (energy ? node.light + node.other : 0);
  const leaves = (/** @type {Node} */ node) => (energy ? [node.burnt, node.dead] : [0, node.died]);
  const through = (/** @type {Node} */ node) => Math.max(enters(node) + sum(meals.filter(({ to }) => to === node.name).map(size)), sum(leaves(node)) + sum(meals.filter(({ from }) => from === node.name).map(size)));
  const columns = [...new Set(nodes.map(({ level }) => level))].sort((a, b) => a - b).map((level) => nodes.filter((node) => node.level === level));
  const scale = TALL / Math.max(1e-12, ...columns.map((column) => sum(column.map(through))));
  const left = energy && nodes.some(({ light }) => light) ? STUB : 2;
  const x = (/** @type {number} */ c) => left + (columns.length > 1 ? ((wide - left - STUB - BAR - 2) * c) / (columns.length - 1) : 0);
  /** @type {Record<string, {x: number, y: number, high: number, in: number, out: number, column: number}>} */
  const at = {};
  columns.forEach((column, c) => {
    let y = TOP;
    for (const node of column) {
      const high = Math.max(3, scale * through(node));
      at[node.name] = { x: x(c), y, high, in: y, out: y, column: c };
      y += high + GAP;
    }
  });
  const bottom = Math.max(...Object.values(at).map(({ y, high }) => y + high)) + 6;
  const root = s("svg", { viewBox: `0 0 ${wide} ${bottom}`, width: wide, height: bottom, role: "img", class: "flow-picture", "font-family": css("--font"), "font-size": 11 });
  for (const node of nodes) {
    const place = at[node.name], given = enters(node) * scale;
    if (given) {
      root.append(s("rect", { x: place.x - STUB + 2, y: place.in, width: STUB - 2, height: Math.max(THIN, given), fill: css("--light"), opacity: 0.8, "data-light": node.name }, s("title", {}, `${node.name} from ${node.light ? "light" : "parents and reactions"}: ${number(enters(node))} energy per tick`)));
      place.in += given;
    }
  }
  for (const meal of meals) root.append(band(meal, at, size(meal), scale, nodes, energy));
  for (const node of nodes) {
    const place = at[node.name];
    leaves(node).forEach((value, i) => {
      const high = value * scale, what = !i ? "burnt" : energy ? "left over at death" : "died of other causes";
      if (value) root.append(s("rect", { x: place.x + BAR, y: place.out, width: STUB - 4, height: Math.max(THIN, high), fill: css("--soft"), opacity: i ? 0.9 : 0.35, "data-loss": `${node.name} ${what}` }, s("title", {}, `${node.name}, ${what}: ${number(value)} per tick`)));
      place.out += high;
    });
    const last = columns.length > 1 && place.column === columns.length - 1;
    const next = place.column + 1, ends = next === columns.length - 1; // names in the last column end at the bars
    const room = last || next === columns.length ? Infinity : x(next) - place.x - 8 + (ends ? BAR - Math.max(...columns[next].map(({ name }) => breadth(`${name} 0.00`))) : 0);
    const given = energy ? enters(node) + sum(meals.filter(({ to }) => to === node.name).map(({ energy: value }) => value)) : sum(meals.filter(({ to }) => to === node.name).map(size));
    root.append(s("rect", { x: place.x, y: place.y, width: BAR, height: place.high, rx: 2, fill: node.colour, "data-node": node.name }),
      s("text", { x: last ? place.x + BAR : place.x, y: place.y - 5, "text-anchor": last ? "end" : "start", fill: css("--ink"), class: "flow-name" }, fitting(node.name, given ? ` ${number(given, 2)}` : "", room)));
  }
  return root;
}

/**
 * A band from food to eater, or a dotted line if there was no flow.
 * @param {Meal} meal
 * @param {Record<string, {x: number, y: number, high: number, in: number, out: number, column: number}>} at
 * @param {number} size
 * @param {number} scale
 * @param {Node[]} nodes
 * @param {boolean} energy
 */
function band(meal, at, size, scale, nodes, energy) {
  const [from, to] = [at[meal.from], at[meal.to]], high = Math.max(size * scale, THIN);
  const [x0, y0, x1, y1] = [from.x + BAR, from.out + high / 2, to.x, to.in + high / 2];
  const reach = Math.max(24, Math.abs(x1 - x0) / 2);
  const colour = nodes.find(({ name }) => name === meal.from)?.colour ?? css("--soft");
  const harms = energy && meal.energy < 0;
  const d = meal.from === meal.to ? `M${x0},${y0}c26,-22 ${-BAR - 52},-22 ${-BAR - 26 + 26},0` : `M${x0},${y0}C${x0 + reach},${y0} ${x1 - reach},${y1} ${x1},${y1}`;
  from.out += size * scale;
  to.in += size * scale;
  const words = `${meal.to} eats ${meal.meals === null ? "" : `${number(meal.meals)} `}${meal.from} per tick: ${number(meal.energy)} energy`;
  const drawn = s("path", { d, fill: "none", stroke: harms ? css("--minus") : colour, "stroke-width": high.toFixed(2), "stroke-opacity": size ? 0.5 : 0.9,
    "stroke-dasharray": harms ? "3 3" : size ? null : "1 4", "data-meal": `${meal.from} ${meal.to}`, "data-size": size }, s("title", {}, words));
  const other = energy ? meal.meals : meal.energy;
  if (high < 13 || other === null || Math.abs(x1 - x0) < 70) return drawn;
  const text = energy ? `${number(other, 2)} eaten` : `${number(other, 2)} energy`;
  return s("g", {}, drawn, s("text", { x: (x0 + x1) / 2, y: (y0 + y1) / 2 + 4, "text-anchor": "middle", fill: css("--ink"), "pointer-events": "none" }, text));
}

/** A name with its number, without it or shortened, to fit the available width [px]. @param {string} name @param {string} amount @param {number} room */
function fitting(name, amount, room) {
  const cuts = Array.from({ length: name.length - 3 }, (_, i) => `${name.slice(0, name.length - 1 - i)}…`);
  return [name + amount, name, ...cuts].find((text) => breadth(text) < room) ?? `${name.slice(0, 2)}…`;
}

/** The width of a bold word [px]. @param {string} text */
function breadth(text) {
  const pen = document.createElement("canvas").getContext("2d");
  if (pen) pen.font = `560 11px ${css("--font")}`;
  return pen?.measureText(text).width ?? 7 * text.length;
}

const sum = (/** @type {number[]} */ values) => values.reduce((a, b) => a + b, 0);

/** @returns {string} */
function recalled() {
  try {
    const kept = localStorage.getItem(KEPT);
    if (UNITS.some(([value]) => value === kept)) return /** @type {string} */ (kept);
  } catch {} // treated as if nothing were stored
  return UNITS[0][0];
}

/** @param {string} unit */
function remember(unit) {
  try {
    localStorage.setItem(KEPT, unit);
  } catch {} // storage may be unavailable in private windows
}
