// Maps laid over the ground: densities of plants or food, computed from the positions in a frame, and fields from the server.

import { BufferAttribute, DataTexture, LinearFilter, Mesh, MeshBasicMaterial, MeshLambertMaterial, NoColorSpace, PlaneGeometry, RGBAFormat, UnsignedByteType } from "./vendor.js";
import { fieldRamp, rampColour, rgb } from "./colours.js";
import { WORDS } from "./frame.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{nx: number, ny: number, cells: Float32Array}} Cells */

const ALONG = 72; // number of cells along the longer side
const PACE = 250; // minimum time between updates [ms]
const SHARE = 0.02; // maximum share of the time spent on updates
const THICK = [0.5, 0.7], WOODEN = 0.8; // maximum opacity of meadows on flat land and on hills, and of woods
const LEAF = [140, 200, 80];
const FIELD = 220; // opacity of a field, out of 255; the same for all values, so that their order shows on any ground

/**
 * The smoothed number of organisms from selected layers in each cell of the ground or, in a volume, of its
 * side.
 * @param {Stage} stage
 * @param {import("./layer.js").Layer[]} layers
 * @param {number} passes of the smoothing
 * @returns {Cells}
 */
export function density(stage, layers, passes = 2) {
  const { size, edges } = stage.hello;
  const up = size.length > 2 ? 2 : 1;
  const longest = Math.max(size[0], size[up]);
  const nx = Math.max(4, Math.round((ALONG * size[0]) / longest)), ny = Math.max(4, Math.round((ALONG * size[up]) / longest));
  let cells = new Float32Array(nx * ny);
  for (const { block } of layers) {
    const { words, n } = block;
    for (let row = 0; row < n; row++) cells[(((words[WORDS * row + up] * ny) / 65536) | 0) * nx + (((words[WORDS * row] * nx) / 65536) | 0)]++;
  }
  for (let pass = 0; pass < passes; pass++) cells = smooth(cells, nx, ny, edges === "torus");
  return { nx, ny, cells };
}

/** @param {Float32Array} cells @param {number} nx @param {number} ny @param {boolean} torus */
function smooth(cells, nx, ny, torus) {
  const out = new Float32Array(cells.length);
  const near = (/** @type {number} */ at, /** @type {number} */ n) => (torus ? (at + n) % n : Math.min(n - 1, Math.max(0, at)));
  for (let y = 0; y < ny; y++)
    for (let x = 0; x < nx; x++) {
      const [w, e, s, n] = [near(x - 1, nx), near(x + 1, nx), near(y - 1, ny) * nx, near(y + 1, ny) * nx];
      const here = y * nx;
      out[here + x] = (4 * cells[here + x] + 2 * (cells[here + w] + cells[here + e] + cells[s + x] + cells[n + x]) + cells[s + w] + cells[s + e] + cells[n + w] + cells[n + e]) / 16;
    }
  return out;
}

/** An image on the ground, or at the back of the water. */
class Sheet {
  /** @param {Stage} stage @param {number} lift height above the ground, in steps */
  constructor(stage, lift) {
    this.stage = stage;
    const lit = lift < 2 && stage.relief.nx; // as the hills below; colors of fields are shown as in their scale
    this.material = new (lit ? MeshLambertMaterial : MeshBasicMaterial)({ transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -lift, polygonOffsetUnits: -lift });
    this.mesh = new Mesh(this.form(), this.material);
    this.mesh.renderOrder = lift / 10 - 1; // after the ground, before plants: sprites have the depth of their centers
    this.mesh.visible = false;
    stage.scene.add(this.mesh);
    /** @type {DataTexture | null} */
    this.texture = null;
  }

  form() {
    const { size } = this.stage.hello;
    const { relief } = this.stage;
    if (size.length > 2) {
      const wall = new PlaneGeometry(size[0], size[2]).rotateX(Math.PI / 2);
      return wall.translate(size[0] / 2, 0.999 * size[1], size[2] / 2);
    }
    const parts = relief.nx ? relief.parts : [1, 1]; // as of the ground, so that it lies close to it
    const ground = new PlaneGeometry(size[0], size[1], parts[0], parts[1]).translate(size[0] / 2, size[1] / 2, 0);
    const at = /** @type {BufferAttribute} */ (ground.getAttribute("position"));
    for (let k = 0; k < at.count; k++) at.setZ(k, relief.at(at.getX(k), at.getY(k)) + (relief.nx ? 0.0002 * Math.max(size[0], size[1]) : 0));
    ground.computeVertexNormals();
    return ground;
  }

  /** @param {Uint8Array} pixels red, green, blue and opacity, from the southwest @param {number} nx @param {number} ny */
  paint(pixels, nx, ny) {
    if (this.texture?.image.width !== nx || this.texture.image.height !== ny) {
      this.texture?.dispose();
      this.texture = new DataTexture(pixels, nx, ny, RGBAFormat, UnsignedByteType, undefined, undefined, undefined, LinearFilter, LinearFilter);
      this.texture.colorSpace = NoColorSpace;
      this.material.map = this.texture;
      this.material.needsUpdate = true;
    } else this.texture.image.data = pixels;
    this.texture.needsUpdate = true;
    this.mesh.visible = true;
    this.stage.dirty = true;
  }
}

