// The organisms of one kind in the scene: up to a few thousand animals or trees, those near the camera first, are drawn as
// bodies, and all other organisms as points.

import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, InstancedBufferGeometry, InstancedInterleavedBuffer, InterleavedBuffer,
  InterleavedBufferAttribute, Mesh, Points, ShaderMaterial,
} from "./vendor.js";
import { animal, box, capsule, formOf, gaitOf, shadow } from "./body.js";
import { WORDS, rowOf, uidOf } from "./frame.js";
import { match, still } from "./match.js";
import { BODY_FRAGMENT, BODY_VERTEX, POINT_FRAGMENT, POINT_VERTEX, SHADOW_FRAGMENT, SHADOW_VERTEX, SOLID_VERTEX } from "./shaders.js";

const DARTS = 3000; // maximum number of bodies; if there are more organisms, only those near the camera have one
const NEAR = 4; // minimum radius of these on the screen [px]
const STEPS = 64; // of depth, by which they are counted
const BOXES = 50000;
const RIM = 0.24; // width of the rim of animals in water, in radii
/** The stripes at the lowest and highest value of the gene that draws them: none 0, full 1. @param {import("./protocol.js").Kind} kind */
const stripesOf = ({ shows, build }) => (!build || !shows?.stripes ? [0, 0] : shows.stripes[1] > shows.stripes[2] ? [1, 0] : [0, 1]);

const NOTHING = { n: 0, words: new Uint16Array(0), longs: new Uint32Array(0), upper: null, genes: null };

/** @typedef {import("./frame.js").Block} Block */
/** @typedef {{value: any}} Uniform */
/** @typedef {{drawn: Points | Mesh, geometry: BufferGeometry, shade: InstancedBufferGeometry, buffers: InterleavedBuffer[], darts: boolean}} Form */

export class Layer {
  /**
   * @param {import("./protocol.js").Kind} kind
   * @param {import("./vendor.js").Group} group
   * @param {Record<string, Uniform>} shared uniforms shared by all layers
   */
  constructor(kind, group, shared) {
    this.kind = kind;
    this.group = group;
    this.room = 0;
    /** @type {Block} */
    this.block = NOTHING;
    this.now = new Uint16Array(0);
    this.before = new Uint16Array(0);
    this.past = new Uint16Array(0);
    this.genes = new Uint16Array(0); // of a volume
    this.shown = true;
    this.sea = shared.size.value.z > 0;
    this.own = {
      radius: { value: kind.size ? kind.size[2] / 2 : kind.radius || 0.3 },
      plain: { value: [0.5, 0.5, 0.5] },
      least: { value: 2 },
      byValue: { value: 0 },
      rim: { value: 0 }, // size of the dark copy behind the body; 0: none
      nearer: { value: kind.hunts ? 2e-5 : 1e-5 }, // hunters are drawn in front of other animals
      pointed: { value: kind.moves || kind.rests ? 1 : 0 },
      sizes: { value: kind.shape ? [1, 1] : kind.shows?.size?.slice(1) ?? [kind.shows?.grows?.[2] ?? 1, 1] },
      striped: { value: stripesOf(kind) },
      gait: { value: kind.build ? gaitOf(kind.build) : 0 },
      drifts: { value: kind.sessile && !kind.inanimate && this.sea ? 1 : 0 },
      grows: { value: kind.sessile && !kind.inanimate && !this.sea ? 1 : 0 },
      lying: { value: formOf(kind) === "plate" && !this.sea ? 1 : 0 },
    };
    const uniforms = { ...shared, ...this.own };
    this.pointed = new ShaderMaterial({ uniforms, vertexShader: POINT_VERTEX, fragmentShader: POINT_FRAGMENT, transparent: true });
    this.bodied = new ShaderMaterial({ uniforms, vertexShader: kind.shape ? SOLID_VERTEX : BODY_VERTEX, fragmentShader: BODY_FRAGMENT, side: DoubleSide });
    const behind = { ...uniforms, rim: { value: RIM } };
    this.edged = new ShaderMaterial({ uniforms: behind, vertexShader: BODY_VERTEX, fragmentShader: BODY_FRAGMENT, side: DoubleSide });
    this.shaded = new ShaderMaterial({ uniforms, vertexShader: SHADOW_VERTEX, fragmentShader: SHADOW_FRAGMENT, transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -3, polygonOffsetUnits: -3 });
    /** @type {Form | null} */
    this.form = null;
    /** @type {(Form & {arrays: Uint16Array[], n: number, others: BufferAttribute}) | null} the bodies of animals near the camera, while the others are points */
    this.near = null;
    /** @type {number[] | null} the view for which they were chosen */
    this.chosen = null;
    this.rows = new Uint32Array(0); // of candidates
    this.depths = new Float32Array(0);
  }

