// The timeline: labelled ticks, a lane for each species with births above and deaths below, and diamonds for what happened. It is dragged.

import { $, h, number } from "./dom.js";
import { round } from "./ground.js";
import { css, onTheme } from "./theme.js";

/** @typedef {import("./charts.js").Line} Line */
/** @typedef {{ticks: number[], births: Record<string, Line>, deaths: (name: string) => Line, colourOf: (name: string) => string}} Lanes what was counted, from the charts */

const EDGE = 4; // [px] left and right of the axis
const AXIS = 15; // [px] for labelled ticks
const ROOMY = 60; // [px] of height from which there are lanes and labels
const LANES = 5;
const NAMED = 13; // [px] for names of diamonds

export class Timeline {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {(tick: number) => void} seek
   * @param {Lanes} lanes
   */
  constructor(hello, seek, lanes) {
    this.hello = hello;
    this.lanes = lanes;
    this.tick = hello.tick;
    /** @type {import("./protocol.js").Marks} */
    this.marks = { kind: "marks", births: [], deaths: [], interventions: [] };
    /** @type {import("./protocol.js").Entry[]} */
    this.entries = [];
    this.held = false;
    this.state = ""; // what the painted lanes show
    /** @type {HTMLCanvasElement | null} */
    this.paint = null;
    this.canvas = h("canvas", { "aria-hidden": "true" });
    this.input = h("input", { type: "range", step: 1, min: hello.first, max: this.last(), value: hello.tick, "aria-label": "Time, in ticks" });
    const replay = hello.mode === "replay";
    let waiting = 0;
    const go = () => {
      clearTimeout(waiting);
      this.tick = Math.min(Number(this.input.value), replay ? Infinity : this.newest);
      seek(this.tick);
    };
    this.newest = hello.tick; // of a living world: where it is
    this.input.addEventListener("input", () => {
      this.held = true;
      this.tick = Number(this.input.value);
      this.draw();
      clearTimeout(waiting);
      if (replay) waiting = setTimeout(go, 60); // a living world goes back once, when the slider is let go
    });
    this.input.addEventListener("change", () => {
      go();
      setTimeout(() => (this.held = false), 300);
    });
    this.input.addEventListener("pointermove", (event) => this.hover(event));
    const root = $("timeline");
    root.replaceChildren(this.canvas, ...(replay || hello.rewinds ? [this.input] : []));
    new ResizeObserver(() => this.draw()).observe(root);
    onTheme(() => this.draw());
  }

  last() {
    return this.hello.last ?? Math.max(this.hello.first + 100, Math.ceil((Math.max(this.tick, this.newest ?? 0) * 1.15) / 500) * 500);
  }

  /** @param {import("./protocol.js").Marks} marks */
  mark(marks) {
    this.marks = { ...this.marks, ...marks };
    this.draw();
  }

  /** @param {import("./protocol.js").Entry[]} entries of the story */
  tell(entries) {
    this.entries = entries;
    this.draw();
  }

  /** @param {number} tick */
  at(tick) {
    if (this.hello.mode === "live") this.newest = tick;
    if (this.held || tick === this.tick) return;
    this.tick = tick;
    this.input.max = String(this.last());
    this.input.value = String(tick);
    this.input.setAttribute("aria-valuetext", `tick ${tick}`);
    this.draw();
  }

  /** What happened, oldest first: interventions, and entries of the story. */
  happened() {
    const told = this.entries.map(({ tick, text, species, kind }) => ({ tick, text, name: kind === "birth" ? `first young of ${species}` : `${species} ${kind}`, species }));
    const done = (this.marks.interventions ?? []).map(({ tick, text }) => ({ tick, text, name: text, species: "" }));
    return [...told, ...done].sort((a, b) => a.tick - b.tick);
  }

  /** Tells what happened near the pointer. @param {PointerEvent} event */
  hover(event) {
    const { left, width } = this.input.getBoundingClientRect();
    const per = (this.last() - this.hello.first) / width;
    const tick = this.hello.first + (event.clientX - left) * per;
    const near = this.happened().filter((mark) => Math.abs(mark.tick - tick) < 6 * per);
    this.input.title = near.length ? near.map((mark) => `${number(mark.tick)}: ${mark.text}`).join("\n") : `tick ${number(Math.round(tick))}`;
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const pen = this.canvas.getContext("2d");
    if (!width || !pen) return;
    const ratio = devicePixelRatio || 1;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    pen.scale(ratio, ratio);
    const roomy = height >= ROOMY;
    const [top, low] = roomy ? [NAMED + 5, height - AXIS] : [0, height];
    const { first } = this.hello;
    const at = (/** @type {number} */ tick) => EDGE + ((tick - first) / Math.max(1, this.last() - first)) * (width - 2 * EDGE);
    if (roomy) this.axis(pen, at, low, width);
    const rows = roomy ? this.hello.species.slice(0, LANES).map(({ name }) => name) : [];
    if (rows.length && this.lanes.ticks.length > 1) pen.drawImage(this.painted(at, rows, top, low, ratio), 0, 0, width, height);
    else {
      const middle = (top + low) / 2;
      this.density(pen, this.marks.births ?? [], middle - 3, -(middle - top - 7), css("--plus"), width);
      this.density(pen, this.marks.deaths ?? [], middle + 3, low - middle - 7, css("--minus"), width);
    }
    const line = roomy ? top - 4 : Math.round(height / 2) - 2;
    pen.fillStyle = css("--line");
    pen.fillRect(EDGE, line, width - 2 * EDGE, 3);
    pen.fillStyle = css("--accent");
    pen.fillRect(EDGE, line, at(this.tick) - EDGE, 3);
    if (roomy) pen.fillRect(at(this.tick) - 0.75, line, 1.5, low - line);
    this.diamonds(pen, at, line + 1.5, roomy, width);
    pen.beginPath();
    pen.arc(at(this.tick), line + 1.5, 6, 0, 7);
    pen.fillStyle = css("--accent");
    pen.strokeStyle = css("--card");
    pen.lineWidth = 2;
    pen.fill();
    pen.stroke();
  }

