// The scene: receives frames, draws smooth motion between them, and returns the screen positions of organisms.

import {
  AmbientLight, ColorManagement, DirectionalLight, Group, LinearSRGBColorSpace, Scene, Vector2, Vector3, WebGLRenderer,
} from "./vendor.js";
import { legible, rampOf, rampTexture, rgb, safe } from "./colours.js";
import { Eye } from "./eye.js";
import { WORDS, decode } from "./frame.js";
import { Ground, Relief } from "./ground.js";
import { Layer } from "./layer.js";
import { kindsOf } from "./marks.js";
import { FieldMap, Meadow } from "./meadow.js";
import { clear, fadeable } from "./occlusion.js";
import { Over } from "./over.js";
import { onFrames } from "./pace.js";
import { Trail } from "./trail.js";

/** @typedef {import("./protocol.js").Hello} Hello */

const JUMP = 200; // [ticks] no motion is drawn between frames farther apart than this

ColorManagement.enabled = false; // colors are shown as written

export class Stage {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Hello} hello
   * @param {HTMLCanvasElement} over the overlay
   */
  constructor(canvas, hello, over) {
    this.canvas = canvas;
    this.hello = hello;
    /** @type {Stage | null} the stage of a second world side by side */
    this.peer = null;
    this.kinds = kindsOf(hello);
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "low-power" });
    Object.assign(this.renderer, { outputColorSpace: LinearSRGBColorSpace }).setClearColor(0, 0);
    this.scene = new Scene();
    this.relief = new Relief(hello);
    const largest = Math.max(0, ...this.kinds.map(({ moves, radius }) => (moves ? radius : 0)));
    this.ground = new Ground(hello, this.relief, largest);
    const top = hello.size.length > 2 ? hello.size[2] : Math.max(this.relief.highest, 0);
    this.eye = new Eye(canvas, hello.size, [Math.min(0, this.relief.lowest), top], largest);
    this.sun = new DirectionalLight(0xffffff, 2.2);
    this.sky = new AmbientLight(0xffffff, 1.6);
    const group = new Group();
    this.scene.add(this.ground.group, this.sun, this.sky, group);
    const torus = hello.edges === "torus" ? 1 : 0;
    this.ramps = { sequential: rampTexture("sequential"), diverging: rampTexture("diverging"), families: rampTexture("families"), kin: rampTexture("kin") };
    this.shared = {
      size: { value: new Vector3(hello.size[0], hello.size[1], hello.size[2] ?? 0) },
      wrap: { value: new Vector3(torus, torus, 0) },
      alpha: { value: 1 },
      lens: { value: 500 },
      day: { value: 1 },
      murk: { value: this.ground.murk }, ...this.ground.waters,
      clear: { value: [0, 0, 0, 0] }, // where elements in front of the followed organism fade
      followed: { value: [0, 0, 0, 0] }, // its position [m]; 1 if an organism is followed
      sun: { value: new Vector3(0.3, -0.4, 0.86) },
      mute: { value: [0.6, 0.63, 0.65] },
      ramp: { value: this.ramps.sequential }, edge: { value: [0.1, 0.1, 0.1] }, // edge color of bodies
      relief: { value: this.relief.texture },
      cells: { value: new Vector2(this.relief.nx, this.relief.ny) },
    };
    fadeable(this.ground.stone, this.shared);
    this.layers = this.kinds.map((kind) => new Layer(kind, group, this.shared));
    this.colours = this.kinds.map((kind) => kind.color);
    this.frames = 0;
    this.tick = hello.tick;
    this.end = 0; // byte offset of the frame's end in the last message
    this.light = 1;
    this.elevation = 1;
    this.arrived = 0;
    this.interval = 50; // [ms] between frames
    this.decodeMs = 0;
    this.renderMs = 0;
    this.renders = 0;
    this.jump = true;
    this.dark = false;
    /** @type {number | null} */
    this.selected = null;
    this.trail = new Trail(this);
    this.over = new Over(this, over);
    this.meadow = new Meadow(this);
    this.field = new FieldMap(this);
    this.dirty = true;
    this.onrender = () => {};
    this.onlight = () => {};
    this.eye.controls.addEventListener("change", () => (this.dirty = true));
    this.sized = new ResizeObserver(() => this.resize());
    this.sized.observe(canvas);
    this.resize();
    this.halt = onFrames((now) => this.draw(now));
  }

  /**
   * Reads a binary frame; returns its number.
   * @param {ArrayBuffer} buffer
   * @param {number} [from] offset of the frame's first byte
   */
  take(buffer, from = 0) {
    const start = performance.now();
    const frame = decode(buffer, from);
    this.end = frame.end;
    const jump = this.jump || frame.tick < this.tick || frame.tick - this.tick > JUMP;
    const share = this.share(start);
    const same = frame.tick === this.tick && !jump;
    if (!same) this.interval = Math.min(1000, Math.max(30, 0.7 * this.interval + 0.3 * (start - this.arrived)));
    this.layers.forEach((layer, k) => frame.blocks[k] && layer.take(frame.blocks[k], share, jump));
    this.arrived = start;
    this.jump = false;
    this.tick = frame.tick;
    this.frames++;
    if (!same) this.over.take(frame.tick, jump);
    this.meadow.draw(jump);
    this.field.frame();
    if (Math.abs(frame.light - this.light) > 0.002 || Math.abs(frame.elevation - this.elevation) > 0.002) this.shine(frame.light, frame.elevation);
    this.dirty = true;
    this.decodeMs += (performance.now() - start - this.decodeMs) * (this.frames < 10 ? 1 : 0.1);
    return frame.frame;
  }

  /** The progress of the motion from the last frame to this one. @param {number} now [ms] */
  share(now) {
    return Math.min(1, (now - this.arrived) / this.interval);
  }

  /**
   * Sets the current light.
   * @param {number} light 0 … 1
   * @param {number} elevation of the sun [rad]
   */
  shine(light, elevation) {
    const rising = elevation >= this.elevation;
    this.light = light;
    this.elevation = elevation;
    const e = this.hello.day ? elevation : 1;
    const high = Math.max(0.12, Math.sin(e));
    const along = (rising ? 1 : -1) * Math.max(0, Math.cos(e));
    this.shared.sun.value.set(0.8 * along, -0.45, high).normalize();
    this.sun.position.copy(this.shared.sun.value).multiplyScalar(this.eye.span);
    this.shared.day.value = light;
    this.sun.intensity = 0.35 + 1.35 * Math.min(1, light);
    this.sky.intensity = 1.0 + 0.75 * Math.min(1, light);
    this.ground.tint(this.dark, light);
    this.dirty = true;
    this.onlight();
  }

  /**
   * Sets the colors of kinds for a theme.
   * @param {boolean} dark
   * @param {boolean} own whether to use the colors from the world file instead of the safe palette
   */
  theme(dark, own) {
    this.dark = dark;
    this.shared.mute.value = dark ? [0.27, 0.31, 0.33] : [0.74, 0.77, 0.78];
    this.shared.edge.value = Array(3).fill(dark || this.hello.size.length > 2 ? 0.88 : 0.1); // rims: pale on dark land and in water
    this.colours = own ? this.kinds.map((kind) => legible(kind.color, dark)) : safe(this.kinds, dark, this.hello.palette);
    this.layers.forEach((layer, k) => (layer.own.plain.value = rgb(this.colours[k]).map((part) => part / 255)));
    this.shine(this.light, this.elevation);
    this.meadow.draw(true);
    this.field.again();
  }

  /** Sets the quantity by which organisms are colored. @param {string} by */
  colourBy(by) {
    this.shared.ramp.value = this.ramps[rampOf(by)];
    for (const layer of this.layers) layer.own.byValue.value = by === "species" || layer.kind.inanimate ? 0 : 1;
    this.meadow.draw(true);
    this.dirty = true;
  }

  /** The number of organisms in the fuller of two worlds side by side, so that bodies of one size look alike in both. */
  crowding() {
    const own = (/** @type {Stage | null} */ stage) => stage?.layers.reduce((sum, layer) => sum + layer.block.n, 0) ?? 0;
    return Math.max(own(this), own(this.peer));
  }

  /** Adapts to the size of the canvas; for a picture of the same view, only to the pixels of the picture per pixel of the page. @param {number} [print] */
  resize(print) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = print ?? Math.min(2, devicePixelRatio || 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    if (!print) this.eye.resize(width, height);
    this.shared.lens.value = (height * ratio) / (2 * Math.tan((this.eye.camera.fov * Math.PI) / 360));
    const crowd = (this.crowd = this.crowding());
    const room = Math.sqrt((width * height) / Math.max(50, crowd)); // px per organism
    for (const layer of this.layers) {
      const most = layer.kind.moves ? 6 : 3.4;
      const least = layer.kind.moves ? 1.8 : 1.3;
      layer.own.least.value = ratio * Math.min(most, Math.max(least, room * (layer.kind.moves ? 0.34 : 0.2)));
    }
    this.dirty = true;
  }

  /**
   * Draws if anything is new since the last drawing, from the first frame on; returns whether it has drawn.
   * @param {number} now [ms]
   */
  draw(now) {
    const moved = this.eye.update(now);
    const share = this.share(performance.now());
    const moving = share < 1 || this.shared.alpha.value < 1;
    if (!this.frames || (!moved && !moving && !this.dirty)) return false;
    this.dirty = false;
    this.shared.alpha.value = share;
    const crowd = this.crowding();
    if (Math.abs(crowd - (this.crowd ?? 0)) > 0.2 * crowd) this.resize();
    const place = this.selected === null ? null : this.place(this.selected);
    this.eye.follow(place);
    this.trail.step(place);
    this.eye.rise(this.relief);
    clear(this, place);
    const start = performance.now();
    for (const layer of this.layers) layer.choose(this);
    this.renderer.render(this.scene, this.eye.camera);
    this.renderMs += (performance.now() - start - this.renderMs) * (this.renders < 10 ? 1 : 0.1);
    this.renders++;
    this.over.draw();
    this.onrender();
    return true;
  }

  /** Stops drawing and frees memory. */
  close() {
    this.halt();
    this.sized.disconnect();
    this.eye.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  /** Whether the last frame is drawn, and neither organisms nor the camera are moving. */
  get still() {
    return !this.dirty && !this.eye.flight && this.share(performance.now()) >= 1 && this.shared.alpha.value >= 1;
  }

  /** @param {number | null} uid */
  select(uid) {
    this.selected = uid;
    this.trail.clear();
    this.dirty = true;
  }

  /**
   * The layer and row of the organism with this uid.
   * @param {number} uid
   */
  find(uid) {
    for (const [k, layer] of this.layers.entries()) {
      const row = layer.row(uid);
      if (row >= 0) return { k, layer, row };
    }
    return null;
  }

  /**
   * The drawing position of an organism [m], or null if it is not in the frame.
   * @param {number} uid
   */
  place(uid) {
    const found = this.find(uid);
    return found ? this.spot(found.layer, found.row, new Vector3()) : null;
  }

  /**
   * The shader's `place`, on the CPU.
   * @param {Layer} layer
   * @param {number} row
   * @param {Vector3} at output
   */
  spot(layer, row, at) {
    const { now, before } = layer;
    const { size } = this.hello;
    const alpha = this.shared.alpha.value;
    for (let axis = 0; axis < 3; axis++) {
      const a = before[4 * row + axis] / 65535;
      let d = now[WORDS * row + axis] / 65535 - a;
      const wraps = axis < 2 && this.hello.edges === "torus";
      if (wraps) d -= Math.floor(d + 0.5);
      const p = a + d * alpha;
      at.setComponent(axis, (wraps ? p - Math.floor(p) : p) * (size[axis] ?? 0));
    }
    if (size.length < 3) at.z = this.relief.at(at.x, at.y) + layer.own.radius.value;
    return at;
  }

  /**
   * The canvas coordinates [px] of a position, or null if it is behind the camera.
   * @param {Vector3} place
   */
  project(place) {
    const seen = place.clone().project(this.eye.camera);
    if (seen.z > 1) return null;
    return { x: ((seen.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - seen.y) / 2) * this.canvas.clientHeight };
  }

  /** The corners of the world on the canvas [px]. */
  corners() {
    return this.eye.edges(1).map((corner) => this.project(corner)).filter((at) => at !== null);
  }

  /** Pixels per meter at the camera's target. */
  scale() {
    return this.shared.lens.value / this.renderer.getPixelRatio() / this.eye.camera.position.distanceTo(this.eye.controls.target);
  }
}
