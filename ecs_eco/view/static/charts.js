// Scrolling charts of populations, happiness, genes, births and deaths, stacked on a common tick axis, with nights shaded.

import { uPlot } from "./vendor.js";
import { $, h, number } from "./dom.js";
import { REPORT, append, grouped, nights, recalled, remember, table } from "./series.js";
import { plotted, saves } from "./print.js";
import { genes } from "./colours.js";
import { FIGURES, Figures } from "./figures.js";
import { round } from "./ground.js";
import { DASHES, stroke } from "./marks.js";
import { soon } from "./pace.js";
import { css, isDark } from "./theme.js";

/** @typedef {import("./protocol.js").Series} Series */
/** @typedef {(number | null)[]} Line */

const [PLAIN, THIN, THICK] = [1.8, 1.1, 2.6]; // line widths [px]; the last two apply if there is a second world
const LANE = 58; // height of each population's lane [px]
const SPARK = 40; // number of points in a sparkline, evenly spaced in time
const WIDE = 1500; // ticks in a sparkline
export const RECENT = 60; // last ticks over which the trend, births and deaths are taken
const WINDOWS = [["last 500", 500], ["last 2,000", 2000], ["last 10,000", 10000], ["all ticks", Infinity]];

/** @typedef {{key: string, title: string, unit: string, heading?: string}} Chart `heading`: unit in the headings of a file */

/** @type {Chart[]} */
const CHARTS = [
  { key: "n", title: "Populations", unit: "organisms", heading: "organisms" },
  { key: "happiness", title: "Happiness", unit: "mean", heading: "mean happiness" },
  { key: "genes", title: "Genes", unit: "mean" },
  { key: "causes", title: "Deaths", unit: "per tick, by cause", heading: "per tick" },
  { key: "births", title: "Births", unit: "per tick", heading: "per tick" },
  { key: "energy", title: "Energy", unit: "per tick, taken in and burned", heading: "energy per tick" },
];

/** Range and labels of a lane of the chart of populations, from 0 to the highest value. @param {number} at position of the lane, from below @param {number} lanes */
function lane(at, lanes) {
  const range = (/** @type {unknown} */ _, /** @type {number} */ _low, /** @type {number} */ high) => {
    const most = high > 0 ? high * (lanes > 1 ? 1.25 : 1.06) : 1;
    return /** @type {[number, number]} */ ([-at * most, (lanes - at) * most]);
  };
  const splits = (/** @type {unknown} */ _, /** @type {number} */ _i, /** @type {number} */ _low, /** @type {number} */ top) => [0, round((0.9 * top) / (lanes - at))];
  return { range, splits };
}

export class Charts {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {(name: string) => string} colourOf
   * @param {(tick: number) => void} seek
   * @param {import("./figures.js").Scene} scene
   */
  constructor(hello, colourOf, seek, scene) {
    this.hello = hello;
    this.colourOf = colourOf;
    this.seek = seek;
    /** @type {[number, number] | null} ticks selected by dragging */
    this.zoom = null;
    const plants = hello.species.filter(({ moves }) => !moves).map(({ name }) => name);
    this.plants = plants.length < hello.species.length ? plants : [];
    /** @type {import("./other.js").Other | null} curves of a second world */
    this.other = null;
    this.layout = ""; // describes which charts exist
    this.tick = hello.tick;
    /** @type {number[]} */
    this.ticks = [];
    /** @type {Line} */
    this.light = [];
    this.charts = [...CHARTS];
    this.redraw = () => this.draw();
    /** @type {Record<string, Record<string, Line>>} */
    this.lines = { n: {}, happiness: {}, genes: {}, causes: {}, births: {}, energy: {}, flows: {} };
    this.shared = false; // whether energy per food is estimated from numbers eaten
    /** @type {Set<string>} */
    this.hidden = new Set(recalled());
    /** @type {Set<string>} kinds hidden in the legend */
    this.away = new Set();
    this.window = hello.mode === "replay" ? Infinity : 2000;
    this.log = false;
    /** @type {Map<string, {plot: uPlot, values: Map<string, HTMLElement>, signature: string}>} */
    this.plots = new Map();
    this.root = $("charts");
    this.body = h("div");
    this.figures = new Figures(this, scene);
    this.root.replaceChildren(this.tools(), this.figures.flows.root, this.body, this.figures.root);
    this.figures.rebuild();
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
    this.pointed = h("output", { class: "pointed", "aria-label": "Tick under the pointer" });
    this.back = h("button", { type: "button", class: "toggle", text: "zoom out", hidden: true, onclick: () => this.zoomed(null) });
    return h("div", { class: "row tools" }, this.chooser, this.pointed, this.back, choice);
  }

