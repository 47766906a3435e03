// The timeline: where the run is, births above and deaths below, interventions as marks; in replay it is scrubbed.

import { $, h, number } from "./dom.js";
import { css, onTheme } from "./theme.js";

export class Timeline {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {(tick: number) => void} seek
   */
  constructor(hello, seek) {
    this.hello = hello;
    this.tick = hello.tick;
    /** @type {import("./protocol.js").Marks} */
    this.marks = { kind: "marks", births: [], deaths: [], interventions: [] };
    this.held = false;
    this.canvas = h("canvas", { "aria-hidden": "true" });
    this.input = h("input", { type: "range", step: 1, min: hello.first, max: this.last(), value: hello.tick, "aria-label": "Time, in ticks" });
    const replay = hello.mode === "replay";
    this.input.disabled = !replay;
    let waiting = 0;
    this.input.addEventListener("input", () => {
      this.tick = Number(this.input.value);
      this.held = true;
      this.draw();
      clearTimeout(waiting);
      waiting = setTimeout(() => seek(this.tick), 60);
    });
    this.input.addEventListener("change", () => setTimeout(() => (this.held = false), 300));
    this.input.addEventListener("pointermove", (event) => this.hover(event));
    const root = $("timeline");
    root.replaceChildren(this.canvas, ...(replay ? [this.input] : []));
    new ResizeObserver(() => this.draw()).observe(root);
    onTheme(() => this.draw());
  }

  last() {
    return this.hello.last ?? Math.max(this.hello.first + 100, Math.ceil((this.tick * 1.15) / 500) * 500);
  }

  /** @param {import("./protocol.js").Marks} marks */
  mark(marks) {
    this.marks = { ...this.marks, ...marks };
    this.draw();
  }

  /** @param {number} tick */
  at(tick) {
    if (this.held || tick === this.tick) return;
    this.tick = tick;
    this.input.value = String(tick);
    this.input.setAttribute("aria-valuetext", `tick ${tick}`);
    this.draw();
  }

  /** Tells what was done near the pointer. @param {PointerEvent} event */
  hover(event) {
    const { left, width } = this.input.getBoundingClientRect();
    const per = (this.last() - this.hello.first) / width;
    const tick = this.hello.first + (event.clientX - left) * per;
    const near = (this.marks.interventions ?? []).filter((mark) => Math.abs(mark.tick - tick) < 6 * per);
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
    const middle = Math.round(height / 2);
    const { first } = this.hello;
    const at = (/** @type {number} */ tick) => 4 + ((tick - first) / Math.max(1, this.last() - first)) * (width - 8);
    this.density(pen, this.marks.births ?? [], middle - 3, -(middle - 7), css("--plus"), width);
    this.density(pen, this.marks.deaths ?? [], middle + 3, middle - 7, css("--minus"), width);
    pen.fillStyle = css("--line");
    pen.fillRect(4, middle - 2, width - 8, 4);
    pen.fillStyle = css("--accent");
    pen.fillRect(4, middle - 2, at(this.tick) - 4, 4);
    for (const { tick } of this.marks.interventions ?? []) diamond(pen, at(tick), middle, 4.5, css("--ink"), css("--card"));
    pen.fillStyle = css("--soft");
    pen.font = `11px ${css("--font")}`;
    pen.textAlign = "right";
    if (height > 36 && !this.marks.deaths?.length) pen.fillText(this.hello.last === null ? "" : number(this.hello.last), width - 4, height - 4);
    pen.beginPath();
    pen.arc(at(this.tick), middle, 7, 0, 7);
    pen.fillStyle = css("--accent");
    pen.strokeStyle = css("--card");
    pen.lineWidth = 2;
    pen.fill();
    pen.stroke();
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
