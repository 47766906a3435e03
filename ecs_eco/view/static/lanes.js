// Lanes of the timeline: births above and deaths below, for each species or, if there is too little space, for all species together.

import { h } from "./dom.js";
import { css } from "./theme.js";

/** @typedef {import("./charts.js").Line} Line */
/** @typedef {{ticks: number[], births: Record<string, Line>, deaths: (name: string) => Line, colourOf: (name: string) => string}} Counted counts from the charts */
/** @typedef {(tick: number) => number} Place horizontal position of a tick [px] */

export class Lanes {
  /** @param {Counted} counted */
  constructor(counted) {
    this.counted = counted;
    this.state = ""; // describes what the picture shows
    /** @type {HTMLCanvasElement | null} */
    this.picture = null;
  }

  /** Whether there is anything to draw. */
  get any() {
    return this.counted.ticks.length > 1;
  }

  /**
   * Draws all lanes, repainting only when something has changed.
   * @param {Place} at
   * @param {string[]} rows species
   * @param {{top: number, low: number, left: number, right: number}} box [px]
   * @param {{width: number, height: number}} canvas [pixels]
   * @param {number} ratio
   */
  painted(at, rows, { top, low, left, right }, { width, height }, ratio) {
    const { ticks, colourOf } = this.counted;
    const state = [ticks.length, ticks[ticks.length - 1], at(0), at(1000), top, low, width, height, css("--plus"), ...rows.map(colourOf)].join();
    if (state === this.state && this.picture) return this.picture;
    this.state = state;
    this.picture = h("canvas", { width, height });
    const pen = /** @type {CanvasRenderingContext2D} */ (this.picture.getContext("2d"));
    pen.scale(ratio, ratio);
    rows.forEach((name, k) => this.lane(pen, at, name, { top: top + ((low - top) * k) / rows.length, high: (low - top) / rows.length, left, right }));
    return this.picture;
  }

  /**
   * Draws births and deaths of a species, each on its own scale.
   * @param {CanvasRenderingContext2D} pen
   * @param {Place} at
   * @param {string} name
   * @param {{top: number, high: number, left: number, right: number}} box [px]
   */
  lane(pen, at, name, { top, high, left, right }) {
    const { ticks } = this.counted;
    const middle = top + high / 2;
    const lines = [this.counted.births[name] ?? [], this.counted.deaths(name)];
    const end = Math.min(Math.floor(right), Math.ceil(at(ticks[ticks.length - 1]))) + 1;
    const sums = lines.map((line) => byPixel(ticks, line, at, Math.max(0, left), end));
    const most = Math.max(1e-9, ...sums[0], ...sums[1]);
    sums.forEach((sum, down) => {
      pen.fillStyle = css(down ? "--minus" : "--plus");
      pen.globalAlpha = 0.75;
      sum.forEach((value, x) => value && pen.fillRect(x, middle, 1, ((down ? 1 : -1) * (high / 2 - 1) * value) / most));
      pen.globalAlpha = 1;
    });
    pen.fillStyle = this.counted.colourOf(name);
    pen.fillRect(0, top + 1.5, 3, high - 3);
  }
}

/**
 * The mean rate in each column of pixels, from rates that each apply to the ticks since the previous point.
 * @param {number[]} ticks
 * @param {Line} line rate at each tick; the first is unknown
 * @param {Place} at
 * @param {number} left first column
 * @param {number} end column after the last
 */
export function byPixel(ticks, line, at, left, end) {
  const events = new Float64Array(Math.max(0, end)), covered = new Float64Array(Math.max(0, end));
  for (let i = 1; i < ticks.length; i++) {
    const span = ticks[i] - ticks[i - 1], from = Math.round(at(ticks[i - 1])), to = Math.max(from + 1, Math.round(at(ticks[i])));
    for (let x = Math.max(left, from); x < Math.min(end, to); x++) {
      events[x] += (line[i] ?? 0) * span;
      covered[x] += span;
    }
  }
  return events.map((value, x) => value / (covered[x] || 1));
}

/**
 * Draws births or deaths of all species, in bins over the whole run.
 * @param {CanvasRenderingContext2D} pen
 * @param {number[]} bins
 * @param {(bin: number) => number} at left edge of a bin [px]
 * @param {number} base
 * @param {number} reach height of the fullest bin
 * @param {string} colour
 */
export function density(pen, bins, at, base, reach, colour) {
  const most = bins.reduce((a, b) => Math.max(a, b), 0);
  if (!most) return;
  pen.fillStyle = colour;
  pen.globalAlpha = 0.55;
  bins.forEach((n, i) => pen.fillRect(at(i), base, Math.max(0.6, at(i + 1) - at(i) - 0.3), (reach * n) / most));
  pen.globalAlpha = 1;
}