  /**
   * Stores the organisms of a new frame.
   * @param {Block} block
   * @param {number} share progress of the displayed motion, 0 to 1
   * @param {boolean} jump whether to skip the motion from the last frame to this one
   */
  take(block, share, jump) {
    const most = this.kind.shape === "box" ? BOXES : DARTS;
    const darts = Boolean(this.kind.build || this.kind.shape) && block.n <= (this.form?.darts ? most * 1.2 : most);
    if (block.n > this.room || !this.form || this.form.darts !== darts) this.build(block.n, darts);
    [this.before, this.past] = [this.past, this.before];
    if (jump || !this.kind.moves) still(this.before, block);
    else match(this.before, block, this.block, this.past, share);
    this.now.set(block.words);
    if (block.genes) this.genes.set(block.genes);
    this.block = block;
    this.chosen = null;
    if (this.form) this.upload(this.form, [this.now, this.before, this.genes], block.n);
    if (this.form) this.form.drawn.visible = this.shown && block.n > 0;
    this.resize();
  }

  /** Sets the sizes of capsules and boxes. */
  resize() {
    const form = this.form?.geometry.getAttribute("form");
    if (!(form instanceof InterleavedBufferAttribute) || !this.kind.size) return;
    const sizes = this.kind.sizes ?? {};
    for (let row = 0; row < this.block.n; row++) {
      const [length, width, height] = sizes[String(this.uid(row))] ?? this.kind.size;
      const round = this.kind.shape === "capsule" ? width / 2 : 0;
      form.setXYZW(row, length / 2 - round, width / 2 - round, height / 2 - round, round);
    }
    form.data.needsUpdate = true;
  }

  /** Sends the first n organisms in some arrays. @param {Form} form @param {Uint16Array[]} arrays @param {number} n */
  upload(form, arrays, n) {
    for (const [k, buffer] of form.buffers.slice(0, this.block.genes ? 3 : 2).entries()) {
      buffer.array = arrays[k];
      buffer.clearUpdateRanges();
      buffer.addUpdateRange(0, n * buffer.stride);
      buffer.needsUpdate = true;
    }
    if (form.darts) form.shade.instanceCount = /** @type {InstancedBufferGeometry} */ (form.geometry).instanceCount = n;
    else form.geometry.setDrawRange(0, n);
  }

  /**
   * If animals are too many for all to be bodies, chooses those that are, after a new frame or a change of the view.
   * @param {import("./stage.js").Stage} stage
   */
  choose(stage) {
    const { form, block: { n } } = this, { camera } = stage.eye;
    if (!form || form.darts || !this.kind.build || !this.shown || !n) return;
    camera.updateMatrixWorld();
    const view = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements, { chosen } = this;
    if (chosen && view.every((value, k) => value === chosen[k])) return;
    this.chosen = [...view];
    const rows = this.close(stage, view);
    if (!rows.length && !this.near?.n) return;
    const near = (this.near ??= this.bodies(form));
    rows.forEach((row, k) => [this.now, this.before, this.genes].forEach((from, part) => {
      const wide = near.buffers[part].stride;
      for (let word = 0; word < wide; word++) near.arrays[part][wide * k + word] = from[wide * row + word];
    }));
    near.n = rows.length;
    near.drawn.visible = rows.length > 0;
    this.upload(near, near.arrays, rows.length);
    for (let row = 0, k = 0, at = 0; row < n; row++) row === rows[k] ? k++ : (near.others.array[at++] = row);
    near.others.needsUpdate = true;
    form.geometry.setIndex(rows.length ? near.others : null).setDrawRange(0, n - rows.length);
  }

  /** The bodies of animals near the camera, next to the points of the others. @param {Form} form */
  bodies(form) {
    const arrays = [WORDS, 4, 1].map((wide) => new Uint16Array(wide * DARTS)), others = new BufferAttribute(new Uint32Array(this.room), 1);
    const near = { ...this.make(true, arrays, DARTS), arrays, n: 0, others: others.setUsage(DynamicDrawUsage) };
    form.drawn.add(near.drawn);
    return near;
  }

