// The curves of a second world in the same charts: thick lines, next to the thin lines of the first world.

import { h, number, s } from "./dom.js";
import { soon } from "./pace.js";
import { append, grouped } from "./series.js";
import { css } from "./theme.js";

/** @typedef {(number | null)[]} Line */

export class Other {
  /**
   * @param {import("./charts.js").Charts} charts
   * @param {string[]} names of both worlds
   * @param {number | null} at the tick at which the worlds diverged
   */
  constructor(charts, names, at) {
    this.charts = charts;
    this.at = at;
    /** @type {number[]} */
    this.ticks = [];
    /** @type {Record<string, Record<string, Line>>} */
    this.lines = {};
    /** @type {Int32Array} index into `ticks` for each tick of the charts */
    this.places = new Int32Array(0);
    this.placed = "";
    this.items = () => names.map((name, i) => ({ name, mark: sample(1 + 2 * i) })); // of a legend
    const sample = (/** @type {number} */ width) => s("svg", { viewBox: "0 0 22 8", width: 22, height: 8, "aria-hidden": "true" }, s("line", { x1: 0, x2: 22, y1: 4, y2: 4, stroke: "currentColor", "stroke-width": width }));
    this.note = h("p", { class: "pair-key" }, h("span", {}, sample(1), names[0]), h("span", {}, sample(3), names[1]), at === null ? null : h("span", { text: `¦ tick ${number(at)}` }));
    for (const { name } of charts.hello.species) charts.lines.n[name] ??= []; // the first world's line must come first
    charts.other = this;
    charts.body.before(this.note);
  }

  /** Adds points, which replace existing points from their first tick onward. @param {import("./protocol.js").Series} series */
  add(series) {
    const first = series.tick[0];
    if (first === undefined) return;
    const keep = this.ticks.findIndex((tick) => tick >= first);
    if (keep >= 0) for (const line of [this.ticks, ...Object.values(this.lines).flatMap((lines) => Object.values(lines))]) line.length = Math.min(line.length, keep);
    const length = this.ticks.length;
    this.ticks.push(...series.tick);
    const given = grouped(series);
    for (const key of new Set([...Object.keys(this.lines), ...Object.keys(given)])) {
      const mine = (this.lines[key] ??= {});
      for (const name of new Set([...Object.keys(mine), ...Object.keys(given[key] ?? {})])) {
        append((mine[name] ??= []), given[key]?.[name], length, series.tick.length);
        const theirs = this.charts.lines[key];
        if (theirs && !theirs[name]) theirs[name] = this.charts.ticks.map(() => null); // a cause of death that occurs only here
      }
    }
    this.placed = "";
    soon(this.charts.redraw);
  }

  /** Values of the second world at the ticks of the charts. @param {string} key @param {string[]} names @returns {Line[]} */
  held(key, names) {
    this.place();
    return names.map((name) => {
      const line = this.lines[key]?.[name];
      return line ? Array.from(this.places, (i) => (i < 0 ? null : line[i])) : this.charts.ticks.map(() => null);
    });
  }

  /** Value of the second world at a tick of the charts. @param {string} key @param {string} name @param {number} tick */
  value(key, name, tick) {
    const at = this.ticks.findLastIndex((own) => own <= tick);
    return at < 0 || tick > this.ticks[this.ticks.length - 1] ? null : this.lines[key]?.[name]?.[at];
  }

  place() {
    const { ticks } = this.charts, own = this.ticks;
    const now = [ticks.length, ticks[0], ticks[ticks.length - 1], own.length, own[0], own[own.length - 1]].join();
    if (now === this.placed) return;
    this.placed = now;
    this.places = new Int32Array(ticks.length).fill(-1);
    let i = -1;
    ticks.forEach((tick, k) => {
      while (i + 1 < own.length && own[i + 1] <= tick) i++;
      if (own.length && tick <= own[own.length - 1]) this.places[k] = i;
    });
  }

  /** Marks the tick at which the worlds diverged. @param {import("./vendor.js").uPlot} u */
  mark(u) {
    if (this.at === null) return;
    const x = u.valToPos(this.at, "x", true);
    if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
    u.ctx.save();
    u.ctx.strokeStyle = css("--soft");
    u.ctx.lineWidth = devicePixelRatio;
    u.ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
    u.ctx.beginPath();
    u.ctx.moveTo(x, u.bbox.top);
    u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
    u.ctx.restore();
  }

  close() {
    this.charts.other = null;
    this.note.remove();
    this.charts.rebuild();
  }
}
