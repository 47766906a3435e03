// Charts that scroll along: populations, happiness and gene frequencies, on one axis of ticks, nights shaded.

import { uPlot } from "./vendor.js";
import { $, h, number } from "./dom.js";
import { genes } from "./colours.js";
import { DASHES, stroke } from "./marks.js";
import { css, isDark } from "./theme.js";

/** @typedef {import("./protocol.js").Series} Series */
/** @typedef {(number | null)[]} Line */

const MOST = 12000; // points kept; then every second of the older half goes
const WINDOWS = [["last 500", 500], ["last 2 000", 2000], ["last 10 000", 10000], ["all ticks", Infinity]];

/** @type {{key: string, title: string}[]} */
const CHARTS = [
  { key: "n", title: "Populations" },
  { key: "happiness", title: "Happiness, mean" },
  { key: "genes", title: "Genes" },
];

const REPORT = "report "; // before the names of reporters, each of which has a chart of its own

export class Charts {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {(name: string) => string} colourOf
   */
  constructor(hello, colourOf) {
    this.hello = hello;
    this.colourOf = colourOf;
    this.tick = hello.tick;
    /** @type {number[]} */
    this.ticks = [];
    /** @type {Line} */
    this.light = [];
    this.charts = [...CHARTS];
    /** @type {Record<string, Record<string, Line>>} */
    this.lines = { n: {}, happiness: {}, genes: {} };
    /** @type {Set<string>} */
    this.hidden = new Set();
    /** @type {Set<string>} kinds that the legend hides */
    this.away = new Set();
    this.window = hello.mode === "replay" ? Infinity : 2000;
    this.log = false;
    /** @type {Map<string, {plot: uPlot, values: Map<string, HTMLElement>, signature: string}>} */
    this.plots = new Map();
    this.root = $("charts");
    this.body = h("div");
    this.root.replaceChildren(this.tools(), this.body);
    new ResizeObserver(() => this.resize()).observe(this.body);
  }

  tools() {
    const choice = h("select", { class: "input", style: "width:auto", "aria-label": "Ticks shown", onchange: () => {
      this.window = Number(WINDOWS[choice.selectedIndex][1]);
      this.draw();
    } }, ...WINDOWS.map(([text, ticks]) => h("option", { text: text, selected: ticks === this.window })));
    this.logarithmic = h("button", { type: "button", class: "toggle", "aria-pressed": "false", text: "log", title: "Logarithmic axis for populations", onclick: () => {
      this.log = !this.log;
      this.logarithmic?.setAttribute("aria-pressed", String(this.log));
      this.rebuild();
    } });
    this.chooser = h("div", { class: "row", role: "group", "aria-label": "Charts shown" });
    this.choice = choice;
    return h("div", { class: "row tools" }, this.chooser, choice);
  }

  /** @param {Series} series points to be appended */
  add(series) {
    const first = series.tick[0];
    if (first === undefined) return;
    if (this.ticks.length && first <= this.ticks[this.ticks.length - 1]) this.cut(first);
    const length = this.ticks.length;
    this.ticks.push(...series.tick);
    append(this.light, series.light, length, series.tick.length);
    /** @type {Record<string, Record<string, Line> | undefined>} */
    const given = { n: series.n, happiness: series.happiness, genes: series.genes };
    for (const [name, lines] of Object.entries(series.reports ?? {})) {
      given[REPORT + name] = lines;
      if (!(REPORT + name in this.lines)) this.charts.push({ key: REPORT + name, title: name });
      this.lines[REPORT + name] ??= {};
    }
    for (const key of Object.keys(this.lines)) {
      const names = new Set([...Object.keys(this.lines[key]), ...Object.keys(given[key] ?? {})]);
      for (const name of names) append((this.lines[key][name] ??= []), given[key]?.[name], length, series.tick.length);
    }
    if (this.ticks.length > MOST) this.thin();
    this.draw();
  }

  /** Forgets what is at a tick and after. @param {number} tick */
  cut(tick) {
    const keep = this.ticks.findIndex((t) => t >= tick);
    for (const line of this.all()) line.length = keep;
  }

  thin() {
    const half = this.ticks.length >> 1;
    for (const line of this.all()) {
      const kept = line.filter((_, i) => i > half || i % 2 === 0);
      line.length = 0;
      for (const value of kept) line.push(/** @type {number} */ (value));
    }
  }

