// The timeline, with labeled ticks, a lane for each species (births above, deaths below) and diamonds for events. Dragging changes the tick.
// The timeline shows the whole time span or a part of it.

import { bars, heightOf, words } from "./detailed.js";
import { $, h, number } from "./dom.js";
import { round } from "./ground.js";
import { Lanes, density } from "./lanes.js";
import { soon } from "./pace.js";
import { Stretch } from "./stretch.js";
import { css } from "./theme.js";

const EDGE = 4; // [px] margin left and right of the axis
const AXIS = 15; // [px] height of labeled ticks
const ROOMY = 60; // [px] minimum height for lanes and labels
const LEAST = 4; // [px] minimum height of a lane
const NAMED = 13; // [px] height of names above diamonds

export class Timeline {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {(tick: number) => void} seek
   * @param {import("./lanes.js").Counted} counted
   */
  constructor(hello, seek, counted) {
    this.hello = hello;
    this.colourOf = counted.colourOf;
    this.lanes = new Lanes(counted);
    this.tick = hello.tick;
    /** @type {import("./protocol.js").Marks} */
    this.marks = { kind: "marks", births: [], deaths: [], interventions: [] };
    /** @type {import("./protocol.js").Entry[]} */
    this.entries = [];
    this.held = false;
    this.redraw = () => this.draw();
    /** @type {import("./stretch.js").Ends | null} the repeating period */
    this.loop = null;
    this.stretch = new Stretch(() => [hello.first, this.last()], () => this.fit());
    this.canvas = h("canvas", { "aria-hidden": "true" });
    this.input = h("input", { type: "range", step: 1, min: hello.first, max: this.last(), value: hello.tick, "aria-label": "Time, in ticks" });
    const replay = hello.mode === "replay";
    let waiting = 0;
    const go = () => {
      clearTimeout(waiting);
      seek((this.tick = Math.min(Number(this.input.value), replay ? Infinity : this.newest)));
    };
    this.newest = hello.tick; // current tick of a live world
    this.input.addEventListener("input", () => {
      this.held = true;
      this.tick = Number(this.input.value);
      this.draw();
      clearTimeout(waiting);
      if (replay) waiting = setTimeout(go, 60); // a live world goes back only when the slider is released
    });
    this.input.addEventListener("change", () => {
      go();
      setTimeout(() => (this.held = false), 300);
    });
    this.input.addEventListener("pointermove", (event) => this.hover(event));
    const root = $("timeline");
    root.style.setProperty("--lanes", String(hello.species.length));
    this.about = h("span", { id: "timelineAbout", class: "unseen" });
    this.input.setAttribute("aria-describedby", "timelineAbout");
    root.replaceChildren(this.canvas, ...(replay || hello.rewinds ? [this.input] : []), this.about);
    this.stretch.listen(root, (x) => this.tickAt(x));
    new ResizeObserver(() => this.draw()).observe(root);
  }

  last() {
    return this.hello.last ?? Math.max(this.hello.first + 100, Math.ceil((Math.max(this.tick, this.newest ?? 0) * 1.15) / 500) * 500);
  }

  /** @param {import("./protocol.js").Marks} marks */
  mark(marks) {
    this.marks = { ...this.marks, ...marks };
    this.about.textContent = (this.marks.stretches ?? []).map((stretch) => `${words(stretch)}.`).join(" ");
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
    const before = this.tick;
    this.tick = tick;
    this.stretch.follow(before, tick);
    this.fit();
  }

  /** Adapts the slider to the displayed period. */
  fit() {
    const [from, to] = this.stretch.ends;
    Object.assign(this.input, { min: String(from), max: String(to) });
    if (!this.held) this.input.value = String(this.tick);
    this.input.setAttribute("aria-valuetext", `tick ${this.tick}${this.stretch.part ? `, of ${from} to ${to}` : ""}`);
    soon(this.redraw);
  }