  /**
   * All lanes, painted anew only where something of them has changed.
   * @param {(tick: number) => number} at
   * @param {string[]} rows
   * @param {number} top
   * @param {number} low
   * @param {number} ratio
   */
  painted(at, rows, top, low, ratio) {
    const { ticks, colourOf } = this.lanes;
    const { width, height } = this.canvas;
    const state = [ticks.length, ticks[ticks.length - 1], this.last(), width, height, css("--plus"), ...rows.map(colourOf)].join();
    if (state === this.state && this.paint) return this.paint;
    this.state = state;
    this.paint = h("canvas", { width, height });
    const pen = /** @type {CanvasRenderingContext2D} */ (this.paint.getContext("2d"));
    pen.scale(ratio, ratio);
    rows.forEach((name, k) => this.lane(pen, at, name, top + ((low - top) * k) / rows.length, (low - top) / rows.length));
    return this.paint;
  }

  /**
   * Ticks with their numbers.
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {number} low
   * @param {number} width
   */
  axis(pen, at, low, width) {
    const { first } = this.hello;
    const step = Math.max(1, round(((this.last() - first) / width) * 100));
    pen.font = `11px ${css("--font")}`;
    pen.textBaseline = "bottom";
    for (let tick = Math.ceil(first / step) * step; tick <= this.last(); tick += step) {
      const x = at(tick);
      pen.fillStyle = css("--line");
      pen.fillRect(x, NAMED, 1, low - NAMED + 3);
      pen.fillStyle = css("--soft");
      pen.textAlign = x < 16 ? "left" : x > width - 22 ? "right" : "center";
      pen.fillText(number(tick), x, low + AXIS);
    }
  }

  /**
   * Births and deaths of a species, each on its own scale.
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {string} name
   * @param {number} top
   * @param {number} high
   */
  lane(pen, at, name, top, high) {
    const { ticks } = this.lanes;
    const middle = top + high / 2;
    const ups = this.lanes.births[name] ?? [], downs = this.lanes.deaths(name);
    const columns = Math.ceil(at(ticks[ticks.length - 1])) + 1;
    const sums = [ups, downs].map((line) => {
      const sum = new Float64Array(columns), n = new Uint32Array(columns);
      ticks.forEach((tick, i) => {
        const x = Math.min(columns - 1, Math.max(0, Math.round(at(tick))));
        sum[x] += line[i] ?? 0;
        n[x]++;
      });
      let known = 0;
      return sum.map((value, x) => (known = n[x] ? value / n[x] : known)); // a point stands for the ticks up to the next
    });
    const most = Math.max(1e-9, ...sums[0], ...sums[1]);
    sums.forEach((sum, down) => {
      pen.fillStyle = css(down ? "--minus" : "--plus");
      pen.globalAlpha = 0.75;
      sum.forEach((value, x) => value && pen.fillRect(x, middle, 1, ((down ? 1 : -1) * (high / 2 - 1) * Math.sqrt(value)) / Math.sqrt(most)));
    });
    pen.globalAlpha = 1;
    pen.fillStyle = this.lanes.colourOf(name);
    pen.fillRect(0, top + 1.5, 3, high - 3);
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {number} y
   * @param {boolean} named whether there is room for names
   * @param {number} width
   */
  diamonds(pen, at, y, named, width) {
    let free = 0;
    pen.font = `10.5px ${css("--font")}`;
    pen.textBaseline = "bottom";
    pen.textAlign = "left";
    for (const { tick, name, species } of this.happened()) {
      const x = at(tick);
      diamond(pen, x, y, 4, species ? this.lanes.colourOf(species) : css("--ink"), css("--card"));
      const short = name.length > 26 ? `${name.slice(0, 25)}…` : name;
      const wide = pen.measureText(short).width;
      const from = Math.min(x - 3, width - wide);
      if (!named || from < free) continue;
      free = from + wide + 8;
      pen.fillStyle = css("--soft");
      pen.fillText(short, from, NAMED - 1);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {number[]} bins
   * @param {number} base
   * @param {number} reach height of the fullest bin
   * @param {string} colour
   * @param {number} width
   */
  density(pen, bins, base, reach, colour, width) {
    const most = bins.reduce((a, b) => Math.max(a, b), 0);
    if (!most) return;
    pen.fillStyle = colour;
    pen.globalAlpha = 0.55;
    const each = (width - 8) / bins.length;
    bins.forEach((n, i) => pen.fillRect(4 + i * each, base, Math.max(0.6, each - 0.3), reach * Math.sqrt(n / most)));
    pen.globalAlpha = 1;
  }
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {number} x
 * @param {number} y
 * @param {number} r
 * @param {string} fill
 * @param {string} rim
 */
function diamond(pen, x, y, r, fill, rim) {
  pen.beginPath();
  pen.moveTo(x, y - r);
  pen.lineTo(x + r, y);
  pen.lineTo(x, y + r);
  pen.lineTo(x - r, y);
  pen.closePath();
  pen.fillStyle = fill;
  pen.strokeStyle = rim;
  pen.lineWidth = 1.5;
  pen.fill();
  pen.stroke();
}
