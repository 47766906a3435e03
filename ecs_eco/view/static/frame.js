// Binary frames: a header and, for each kind, 12 bytes an organism. Nothing is copied: blocks are views of the frame's bytes.

export const MAGIC = 0x31434545; // "EEC1"
export const WORDS = 6; // 16-bit words an organism: x, y, z, heading | value << 8, uid (two words)
export const LONGS = 3; // 32-bit words an organism; the last is the uid's offset

/**
 * @typedef {object} Block The organisms of one kind.
 * @property {number} n
 * @property {Uint16Array} words
 * @property {Uint32Array} longs
 */

/**
 * @typedef {object} Frame
 * @property {number} frame number of the frame
 * @property {number} tick
 * @property {number} base to be added to each uid
 * @property {number} light at the surface, 0 … 1
 * @property {number} elevation of the sun [rad]
 * @property {Block[]} blocks in the order of species, then objects
 */

/**
 * Reads one frame.
 * @param {ArrayBuffer} buffer
 * @returns {Frame}
 */
export function decode(buffer) {
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) throw new Error("a binary message that is no frame");
  const kinds = view.getUint32(24, true);
  let at = 28 + 4 * kinds;
  const blocks = [];
  for (let kind = 0; kind < kinds; kind++) {
    const n = view.getUint32(28 + 4 * kind, true);
    blocks.push({ n, words: new Uint16Array(buffer, at, n * WORDS), longs: new Uint32Array(buffer, at, n * LONGS) });
    at += 12 * n;
  }
  return {
    frame: view.getUint32(4, true),
    tick: view.getUint32(8, true),
    base: view.getUint32(12, true),
    light: view.getFloat32(16, true),
    elevation: view.getFloat32(20, true),
    blocks,
  };
}
