// Binary frames: a header and, for each kind, 12 bytes per organism; at the end, for long uids and for genes in a volume, 4 more bytes per organism each.
// Blocks are views of the frame's bytes, so nothing is copied.

export const MAGIC = 0x31434545; // "EEC1"
export const WORDS = 6; // number of 16-bit words per organism, for x, y, z, heading | value << 8, and uid (two words)
export const LONGS = 3; // number of 32-bit words per organism, of which the last is the lower half of the uid

/**
 * @typedef {object} Block The organisms of one kind.
 * @property {number} n
 * @property {Uint16Array} words
 * @property {Uint32Array} longs
 * @property {Uint32Array | null} upper upper halves of the uids, if any uid in the frame needs one
 * @property {Uint32Array | null} genes in a volume, if any show: size | stripes << 8
 */

const HALF = 2 ** 32;

/** The uid of an organism. It is below 2^53, so a number represents it exactly. @param {Block} block @param {number} row */
export const uidOf = ({ longs, upper }, row) => longs[row * LONGS + 2] + (upper ? upper[row] * HALF : 0);

/** The row of an organism, or −1 if it is not in the block. @param {Block} block @param {number} uid */
export function rowOf({ n, longs, upper }, uid) {
  const low = uid % HALF, high = Math.floor(uid / HALF);
  if (high && !upper) return -1;
  for (let row = 0; row < n; row++) if (longs[row * LONGS + 2] === low && (!upper || upper[row] === high)) return row;
  return -1;
}

/**
 * @typedef {object} Frame
 * @property {number} frame number of the frame
 * @property {number} tick
 * @property {number} light at the surface, 0 … 1
 * @property {number} elevation of the sun [rad]
 * @property {Block[]} blocks species, then objects, in order
 * @property {number} end byte offset of its end; the frame of another world may follow
 */

/**
 * Decodes one frame.
 * @param {ArrayBuffer} buffer
 * @param {number} [from] offset of the frame's first byte
 * @returns {Frame}
 */
export function decode(buffer, from = 0) {
  const view = new DataView(buffer, from);
  if (view.getUint32(0, true) !== MAGIC) throw new Error("unknown binary message: not a frame");
  const kinds = view.getUint32(24, true);
  let at = from + 28 + 4 * kinds;
  /** @type {Block[]} */
  const blocks = [];
  for (let kind = 0; kind < kinds; kind++) {
    const n = view.getUint32(28 + 4 * kind, true);
    blocks.push({ n, words: new Uint16Array(buffer, at, n * WORDS), longs: new Uint32Array(buffer, at, n * LONGS), upper: null, genes: null });
    at += 12 * n;
  }
  for (const [bit, part] of /** @type {[number, "upper" | "genes"][]} */ ([[1, "upper"], [2, "genes"]])) {
    for (const block of view.getUint32(12, true) & bit ? blocks : []) {
      block[part] = new Uint32Array(buffer, at, block.n);
      at += 4 * block.n;
    }
  }
  return {
    frame: view.getUint32(4, true),
    tick: view.getUint32(8, true),
    light: view.getFloat32(16, true),
    elevation: view.getFloat32(20, true),
    blocks,
    end: at,
  };
}
