// The organisms of one kind in the scene: up to a few thousand animals or trees are drawn as bodies, and all
// other organisms as points.

import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, InstancedBufferGeometry, InstancedInterleavedBuffer, InterleavedBuffer,
  InterleavedBufferAttribute, Mesh, Points, ShaderMaterial,
} from "./vendor.js";
import { animal, box, capsule, formOf, gaitOf, shadow } from "./body.js";
import { WORDS, rowOf, uidOf } from "./frame.js";
import { match, still } from "./match.js";
import { BODY_FRAGMENT, BODY_VERTEX, POINT_FRAGMENT, POINT_VERTEX, SHADOW_FRAGMENT, SHADOW_VERTEX, SOLID_VERTEX } from "./shaders.js";

const DARTS = 3000; // maximum number of bodies; beyond that, points are drawn
const BOXES = 50000;
const RIM = 0.24; // width of the rim of animals in water, in radii
/** The stripes at the lowest and highest value of the gene that draws them: none 0, full 1. @param {import("./protocol.js").Kind} kind */
const stripesOf = ({ shows, build }) => (!build || !shows?.stripes ? [0, 0] : shows.stripes[1] > shows.stripes[2] ? [1, 0] : [0, 1]);

const NOTHING = { n: 0, words: new Uint16Array(0), longs: new Uint32Array(0), upper: null, genes: null };

/** @typedef {import("./frame.js").Block} Block */
/** @typedef {{value: any}} Uniform */

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
      sizes: { value: (!kind.shape && kind.shows?.size?.slice(1)) || [1, 1] },
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
    /** @type {{drawn: Points | Mesh, geometry: BufferGeometry, shade: InstancedBufferGeometry, buffers: InterleavedBuffer[], darts: boolean} | null} */
    this.form = null;
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
    this.upload();
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

  upload() {
    const { form, block } = this;
    if (!form) return;
    for (const [k, buffer] of form.buffers.entries()) {
      buffer.array = [this.now, this.before, this.genes][k];
      buffer.clearUpdateRanges();
      buffer.addUpdateRange(0, block.n * buffer.stride);
      buffer.needsUpdate = true;
    }
    if (form.darts) form.shade.instanceCount = /** @type {InstancedBufferGeometry} */ (form.geometry).instanceCount = block.n;
    else form.geometry.setDrawRange(0, block.n);
    form.drawn.visible = this.shown && block.n > 0;
  }

  /**
   * Allocates buffers for n organisms.
   * @param {number} n
   * @param {boolean} darts
   */
  build(n, darts) {
    if (this.form) {
      this.group.remove(this.form.drawn);
      this.form.geometry.dispose();
    }
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
    const Buffer = darts ? InstancedInterleavedBuffer : InterleavedBuffer;
    const buffers = [new Buffer(this.now, WORDS), new Buffer(this.before, 4), new Buffer(this.genes, 1)];
    const geometry = darts ? new InstancedBufferGeometry() : new BufferGeometry();
    const shade = new InstancedBufferGeometry().setAttribute("corner", new BufferAttribute(shadow(), 3));
    for (const [k, name] of ["now", "before", "genes"].entries()) {
      buffers[k].setUsage(DynamicDrawUsage);
      for (const one of [geometry, shade]) one.setAttribute(name, new InterleavedBufferAttribute(buffers[k], Math.min(4, buffers[k].stride), 0));
    }
    shade.setAttribute("position", shade.getAttribute("corner"));
    if (darts) {
      const form = this.kind.shape === "box" ? box() : this.kind.shape ? capsule() : animal(formOf(this.kind), this.kind.variant);
      if (this.kind.shape) {
        const forms = new InstancedInterleavedBuffer(new Float32Array(4 * this.room), 4);
        geometry.setAttribute("form", new InterleavedBufferAttribute(forms, 4, 0));
      }
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
    this.group.add(drawn);
    this.form = { drawn, geometry, shade, buffers, darts };
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