/** Makes the ground greener where more plants grow, because a distant meadow looks like an area, not like points. */
export class Meadow {
  /** @param {Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.plants = stage.layers.filter(({ kind }) => kind.sessile && !kind.inanimate);
    this.sheet = stage.hello.size.length > 2 || !this.plants.length ? null : new Sheet(stage, 1);
    this.at = -Infinity;
  }

  /** @param {boolean} [now] whether to draw at once */
  draw(now = false) {
    const time = performance.now();
    if (!this.sheet || (!now && time < this.at)) return;
    this.picture();
    const end = performance.now();
    this.at = end + Math.max(PACE, (end - time) / SHARE);
  }

  picture() {
    if (!this.sheet) return;
    const { stage } = this;
    const shown = this.plants.filter((layer) => layer.shown && layer.block.n && layer.own.byValue.value === 0);
    this.sheet.mesh.visible = shown.length > 0 && !stage.field?.name;
    if (!this.sheet.mesh.visible) return;
    const maps = shown.map((layer) => { // woods shade the ground below their crowns
      const wood = ["tree", "conifer"].includes(layer.kind.build ?? ""), tone = wood ? (stage.dark ? 0.3 : 0.62) : stage.dark ? 0.65 : 1;
      const colour = rgb(stage.colours[stage.layers.indexOf(layer)]).map((part, k) => (tone * (part + 2 * LEAF[k])) / 3);
      const map = density(stage, [layer], wood ? 6 : 3), radius = layer.own.radius.value * (wood ? 3 : 1);
      const cell = (stage.hello.size[0] / map.nx) * (stage.hello.size[1] / map.ny), [sum, squares] = map.cells.reduce(([a, b], n) => [a + n, b + n * n], [0, 0]);
      return { ...map, colour, wood, full: Math.max(squares / sum, (0.015 * cell) / (radius * radius + 0.02)) }; // the density around a plant
    });
    const { nx, ny } = maps[0];
    const pixels = new Uint8Array(4 * nx * ny), thick = THICK[stage.relief.nx ? 1 : 0];
    for (let c = 0; c < nx * ny; c++) {
      let [r, g, b, sum, cover] = [0, 0, 0, 0, 0];
      for (const { cells, colour, wood, full } of maps) {
        const share = Math.min(1, cells[c] / full), weight = wood ? 8 * Math.max(0, share - 0.6) : share;
        [r, g, b] = [r + colour[0] * weight, g + colour[1] * weight, b + colour[2] * weight];
        [sum, cover] = [sum + weight, Math.max(cover, wood ? WOODEN * Math.min(1, weight) : thick * Math.sqrt(share))];
      }
      if (sum) pixels.set([r / sum, g / sum, b / sum, 255 * cover], 4 * c);
    }
    this.sheet.paint(pixels, nx, ny);
  }
}

/** A selected field, such as a smell, light or food, with its values colored by a ramp. */
export class FieldMap {
  /** @param {Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.sheet = new Sheet(stage, 2);
    this.name = "";
    /** @type {import("./protocol.js").FieldMessage | null} */
    this.message = null;
    this.at = -Infinity;
    this.again = () => {}; // draws the same values in the colors of another theme
  }

  /** @param {string} name "" for none @param {string[]} foods kinds whose density is shown; empty for a field from the server */
  choose(name, foods) {
    this.name = name;
    this.message = null;
    this.again = () => {};
    this.foods = this.stage.layers.filter(({ kind }) => foods.includes(kind.name));
    this.sheet.mesh.visible = false;
    this.stage.dirty = true;
    this.at = -Infinity;
    this.stage.meadow.draw(true);
    this.frame();
  }

  /** Called after a frame: updates the density of food. */
  frame() {
    if (!this.foods?.length || performance.now() - this.at < PACE) return;
    this.at = performance.now();
    const { nx, ny, cells } = density(this.stage, this.foods);
    const most = cells.reduce((a, b) => Math.max(a, b), 0);
    this.paint(Uint8Array.from(cells, (value) => Math.round((255 * value) / (most || 1))), nx, ny);
  }

  /** @param {import("./protocol.js").FieldMessage} message */
  take(message) {
    if (message.name !== this.name) return false;
    this.message = message;
    const values = Uint8Array.from(atob(message.values), (letter) => letter.charCodeAt(0));
    this.paint(values, message.nx, message.ny);
    return true;
  }

  /** @param {Uint8Array} values @param {number} nx @param {number} ny */
  paint(values, nx, ny) {
    this.again = () => this.paint(values, nx, ny);
    const ramp = fieldRamp(this.stage.dark), wide = Math.max(2, nx); // stretches a single column of depths across the width of the water
    const pixels = new Uint8Array(4 * wide * ny);
    for (let c = 0; c < wide * ny; c++) {
      const value = nx === 1 ? values[Math.floor(c / wide)] : values[c];
      pixels.set([...rampColour(ramp, value / 255), FIELD], 4 * c);
    }
    this.sheet.paint(pixels, wide, ny);
  }

  /** Heights [m] at which light has fallen to 1/2, 1/10 and 1/100. @returns {[number, string][]} */
  levels() {
    const { message } = this;
    if (this.name !== "light" || !message || message.nx !== 1) return [];
    const values = Uint8Array.from(atob(message.values), (letter) => letter.charCodeAt(0));
    const light = Array.from(values, (value) => message.low + ((message.high - message.low) * value) / 255);
    const surface = light[light.length - 1];
    const found = [];
    for (const share of [0.5, 0.1, 0.01]) {
      const row = light.findIndex((value) => value >= share * surface);
      if (surface > 0 && row > 0) found.push(/** @type {[number, string]} */ ([((row + 0.5) / light.length) * this.stage.hello.size[2], `${100 * share}% of the light`]));
    }
    return found;
  }
}