  /** Every array that goes along with the ticks. @returns {Line[]} */
  all() {
    return [this.ticks, this.light, ...Object.values(this.lines).flatMap((lines) => Object.values(lines))];
  }

  /** Time has come to this tick. @param {number} tick */
  at(tick) {
    if (tick === this.tick) return;
    this.tick = tick;
    if (this.hello.mode === "replay") for (const { plot } of this.plots.values()) this.window === Infinity ? plot.redraw(false) : plot.setData(plot.data);
    this.values();
  }

  /** Points at a tick in all charts, so that what was there can be read. @param {number} tick */
  point(tick) {
    if (this.window !== Infinity && (this.ticks[this.ticks.length - 1] ?? 0) - tick > this.window) {
      this.window = Infinity;
      if (this.choice) this.choice.selectedIndex = WINDOWS.length - 1;
      this.draw();
    }
    for (const { plot } of this.plots.values()) plot.setCursor({ left: plot.valToPos(tick, "x"), top: 10 });
  }

  /** First and last tick on the axis. @returns {[number, number]} */
  range() {
    const { ticks } = this;
    const newest = ticks.length ? ticks[ticks.length - 1] : this.hello.tick + 1;
    if (this.hello.mode === "replay" && this.window !== Infinity) return [this.tick - this.window / 2, this.tick + this.window / 2];
    const oldest = ticks[0] ?? this.hello.tick;
    const from = Math.max(oldest, newest - this.window);
    return [from, Math.max(newest, from + 10)];
  }

  /** Shows or hides the curves of a kind. @param {string} name @param {boolean} shown */
  show(name, shown) {
    if (shown) this.away.delete(name);
    else this.away.add(name);
    this.rebuild();
  }

  rebuild() {
    for (const { plot } of this.plots.values()) plot.destroy();
    this.plots.clear();
    this.body.replaceChildren();
    this.draw();
  }

  draw() {
    const there = this.charts.filter(({ key }) => Object.values(this.lines[key]).some((line) => line.some((value) => value !== null)));
    if (this.chooser && this.chooser.childElementCount !== there.length) {
      this.chooser.replaceChildren(...there.map(({ key, title }) => this.toggle(key, title)));
    }
    for (const { key, title } of there) {
      if (this.hidden.has(key)) continue;
      const names = this.names(key);
      const old = this.plots.get(key);
      if (old?.signature !== names.join()) {
        old?.plot.root.closest(".chart")?.remove();
        old?.plot.destroy();
        this.plots.set(key, this.build(key, title, names));
      }
      const made = this.plots.get(key);
      made?.plot.setData(/** @type {any} */ ([this.ticks, ...names.map((name) => this.lines[key][name])]));
    }
    this.values();
  }

  /** Lines with something to show. @param {string} key */
  names(key) {
    return Object.keys(this.lines[key]).filter((name) => !this.away.has(name.split(".")[0])).filter((name) => key === "n" || this.lines[key][name].some((value) => value !== null));
  }

  /**
   * @param {string} key
   * @param {string} title
   */
  toggle(key, title) {
    const short = title.split(",")[0];
    const button = h("button", { type: "button", class: "toggle", "aria-pressed": String(!this.hidden.has(key)), text: short, onclick: () => {
      if (!this.hidden.delete(key)) this.hidden.add(key);
      button.setAttribute("aria-pressed", String(!this.hidden.has(key)));
      this.rebuild();
    } });
    return button;
  }