  /**
   * The rows, in order, of animals in view that are large enough on the screen: all, or the nearest if they are too many.
   * @param {import("./stage.js").Stage} stage
   * @param {number[]} view the camera's matrix
   */
  close({ eye: { camera, levels }, shared, relief, hello: { size }, renderer }, view) {
    const { now, block: { n }, own } = this, radius = own.radius.value, { x: ex, y: ey, z: ez } = camera.position;
    const far = (radius * shared.lens.value) / Math.max(own.least.value, NEAR * renderer.getPixelRatio()), margin = 4 * radius * camera.projectionMatrix.elements[5];
    const beyond = (/** @type {number} */ at, /** @type {number} */ low, /** @type {number} */ high) => Math.max(low - at, 0, at - high);
    if (Math.hypot(beyond(ex, 0, size[0]), beyond(ey, 0, size[1]), beyond(ez, levels[0], levels[1])) > far) return this.rows.subarray(0, 0);
    if (this.rows.length < n) [this.rows, this.depths] = [new Uint32Array(this.room), new Float32Array(this.room)];
    const [sx, sy, sz] = [0, 1, 2].map((axis) => (size[axis] ?? 0) / 65535), counts = new Uint32Array(STEPS), { rows, depths } = this;
    const { elements: lens } = camera.projectionMatrix, most = (far * (1 + 2 / lens[0] + 2 / lens[5])) ** 2; // [m²] no corner of the view is farther away
    let found = 0;
    for (let row = 0; row < n; row++) {
      const x = now[WORDS * row] * sx, y = now[WORDS * row + 1] * sy;
      if ((x - ex) * (x - ex) + (y - ey) * (y - ey) > most) continue;
      const z = sz ? now[WORDS * row + 2] * sz : relief.at(x, y) + radius;
      const depth = view[3] * x + view[7] * y + view[11] * z + view[15];
      if (depth > far || depth < -margin || Math.abs(view[0] * x + view[4] * y + view[8] * z + view[12]) > depth + margin) continue;
      if (Math.abs(view[1] * x + view[5] * y + view[9] * z + view[13]) > depth + margin) continue;
      counts[Math.min(STEPS - 1, Math.max(0, Math.floor((STEPS * depth) / far)))]++;
      [rows[found], depths[found++]] = [row, depth];
    }
    if (found <= DARTS) return rows.subarray(0, found);
    let step = 0;
    for (let sum = counts[0]; sum <= DARTS; sum += counts[++step]);
    let kept = 0;
    for (let k = 0; k < found; k++) if (STEPS * depths[k] < far * step) rows[kept++] = rows[k];
    return rows.subarray(0, kept);
  }

  /**
   * Allocates buffers for n organisms.
   * @param {number} n
   * @param {boolean} darts
   */
  build(n, darts) {
    for (const form of [this.form, this.near]) {
      form?.drawn.removeFromParent();
      form?.geometry.dispose();
    }
    this.near = null;
    if (n > this.room) {
      this.room = Math.max(256, Math.ceil(n * 1.3));
      this.now = new Uint16Array(this.room * WORDS);
      const [before, past] = [this.before, this.past];
      this.before = new Uint16Array(this.room * 4);
      this.past = new Uint16Array(this.room * 4);
      this.before.set(before);
      this.past.set(past);
      this.genes = new Uint16Array(this.room);
    }
    this.form = this.make(darts, [this.now, this.before, this.genes], this.room);
    this.group.add(this.form.drawn);
  }

  /**
   * Makes bodies or points of organisms.
   * @param {boolean} darts
   * @param {Uint16Array[]} arrays positions now and before, and genes
   * @param {number} room maximum number of organisms
   * @returns {Form}
   */
  make(darts, arrays, room) {
    const Buffer = darts ? InstancedInterleavedBuffer : InterleavedBuffer;
    const buffers = [WORDS, 4, 1].map((wide, k) => new Buffer(arrays[k], wide));
    const geometry = darts ? new InstancedBufferGeometry() : new BufferGeometry();
    const shade = new InstancedBufferGeometry().setAttribute("corner", new BufferAttribute(shadow(), 3));
    for (const [k, name] of ["now", "before", "genes"].entries()) {
      buffers[k].setUsage(DynamicDrawUsage);
      for (const one of [geometry, shade]) one.setAttribute(name, new InterleavedBufferAttribute(buffers[k], Math.min(4, buffers[k].stride), 0));
    }
    shade.setAttribute("position", shade.getAttribute("corner"));
    if (darts) {
      const body = this.kind.shape ? null : animal(formOf(this.kind), this.kind.variant), form = body ?? (this.kind.shape === "box" ? box() : capsule());
      geometry.setIndex(body?.facets ?? null);
      if (!body) geometry.setAttribute("form", new InterleavedBufferAttribute(new InstancedInterleavedBuffer(new Float32Array(4 * room), 4), 4, 0));
      geometry.setAttribute("corner", new BufferAttribute(form.corners, 3));
      geometry.setAttribute("facing", new BufferAttribute(form.normals, 3));
      geometry.setAttribute("tone", new BufferAttribute(form.tones, 1));
      geometry.setAttribute("position", geometry.getAttribute("corner"));
    }
    const drawn = darts ? new Mesh(geometry, this.bodied) : new Points(geometry, this.pointed);
    drawn.frustumCulled = false;
    if (darts && !this.kind.shape) {
      const under = this.sea ? new Mesh(geometry, this.edged) : new Mesh(shade, this.shaded);
      under.frustumCulled = false;
      drawn.add(under);
    }
    return { drawn, geometry, shade, buffers, darts };
  }

  /** @param {boolean} shown */
  show(shown) {
    this.shown = shown;
    if (this.form) this.form.drawn.visible = shown && this.block.n > 0;
  }

  /** @param {number} row */
  uid(row) {
    return uidOf(this.block, row);
  }

  /**
   * The row of an organism, or −1 if it is not in this frame.
   * @param {number} uid
   */
  row(uid) {
    return rowOf(this.block, uid);
  }
}