  /** @param {Series} series points, which replace existing points from their first tick onward */
  add(series) {
    const first = series.tick[0];
    if (first === undefined) return;
    if (this.ticks.length && first <= this.ticks[this.ticks.length - 1]) this.cut(first);
    const length = this.ticks.length;
    this.ticks.push(...series.tick);
    append(this.light, series.light, length, series.tick.length);
    const given = grouped(series);
    this.shared ||= series.shared === true;
    for (const name of Object.keys(series.reports ?? {})) {
      if (!(REPORT + name in this.lines)) this.charts.splice(-3, 0, { key: REPORT + name, title: name, unit: "" });
      this.lines[REPORT + name] ??= {};
    }
    for (const key of Object.keys(this.lines)) {
      const names = new Set([...Object.keys(this.lines[key]), ...Object.keys(given[key] ?? {})]);
      for (const name of names) append((this.lines[key][name] ??= []), given[key]?.[name], length, series.tick.length);
    }
    soon(this.redraw);
  }

  /** Deletes the points from this tick onward. @param {number} tick */
  cut(tick) {
    const keep = this.ticks.findIndex((t) => t >= tick);
    for (const line of this.all()) line.length = keep;
  }

  /** All arrays that are parallel to the ticks. @returns {Line[]} */
  all() {
    return [this.ticks, this.light, ...Object.values(this.lines).flatMap((lines) => Object.values(lines))];
  }

  /** Called when time reaches a tick. @param {number} tick */
  at(tick) {
    if (tick === this.tick) return;
    this.tick = tick;
    if (this.hello.mode === "replay") for (const { plot } of this.plots.values()) this.window === Infinity ? plot.redraw(false) : plot.setData(plot.data);
    this.values();
    this.figures.at();
  }

  /** Moves the cursor to a tick in all charts, to show the values there. @param {number} tick */
  point(tick) {
    if (this.window !== Infinity && (this.ticks[this.ticks.length - 1] ?? 0) - tick > this.window) {
      this.window = Infinity;
      if (this.choice) this.choice.selectedIndex = WINDOWS.length - 1;
      this.draw();
    }
    for (const { plot } of this.plots.values()) plot.setCursor({ left: plot.valToPos(tick, "x"), top: 10 });
  }

  /** The causes of death so far, as "deer: eaten by wolf". */
  causes() {
    return Object.keys(this.lines.causes);
  }

