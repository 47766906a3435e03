// Matches the organisms of a frame with the previous frame: by row if rows are stable, otherwise by a table of uids.

import { LONGS } from "./frame.js";

const NOBODY = 0xffffffff;
const NEWBORN = 256 << 16; // bit in the second half of an organism's `before`
const POSE = 0xffffff; // all bits of the second half of its words except those of its value

/** Rows by uid: a hash table with open addressing, whose size is a power of two. */
class Rows {
  constructor() {
    this.keys = new Uint32Array(0);
    this.rows = new Int32Array(0);
    this.mask = 0;
    /** @type {Uint32Array | null} the upper halves of the uids */
    this.upper = null;
  }

  /** @param {import("./frame.js").Block} block */
  fill({ longs, n, upper }) {
    this.upper = upper;
    let room = 64;
    while (room < 2 * n) room *= 2;
    if (this.keys.length !== room) {
      this.keys = new Uint32Array(room);
      this.rows = new Int32Array(room);
      this.mask = room - 1;
    }
    const { keys, rows, mask } = this;
    keys.fill(NOBODY);
    for (let row = 0; row < n; row++) {
      const uid = longs[row * LONGS + 2];
      let slot = Math.imul(uid, 0x9e3779b1) & mask;
      while (keys[slot] !== NOBODY) slot = (slot + 1) & mask;
      keys[slot] = uid;
      rows[slot] = row;
    }
  }

  /** @param {number} uid lower half @param {number} high upper half */
  get(uid, high) {
    const { keys, mask, upper } = this;
    let slot = Math.imul(uid, 0x9e3779b1) & mask;
    while (keys[slot] !== NOBODY) {
      if (keys[slot] === uid && (upper ? upper[this.rows[slot]] : 0) === high) return this.rows[slot];
      slot = (slot + 1) & mask;
    }
    return -1;
  }
}

const table = new Rows();

/**
 * Writes the current drawing position of each organism of `block`: `before[4 i …]` = x, y, z, heading | NEWBORN if it is new.
 * @param {Uint16Array} before output
 * @param {import("./frame.js").Block} block the new frame
 * @param {import("./frame.js").Block} old the displayed frame
 * @param {Uint16Array} oldBefore starting positions of the organisms in `old`
 * @param {number} share progress of the motion from oldBefore to old, 0 … 1
 */
export function match(before, block, old, oldBefore, share) {
  const { n, longs, upper } = block, halves = new Uint32Array(before.buffer);
  let filled = false;
  for (let i = 0; i < n; i++) {
    const uid = longs[i * LONGS + 2], high = upper ? upper[i] : 0;
    let j = i;
    if (i >= old.n || old.longs[i * LONGS + 2] !== uid || (old.upper ? old.upper[i] : 0) !== high) {
      if (!filled) table.fill(old);
      filled = true;
      j = table.get(uid, high);
    }
    const from = j < 0 ? longs : old.longs, first = LONGS * (j < 0 ? i : j);
    halves[2 * i] = from[first];
    halves[2 * i + 1] = (from[first + 1] & POSE) | (j < 0 ? NEWBORN : 0);
    if (j >= 0 && share < 1) between(before, 4 * i, oldBefore, 4 * j, share);
  }
}

/**
 * Interpolates from `b[j …]` to `a[i …]`. On a torus, 16-bit differences take the shorter path.
 * Between walls, no difference is large enough to wrap.
 * @param {Uint16Array} a
 * @param {number} i
 * @param {Uint16Array} b
 * @param {number} j
 * @param {number} share
 */
function between(a, i, b, j, share) {
  for (let axis = 0; axis < 3; axis++) {
    const step = ((a[i + axis] - b[j + axis] + 98304) & 65535) - 32768; // shortest signed difference
    a[i + axis] = b[j + axis] + Math.round(step * share);
  }
  const turn = ((a[i + 3] - b[j + 3] + 384) & 255) - 128;
  a[i + 3] = (b[j + 3] + Math.round(turn * share)) & 255;
}

/**
 * Sets all start positions to the current positions, so that nothing moves.
 * @param {Uint16Array} before
 * @param {import("./frame.js").Block} block
 */
export function still(before, { n, longs }) {
  const halves = new Uint32Array(before.buffer);
  for (let i = 0; i < n; i++) {
    halves[2 * i] = longs[LONGS * i];
    halves[2 * i + 1] = longs[LONGS * i + 1] & POSE;
  }
}