  /**
   * @param {string} key
   * @param {string} title
   * @param {string[]} names
   */
  build(key, title, names) {
    const hues = genes(isDark());
    const colours = names.map((name, i) => (key === "genes" ? hues[i % hues.length] : name ? this.colourOf(name) : css("--ink")));
    const dashes = names.map((_, i) => (key === "genes" ? DASHES[Math.floor(i / hues.length) % DASHES.length] : DASHES[i % 3]));
    /** @type {Map<string, HTMLElement>} */
    const values = new Map();
    const head = h("div", { class: "chart-head" }, h("h2", { text: title }));
    names.forEach((name, i) => {
      const value = h("b", { text: "–" });
      values.set(name, value);
      head.append(h("span", { class: "key" }, stroke(colours[i], dashes[i]), name || "the world", " ", value));
    });
    if (key === "n" && this.logarithmic) head.append(h("span", { class: "grow" }), this.logarithmic);
    const place = h("div", { class: "chart" }, head);
    const after = this.charts.slice(this.charts.findIndex((chart) => chart.key === key) + 1).map((chart) => this.plots.get(chart.key)).find(Boolean);
    this.body.insertBefore(place, after?.plot.root.closest(".chart") ?? null);
    const axis = { stroke: css("--soft"), font: "11px " + css("--font"), ticks: { show: false }, grid: { stroke: css("--line"), width: 1 } };
    const plot = new uPlot({
      width: Math.max(200, this.body.clientWidth), height: key === "n" ? 172 : 138,
      padding: [6, 8, 0, 0],
      cursor: { sync: { key: "ecs" }, y: false, points: { size: 6 }, drag: { x: false, y: false } },
      legend: { show: false },
      scales: { x: { time: false, range: () => this.range() }, y: { distr: key === "n" && this.log ? 3 : 1, range: key === "n" && !this.log ? (_, _low, high) => [0, high > 0 ? high * 1.06 : 1] : undefined } },
      axes: [
        { ...axis, size: 24, space: 70, values: (_, splits) => splits.map((v) => number(v)) },
        { ...axis, size: 46, space: 30, values: (_, splits) => splits.map((v) => (v === null ? "" : number(v))) },
      ],
      series: [{}, ...names.map((name, i) => ({ label: name, stroke: colours[i], width: 1.8, dash: dashes[i], points: { show: false }, spanGaps: true }))],
      hooks: { drawClear: [(u) => this.nights(u)], draw: [(u) => this.cursor(u)], setCursor: [() => this.values()] },
    }, [[]], place);
    return { plot, values, signature: names.join() };
  }

  /** Numbers beside the names: under the pointer, else now. */
  values() {
    for (const [key, { plot, values }] of this.plots) {
      let at = plot.cursor.idx ?? this.ticks.length - 1;
      if (plot.cursor.idx === null && this.hello.mode === "replay") at = this.ticks.findLastIndex((tick) => tick <= this.tick);
      for (const [name, element] of values) {
        const text = number(this.lines[key][name]?.[at]);
        if (element.textContent !== text) element.textContent = text;
      }
    }
  }

  /** Shades the hours without light. @param {uPlot} u */
  nights(u) {
    if (!this.light.some((value) => value !== null && value < 0.98)) return;
    const { left, top, width, height } = u.bbox;
    u.ctx.save();
    u.ctx.fillStyle = css("--night");
    let from = left;
    for (let i = 1; i < this.ticks.length; i++) {
      const to = u.valToPos(this.ticks[i], "x", true);
      if (to < left || to - from < 1) continue;
      u.ctx.globalAlpha = 0.4 * (1 - Math.min(1, Math.max(0, this.light[i] ?? 1)));
      u.ctx.fillRect(Math.round(from), top, Math.round(Math.min(to, left + width)) - Math.round(from), height);
      from = to;
      if (to > left + width) break;
    }
    u.ctx.restore();
  }

  /** In replay: where the scene is. @param {uPlot} u */
  cursor(u) {
    if (this.hello.mode !== "replay") return;
    const x = u.valToPos(this.tick, "x", true);
    if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
    u.ctx.save();
    u.ctx.fillStyle = css("--ink");
    u.ctx.fillRect(Math.round(x) - 1, u.bbox.top, 1.5 * devicePixelRatio, u.bbox.height);
    u.ctx.restore();
  }

  resize() {
    const width = this.body.clientWidth;
    if (width) for (const { plot } of this.plots.values()) plot.setSize({ width, height: plot.height });
  }
}

/**
 * Appends n values, with gaps where there were or are none.
 * @param {Line} line
 * @param {Line | undefined} values
 * @param {number} length of the ticks before
 * @param {number} n
 */
function append(line, values, length, n) {
  while (line.length < length) line.push(null);
  for (let i = 0; i < n; i++) {
    const value = values?.[i] ?? null;
    line.push(value === null || Number.isNaN(value) ? null : value);
  }
}
