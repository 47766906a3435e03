// Drawings over the scene, on a separate canvas: the field of view of the selected organism, and marks of births and deaths.

import { Vector3 } from "./vendor.js";
import { WORDS } from "./frame.js";
import { round } from "./ground.js";
import { sight } from "./sight.js";
import { css } from "./theme.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{tick: number, kind: "birth" | "death" | "kill", at: Vector3, k: number, by: number}} Mark `k`: its kind */

export const LASTS = 5; // [ticks] how long a mark is shown
const MOST = 300; // maximum number of marks

export class Over {
  /** @param {Stage} stage @param {HTMLCanvasElement} canvas */
  constructor(stage, canvas) {
    this.stage = stage;
    this.canvas = canvas;
    this.pen = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    /** @type {Mark[]} */
    this.marks = [];
    /** @type {import("./protocol.js").Organism | null} */
    this.organism = null;
    this.shown = true; // whether marks are shown
    /** @type {{seen: number, rays: number, drawn: number}} counts of the last drawing, for tests */
    this.drew = { seen: 0, rays: 0, drawn: 0 };
    /** @type {[number, string][]} heights [m] at which light has fallen to the labeled share */
    this.levels = [];
    /** @type {(drawn: number, all: number) => void} called with the number of marks in view and of all marks */
    this.told = () => {};
    this.clear = true;
    this.last = 0; // tick of the last frame
  }

  /** Marks births; called after each frame. @param {number} tick @param {boolean} jump whether time jumped */
  take(tick, jump) {
    const { stage } = this;
    const far = tick - this.last > LASTS; // some of the new organisms may have been born too long ago to be marked
    this.last = tick;
    if (jump) this.marks = this.marks.filter((mark) => mark.tick <= tick);
    this.marks = this.marks.filter((mark) => tick - mark.tick < LASTS).slice(-MOST);
    if (jump || far) return;
    stage.layers.forEach((layer, k) => {
      if (!layer.kind.moves) return;
      for (let row = 0; row < layer.block.n; row++) {
        if (layer.before[4 * row + 3] & 256) this.marks.push({ tick, kind: "birth", at: this.spot(layer, row), k, by: 0 });
      }
    });
  }

  /** @param {import("./layer.js").Layer} layer @param {number} row */
  spot({ block, own }, row) {
    const { size } = this.stage.hello;
    const at = new Vector3(...[0, 1, 2].map((axis) => (block.words[WORDS * row + axis] / 65535) * (size[axis] ?? 0)));
    if (size.length < 3) at.z = this.stage.relief.at(at.x, at.y) + own.radius.value;
    return at;
  }

  /** Marks deaths. @param {number[][]} list tick, species, uid, position, killer */
  fates(list) {
    const { stage } = this;
    for (const [tick, species, , x, y, z, killer] of list) {
      const at = new Vector3(x, y, stage.hello.size.length > 2 ? z : stage.relief.at(x, y));
      this.marks.push({ tick, kind: killer ? "kill" : "death", at, k: species, by: killer });
    }
    stage.dirty = true;
  }

  /** Draws everything; called after each picture of the scene. */
  draw() {
    const { stage, pen, canvas } = this;
    const ratio = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [stage.canvas.clientWidth, stage.canvas.clientHeight];
    const all = this.marks.filter(({ tick }) => stage.tick >= tick && stage.tick - tick < LASTS);
    const marks = this.shown ? all : [];
    const found = stage.selected === null ? null : stage.find(stage.selected);
    const empty = !found && !marks.length && stage.hello.size.length < 3;
    if (empty && this.clear) return this.told(0, all.length);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    this.clear = empty;
    pen.lineJoin = pen.lineCap = "round";
    pen.font = `11px ${css("--font")}`;
    this.drew = { seen: 0, rays: 0, drawn: 0 };
    if (stage.hello.size.length > 2) this.depths();
    if (found) Object.assign(this.drew, sight(this, found, this.organism));
    for (const mark of marks) this.mark(mark, width, height);
    this.told(this.drew.drawn, all.length);
  }