  /** First and last tick on the axis. @returns {[number, number]} */
  range() {
    if (this.zoom) return this.zoom;
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

  clear() {
    for (const { plot } of this.plots.values()) plot.destroy();
    this.plots.clear();
    this.body.replaceChildren();
  }

  rebuild() {
    this.clear();
    this.draw();
    this.figures.rebuild();
  }

  /** Shows only these ticks; null: the selected range. @param {[number, number] | null} ticks */
  zoomed(ticks) {
    this.zoom = ticks;
    if (this.back) this.back.hidden = ticks === null;
    this.draw();
  }

  /** The data drawn by the timeline. @returns {import("./lanes.js").Counted} */
  lanes() {
    const deaths = (/** @type {string} */ name) => {
      const lines = Object.entries(this.lines.causes).filter(([cause]) => cause.startsWith(`${name}: `)).map(([, line]) => line);
      return this.ticks.map((_, i) => lines.reduce((sum, line) => sum + (line[i] ?? 0), 0));
    };
    return { ticks: this.ticks, births: this.lines.births, deaths, colourOf: (name) => this.colourOf(name) };
  }

  /** Current data about a kind, for the legend. @param {string} name */
  brief(name) {
    const at = this.ticks.findLastIndex((tick) => tick <= this.tick), now = this.ticks[at] ?? 0;
    const line = this.lines.n[name] ?? [], first = Math.max(this.ticks[0] ?? 0, now - WIDE), points = [];
    for (let k = 0, i = 0, n = Math.min(SPARK, now - first + 1); k < n && at >= 0; k++) {
      while (i < at && this.ticks[i + 1] <= first + ((now - first) * k) / Math.max(1, n - 1)) i++;
      if (line[i] !== null && line[i] !== undefined) points.push(line[i]);
    }
    const deaths = Object.entries(this.lines.causes).filter(([cause]) => cause.startsWith(`${name}: `));
    const born = this.lines.births[name] ?? [];
    const mean = (/** @type {Line} */ values) => {
      let sum = 0, ticks = 0;
      for (let i = at; i >= 0 && this.ticks[i] > now - RECENT; i--) {
        if ((values[i] ?? born[i] ?? null) === null) continue;
        const span = this.ticks[i] - Math.max(this.ticks[i - 1] ?? this.ticks[0] - 1, now - RECENT);
        sum += span * (values[i] ?? 0); // no value if the cause has not occurred yet
        ticks += span;
      }
      return ticks ? sum / ticks : null;
    };
    const causes = deaths.map(([cause, values]) => /** @type {[string, number]} */ ([cause.slice(name.length + 2), mean(values) ?? 0]));
    const then = line[Math.max(0, this.ticks.findLastIndex((tick) => tick <= now - RECENT))];
    return {
      change: then ? (line[at] ?? 0) / then - 1 : line[at] ? 1 : 0,
      causes: causes.filter(([, rate]) => rate > 0).sort(([, a], [, b]) => b - a),
      line: /** @type {number[]} */ (points), births: mean(born),
      deaths: deaths.length ? deaths.reduce((sum, [, values]) => sum + (mean(values) ?? 0), 0) : 0,
    };
  }

  draw() {
    const there = this.charts.filter(({ key }) => key === "n" || Object.values(this.lines[key]).some((line) => line.some((value) => value !== null)));
    const figures = FIGURES.filter(({ key }) => this.figures.has(key));
    if (this.chooser && this.chooser.childElementCount !== there.length + figures.length) {
      this.chooser.replaceChildren(...[...figures.filter(({ key }) => key === "flows"), ...there, ...figures.filter(({ key }) => key !== "flows")].map(({ key, title }) => this.toggle(key, title)));
    }
    const shown = there.filter(({ key }) => !this.hidden.has(key));
    const layout = shown.map(({ key }) => key).join();
    if (layout !== this.layout) this.clear();
    this.layout = layout;
    for (const chart of shown) {
      const { key } = chart;
      const names = this.names(key);
      const old = this.plots.get(key);
      const signature = [...names, this.other?.at].join();
      if (old?.signature !== signature) {
        old?.plot.root.closest(".chart")?.remove();
        old?.plot.destroy();
        this.plots.set(key, { ...this.build(chart, names, chart === shown[shown.length - 1]), signature });
      }
      const made = this.plots.get(key);
      made?.plot.setData(/** @type {any} */ ([this.ticks, ...names.map((name) => this.lines[key][name]), ...(this.other?.held(key, names) ?? [])]));
    }
    this.values();
    this.figures.at();
  }

  /** The names of lines that have data. @param {string} key */
  names(key) {
    const plants = key === "causes" || key === "energy" ? this.plants : []; // their curves would dwarf all others
    return Object.keys(this.lines[key]).filter((name) => !plants.includes(name.split(": ")[0]) && !this.away.has(name.split(/[.:]/)[0])).filter((name) => key === "n" || this.lines[key][name].some((value) => value !== null) || this.other?.lines[key]?.[name]);
  }

  /**
   * @param {string} key
   * @param {string} title
   */
  toggle(key, title) {
    const short = title.split(",")[0];
    const button = h("button", { type: "button", class: "toggle", "aria-pressed": String(!this.hidden.has(key)), text: short, onclick: () => {
      if (!this.hidden.delete(key)) this.hidden.add(key);
      remember([...this.hidden]);
      button.setAttribute("aria-pressed", String(!this.hidden.has(key)));
      this.rebuild();
    } });
    return button;
  }

  /**
   * @param {Chart} chart
   * @param {string[]} names
   * @param {boolean} lowest whether this is the bottom chart
   */
  build({ key, title, unit, heading }, names, lowest) {
    const hues = genes(isDark());
    const colours = names.map((name, i) => (key === "genes" ? hues[i % hues.length] : name ? this.colourOf(name.split(": ")[0]) : css("--ink")));
    const dashes = names.map((_, i) => (key === "genes" ? DASHES[Math.floor(i / hues.length) % DASHES.length] : DASHES[i % (key === "energy" ? 2 : 3)]));
    /** @type {Map<string, HTMLElement>} */
    const values = new Map();
    const head = h("div", { class: "chart-head" }, h("h2", { text: title }), unit && h("span", { class: "unit", text: unit }));
    names.forEach((name, i) => {
      const value = h("b", { text: "–" });
      values.set(name, value);
      head.append(h("span", { class: "key" }, stroke(colours[i], dashes[i]), name || "the world", " ", value));
    });
    head.append(h("span", { class: "grow" }), saves(title, () => table(this.ticks, names, this.lines[key], (name) => this.heading(key, title, name, heading)), () => ({
      unit, body: plotted(plot, heading ?? unit, colours, [(u) => nights(u, this.ticks, this.light), (u) => this.cursor(u)]),
      legend: [...names.map((name, i) => ({ name: name || "the world", mark: stroke(colours[i], dashes[i]) })), ...(this.other?.items() ?? [])],
    }), () => (this.thinned() ? "-thinned" : "")));
    if (key === "n" && this.logarithmic) head.append(this.logarithmic);
    const place = h("div", { class: "chart" }, head);
    const after = this.charts.slice(this.charts.findIndex((chart) => chart.key === key) + 1).map((chart) => this.plots.get(chart.key)).find(Boolean);
    this.body.insertBefore(place, after?.plot.root.closest(".chart") ?? null);
    const axis = { stroke: css("--soft"), font: "11px " + css("--font"), ticks: { show: false }, grid: { stroke: css("--line"), width: 1 } };
    const shared = key !== "n" || this.log || names.length < 2; // otherwise each population has a lane with its own scale
    const scaleOf = (/** @type {number} */ i) => (shared ? "y" : `y${i}`);
    const lanes = shared ? [] : names.map((_, i) => lane(names.length - 1 - i, names.length));
    const plot = new uPlot({
      width: Math.max(200, this.body.clientWidth), height: (shared ? (key === "n" ? 148 : 112) : LANE * names.length + 12) + (lowest ? 32 : 0),
      padding: [6, 8, 0, 0],
      cursor: { sync: { key: "ecs" }, y: false, points: { size: 6 }, drag: { x: true, y: false, setScale: false, dist: 4 } },
      legend: { show: false },
      scales: {
        x: { time: false, range: () => this.range() },
        y: { distr: key === "n" && this.log ? 3 : 1, range: key === "n" && !this.log ? lane(0, 1).range : undefined },
        ...Object.fromEntries(lanes.map(({ range }, i) => [scaleOf(i), { range }])),
      },
      axes: [
        { ...axis, size: lowest ? 38 : 6, space: 70, label: lowest ? "tick" : "", labelSize: lowest ? 14 : 0, labelFont: axis.font, values: (_, splits) => splits.map((v) => (lowest ? number(v) : "")) },
        ...(shared ? [{}] : lanes.map(({ splits }, i) => ({ scale: scaleOf(i), splits, size: i + 1 < names.length ? 0 : 46 }))).map((own) => ({
          ...axis, size: 46, space: 30, values: (/** @type {unknown} */ _, /** @type {(number | null)[]} */ splits) => splits.map((v) => (v === null ? "" : number(v))), ...own,
        })),
      ],
      series: [{}, ...(this.other ? [THIN, THICK] : [PLAIN]).flatMap((width) => names.map((name, i) => ({ label: name, scale: scaleOf(i), stroke: colours[i], width, alpha: width === THIN ? 0.6 : 1, dash: dashes[i], points: { show: false }, spanGaps: true })))],
      hooks: { drawClear: [(u) => nights(u, this.ticks, this.light)], draw: [(u) => this.cursor(u), (u) => this.other?.mark(u)], setCursor: [() => this.values()], setSelect: [(u) => this.dragged(u)] },
    }, [[]], place);
    plot.over.addEventListener("click", () => this.clicked(plot));
    return { plot, values };
  }

  /** Whether some ticks have no point. */
  thinned() {
    return this.ticks.some((tick, i) => i > 0 && tick > this.ticks[i - 1] + 1);
  }

  /** The unit of a line in a file; genes and reporters have the unit of their values, or none. @param {string} key @param {string} title @param {string} name @param {string} [heading] */
  heading(key, title, name, heading) {
    if (heading?.endsWith("per tick") && this.thinned()) return `${heading} since the previous row`;
    if (key !== "genes") return heading ?? title.match(/\[(.+)\]$/)?.[1] ?? title;
    const [species, gene] = [name.slice(0, name.indexOf(".")), name.slice(name.indexOf(".") + 1)];
    const unit = this.hello.species.find((kind) => kind.name === species)?.units?.[gene];
    return unit && unit !== "1" ? `mean, ${unit}` : "mean";
  }

  /** Zooms to a range selected by dragging. @param {uPlot} plot */
  dragged(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    this.moved = performance.now();
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoomed([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
  }

  /** Goes to the clicked tick. @param {uPlot} plot */
  clicked(plot) {
    if (this.hello.mode === "replay" && performance.now() - (this.moved ?? 0) > 300) this.seek(Math.round(plot.posToVal(plot.cursor.left ?? 0, "x")));
  }

  /** Updates the values next to the names, at the pointer or, without one, at the current tick. */
  values() {
    const idx = [...this.plots.values()][0]?.plot.cursor.idx;
    if (this.pointed) this.pointed.textContent = idx == null ? "" : `tick ${number(this.ticks[idx])}`;
    for (const [key, { plot, values }] of this.plots) {
      let at = plot.cursor.idx ?? this.ticks.length - 1;
      if (plot.cursor.idx === null && this.hello.mode === "replay") at = this.ticks.findLastIndex((tick) => tick <= this.tick);
      for (const [name, element] of values) {
        const text = number(this.lines[key][name]?.[at]) + (this.other ? ` | ${number(this.other.value(key, name, this.ticks[at]))}` : "");
        if (element.textContent !== text) element.textContent = text;
      }
    }
  }

  /** Draws the current tick of a replay. @param {uPlot} u */
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