  /** The tick at a position in the window. @param {number} x [px] */
  tickAt(x) {
    const { left, width } = this.canvas.getBoundingClientRect();
    const [from, to] = this.stretch.ends;
    return Math.min(to, Math.max(from, from + ((x - left - EDGE) / Math.max(1, width - 2 * EDGE)) * (to - from)));
  }

  /** Events, oldest first: interventions and story entries. */
  happened() {
    const told = this.entries.map(({ tick, text, species, kind }) => ({ tick, text, name: kind === "birth" ? `first births of ${species}` : `${species} ${kind}`, species, kind }));
    const done = (this.marks.interventions ?? []).map(({ tick, text }) => ({ tick, text, name: text, species: "", kind: "act" }));
    return [...told, ...done].sort((a, b) => a.tick - b.tick);
  }

  /** Shows the events near the pointer. @param {PointerEvent} event */
  hover(event) {
    const [from, to] = this.stretch.ends;
    const tick = this.tickAt(event.clientX);
    const near = this.happened().filter((mark) => Math.abs(mark.tick - tick) < (6 * (to - from)) / this.canvas.clientWidth);
    const told = near.length ? near.map((mark) => `${number(mark.tick)}: ${mark.text}`) : [`tick ${number(Math.round(tick))}`];
    const known = (this.marks.stretches ?? []).filter(({ first, last }) => tick >= first && tick <= last).map(words);
    this.input.title = [...told, ...known].join("\n");
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const pen = this.canvas.getContext("2d");
    if (!width || !pen) return;
    const ratio = devicePixelRatio || 1;
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== wide || this.canvas.height !== high) [this.canvas.width, this.canvas.height] = [wide, high];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const roomy = height >= ROOMY;
    const stretches = this.marks.stretches ?? [];
    const [top, bottom] = roomy ? [NAMED + 5, height - AXIS] : [0, height];
    const low = bottom - heightOf(stretches); // lower edge of the lanes
    const [from, to] = this.stretch.ends;
    const at = (/** @type {number} */ tick) => EDGE + ((tick - from) / Math.max(1, to - from)) * (width - 2 * EDGE);
    if (roomy) this.axis(pen, at, bottom, width);
    pen.save();
    pen.beginPath();
    pen.rect(0, 0, width - EDGE + 1, height);
    pen.clip();
    const rows = roomy ? this.hello.species.slice(0, Math.floor((low - top) / LEAST)).map(({ name }) => name) : [];
    if (rows.length && this.lanes.any) pen.drawImage(this.lanes.painted(at, rows, { top, low, left: EDGE, right: width - EDGE }, this.canvas, ratio), 0, 0, width, height);
    else {
      const middle = (top + low) / 2;
      const place = (/** @type {number[]} */ bins) => (/** @type {number} */ i) => at(this.hello.first + (i * (this.last() + 1 - this.hello.first)) / bins.length);
      const { births, deaths } = this.marks;
      if (births) density(pen, births, place(births), middle - 3, -(middle - top - 7), css("--plus"));
      if (deaths) density(pen, deaths, place(deaths), middle + 3, low - middle - 7, css("--minus"));
    }
    bars(pen, at, stretches, bottom);
    if (this.loop) this.band(pen, at, this.loop, top, low, css("--accent"));
    if (this.stretch.choosing) this.band(pen, at, this.stretch.choosing, top, low, css("--ink"));
    pen.restore();
    const line = roomy ? top - 4 : Math.round(low / 2) - 2;
    pen.fillStyle = css("--line");
    pen.fillRect(EDGE, line, width - 2 * EDGE, 3);
    pen.fillStyle = css("--accent");
    const here = at(this.tick), inside = this.tick >= from && this.tick <= to;
    pen.fillRect(EDGE, line, Math.min(width - 2 * EDGE, Math.max(0, here - EDGE)), 3);
    if (roomy && inside) pen.fillRect(here - 0.75, line, 1.5, low - line);
    this.diamonds(pen, at, line + 1.5, roomy, width);
    if (!inside) return;
    pen.beginPath();
    pen.arc(here, line + 1.5, 6, 0, 7);
    pen.fillStyle = css("--accent");
    pen.strokeStyle = css("--card");
    pen.lineWidth = 2;
    pen.fill();
    pen.stroke();
  }

  /**
   * Draws a range of ticks as a band with two edges.
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {import("./stretch.js").Ends} ends
   * @param {number} top
   * @param {number} low
   * @param {string} colour
   */
  band(pen, at, [from, to], top, low, colour) {
    const [left, right] = [at(from), at(to)];
    pen.fillStyle = colour;
    pen.globalAlpha = 0.16;
    pen.fillRect(left, top, right - left, low - top);
    pen.globalAlpha = 1;
    for (const [x, way] of [[left, 1], [right, -1]]) {
      pen.fillRect(x - 1, top, 2, low - top);
      pen.fillRect(way > 0 ? x : x - 5, low - 2, 5, 2);
    }
  }

  /**
   * Draws ticks with their numbers.
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {number} low
   * @param {number} width
   */
  axis(pen, at, low, width) {
    const [from, to] = this.stretch.ends;
    const step = Math.max(1, round(((to - from) / width) * 100));
    pen.font = `11px ${css("--font")}`;
    pen.textBaseline = "bottom";
    for (let tick = Math.ceil(from / step) * step; tick <= to; tick += step) {
      const x = at(tick);
      pen.fillStyle = css("--line");
      pen.fillRect(x, NAMED, 1, low - NAMED + 3);
      pen.fillStyle = css("--soft");
      pen.textAlign = x < 16 ? "left" : x > width - 22 ? "right" : "center";
      pen.fillText(number(tick), x, low + AXIS);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {(tick: number) => number} at
   * @param {number} y
   * @param {boolean} named whether there is space for names
   * @param {number} width
   */
  diamonds(pen, at, y, named, width) {
    pen.font = `10.5px ${css("--font")}`;
    pen.textBaseline = "bottom";
    pen.textAlign = "left";
    const marks = foremost(this.happened().map((mark) => ({ ...mark, x: at(mark.tick) })).filter(({ x }) => x >= 0 && x <= width));
    for (const { x, species } of marks.toReversed()) diamond(pen, x, y, 4, species ? this.colourOf(species) : css("--ink"), css("--card"));
    pen.fillStyle = css(named ? "--soft" : "--ink");
    for (const { text, left } of named ? labels(marks, width, (text) => pen.measureText(text).width) : []) pen.fillText(text, left, NAMED - 1);
  }
}

/** @typedef {{x: number, name: string, kind: string}} Event an event and its position [px] */

/** Events, those first that must not be hidden by others: extinctions. @template {Event} E @param {E[]} events, oldest first */
export const foremost = (events) => [...events.filter(({ kind }) => kind === "extinct"), ...events.filter(({ kind }) => kind !== "extinct")];

/**
 * The names of events that fit in a row without overlap. Extinctions have priority, and share a place if they are close together.
 * @param {Event[]} events foremost first
 * @param {number} width of the row [px]
 * @param {(text: string) => number} measure width of a text [px]
 */
export function labels(events, width, measure) {
  /** @type {{text: string, left: number, right: number, kind: string}[]} */
  const placed = [];
  for (const { x, name, kind } of events) {
    const text = name.length > 34 ? `${name.slice(0, 33)}…` : name;
    const wide = measure(text), left = Math.min(x - 3, width - wide);
    const met = placed.find((one) => left < one.right + 8 && left + wide > one.left - 8);
    if (met && kind === "extinct") {
      met.text = `${met.text.replace(/ extinct$/, "")}, ${text}`;
      met.left = Math.max(0, Math.min(met.left, width - measure(met.text)));
      met.right = met.left + measure(met.text);
    } else if (!met) placed.push({ text, left, right: left + wide, kind });
  }
  return placed;
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