  /** Draws a line with an outline that makes it visible on any background. @param {({x: number, y: number} | null)[]} points @param {string} colour @param {number} width @param {number[]} [dash] @param {number} [alpha] */
  line(points, colour, width, dash = [], alpha = 1) {
    const { pen } = this;
    for (const [stroke, wide] of /** @type {[string, number][]} */ ([[css("--card"), width + 2], [colour, width]])) {
      pen.globalAlpha = stroke === colour ? alpha : 0.55 * alpha;
      pen.strokeStyle = stroke;
      pen.lineWidth = wide;
      pen.setLineDash(dash);
      pen.beginPath();
      let on = false;
      for (const at of points) {
        if (at) on ? pen.lineTo(at.x, at.y) : pen.moveTo(at.x, at.y);
        on = Boolean(at);
      }
      pen.stroke();
    }
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  /** Draws text with an outline. @param {string} text @param {number} x @param {number} y @param {string} [colour] */
  words(text, x, y, colour = css("--ink")) {
    const { pen } = this;
    pen.lineWidth = 3.5;
    pen.strokeStyle = css("--card");
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  }

  /** @param {Mark} mark @param {number} width @param {number} height of the stage */
  mark({ tick, kind, at, k, by }, width, height) {
    const age = this.stage.tick - tick, place = this.stage.project(at);
    if (!place || place.x < 0 || place.x > width || place.y < 0 || place.y > height) return;
    this.drew.drawn++;
    const fade = 1 - (0.75 * age) / LASTS;
    const { x, y } = place;
    if (kind === "birth") {
      const r = 6 + 0.6 * age;
      this.line(Array.from({ length: 25 }, (_, i) => ({ x: x + r * Math.cos((i * Math.PI) / 12), y: y + r * Math.sin((i * Math.PI) / 12) })), this.stage.colours[k], 1.3, [], fade);
      return;
    }
    const killer = by ? this.stage.find(by) : null;
    if (killer && age < 4) {
      const from = this.stage.project(this.stage.spot(killer.layer, killer.row, new Vector3()));
      if (from && Math.hypot(from.x - x, from.y - y) < 200) this.line([from, place], css("--minus"), 1.6, [], fade);
    }
    const [r, stroke, wide] = kind === "kill" ? [5, css("--minus"), 2.2] : [4, css("--soft"), 1.6];
    this.line([{ x: x - r, y: y - r }, { x: x + r, y: y + r }], stroke, wide, [], fade);
    this.line([{ x: x - r, y: y + r }, { x: x + r, y: y - r }], stroke, wide, [], fade);
  }

  /** Draws the depth scale along the leftmost edge, and the depths at which light has fallen to labeled shares. */
  depths() {
    const { stage } = this;
    const [x, y, z] = stage.hello.size;
    const edges = [[0, 0], [x, 0], [0, y], [x, y]].map(([a, b]) => ({ a, b, at: stage.project(new Vector3(a, b, z / 2)) })).filter(({ at }) => at);
    if (!edges.length) return;
    const { a, b } = edges.reduce((left, edge) => ((edge.at?.x ?? 0) < (left.at?.x ?? 0) ? edge : left));
    const step = round(z / 3);
    this.pen.textAlign = "right";
    this.pen.textBaseline = "middle";
    for (let depth = 0; depth <= z + 1e-6; depth += step) {
      const at = stage.project(new Vector3(a, b, z - depth));
      if (!at) continue;
      this.line([{ x: at.x - 5, y: at.y }, at], css("--soft"), 1.4);
      this.words(`${depth ? "−" : ""}${depth} m`, at.x - 8, at.y);
    }
    this.pen.textAlign = "left";
    for (const [height, text] of this.levels) {
      const ring = [[0, 0], [x, 0], [x, y], [0, y], [0, 0]].map(([u, v]) => stage.project(new Vector3(u, v, height)));
      this.line(ring, "#f0b429", 1.4, [4, 4], 0.9);
      const right = ring.reduce((best, at) => (at && at.x > (best?.x ?? -1) ? at : best), /** @type {{x: number, y: number} | null} */ (null));
      if (right) this.words(text, right.x + 6, right.y);
    }
    this.pen.textBaseline = "alphabetic";
  }
}
