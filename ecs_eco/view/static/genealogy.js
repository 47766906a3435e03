// The layout of a family tree: ancestors above the focal organism, children and grandchildren below, siblings to the side.

/** @typedef {import("./protocol.js").Relative} Relative @typedef {import("./protocol.js").TreeMessage} TreeMessage */

export const COLUMN = 64; // [px]
export const BOX = [58, 42]; // [px] width and height of an organism
const GAP = 62; // minimum distance from a parent to its child [px]
const STEPS = [5, 30]; // minimum and maximum distance between consecutive ticks of birth [px]
const SPAN = 320; // approximate total height of the ticks [px]
const CHILDREN = 4; // shown before "+12"
const GRANDCHILDREN = [3, 1]; // shown for an only child, and for each of two children

/**
 * A box in the drawing: an organism, or a group of hidden organisms.
 * @typedef {object} Place
 * @property {string} key
 * @property {Relative | null} life null: "+12"
 * @property {number} x center of the box [px]
 * @property {number} y top of the box [px]
 * @property {number} hidden number of organisms represented by "+12"
 * @property {boolean} opens whether a click expands the group
 * @property {string} what description
 * @property {string[]} to keys of the boxes below that its lines lead to
 * @property {boolean} above whether it is the focal organism or an ancestor
 */

export class Genealogy {
  /** @param {TreeMessage} tree @param {Set<string>} open keys of expanded groups @param {number} up generations shown above */
  constructor(tree, open, up) {
    this.open = open;
    this.up = up;
    this.lives = new Map(tree.lives.map((life) => [life.uid, life]));
    this.focal = /** @type {Relative} */ (this.lives.get(tree.uid));
    this.siblings = tree.siblings;
    this.shown = 0; // number of displayed children of the focal organism
    this.width = this.height = 0; // [px]
    /** @type {[number, number][]} ticks of birth and their heights [px] */
    this.axis = [];
    /** @type {Map<string, Place>} */
    this.places = new Map();
    this.lay();
  }

  lay() {
    const { focal } = this;
    const up = this.above(focal, 0, 0);
    const down = this.below(focal, 0, 0);
    const [first, second] = [down.middle - up.middle, up.middle - down.middle].map((shift) => Math.max(0, shift));
    for (const place of up.places) (place.x += first), (place.above = true);
    for (const place of down.places) place.x += second;
    const middle = up.middle + first;
    const right = Math.max(up.width + first, down.width + second);
    this.place(this.one(focal), middle).above = true;
    const width = right + this.beside(right);
    for (const place of this.places.values()) place.x = place.x * COLUMN;
    this.width = width * COLUMN;
    this.lines();
    this.height = this.rows();
  }

  /** @param {Relative} life @returns {Place} */
  one(life) {
    return { key: String(life.uid), life, x: 0, y: 0, hidden: 0, opens: false, what: "", to: [], above: false };
  }

  /** @param {string} key @param {number} hidden @param {boolean} opens @param {string} what @param {string[]} to @returns {Place} */
  more(key, hidden, opens, what, to) {
    return { key, life: null, x: 0, y: 0, hidden, opens, what, to, above: false };
  }

  /** @param {Place} place @param {number} x [columns] */
  place(place, x) {
    place.x = x;
    this.places.set(place.key, place);
    return place;
  }

  /** Places the parents of an organism that are not in the tree yet, and their ancestors. @param {Relative} life @param {number} depth @param {number} left @returns {{places: Place[], middle: number, width: number}} */
  above(life, depth, left) {
    const parents = life.parents.map((uid) => this.lives.get(uid)).filter((one) => one !== undefined).filter(({ uid }) => !this.places.has(String(uid)) && uid !== this.focal.uid);
    const key = `up ${life.uid}`;
    if (!parents.length && life.parents.every((uid) => this.lives.has(uid))) return { places: [], middle: left + 0.5, width: 1 };
    if (!parents.length || depth >= this.up) {
      const n = this.ancestors(life);
      const further = n.cut ? " or more" : "";
      const place = this.place(this.more(key, n.known, parents.length > 0, `${n.known}${further} ancestors before #${life.uid}`, [String(life.uid)]), left + 0.5);
      return { places: [place], middle: left + 0.5, width: 1 };
    }
    /** @type {Place[]} */
    const places = [];
    const middles = [];
    let width = 0;
    const own = parents.map((parent) => this.place(this.one(parent), 0));
    for (const place of own) {
      const part = this.above(/** @type {Relative} */ (place.life), depth + 1, left + width);
      place.x = part.middle;
      middles.push(part.middle);
      width += part.width;
      places.push(place, ...part.places);
    }
    return { places, middle: (middles[0] + middles[middles.length - 1]) / 2, width };
  }

  /** The number of listed ancestors and whether there are more. @param {Relative} life */
  ancestors(life) {
    const found = new Set();
    const waiting = [...life.parents];
    let cut = false;
    for (let uid = waiting.pop(); uid !== undefined; uid = waiting.pop()) {
      if (found.has(uid)) continue;
      found.add(uid);
      const one = this.lives.get(uid);
      if (one) waiting.push(...one.parents);
      else cut = true;
    }
    return { known: found.size, cut };
  }

  /** Places the children of an organism, and their children. @param {Relative} life @param {number} depth 0: the focal organism @param {number} left @returns {{places: Place[], middle: number, width: number}} */
  below(life, depth, left) {
    const key = `down ${life.uid}`;
    const listed = [...this.lives.values()].filter(({ parents }) => parents.includes(life.uid));
    const children = listed.filter(({ uid }) => !this.places.has(String(uid))).sort((a, b) => (b.young ?? 0) - (a.young ?? 0));
    const all = depth > 1 ? 0 : Math.max(life.young ?? 0, listed.length) - (listed.length - children.length);
    if (!all) return { places: [], middle: left + 0.5, width: 1 };
    const few = depth ? GRANDCHILDREN[Math.min(this.shown, 2) - 1] : CHILDREN;
    let most = this.open.has(key) ? children.length : depth && this.shown > 2 ? 0 : few;
    if (all === most + 1) most = all; // "+1" would take the same space
    const shown = children.slice(0, most).sort((a, b) => (a.born ?? 0) - (b.born ?? 0) || a.uid - b.uid);
    if (!depth) this.shown = shown.length;
    const own = shown.map((child) => this.place(this.one(child), 0));
    /** @type {Place[]} */
    const places = [];
    let width = 0;
    for (const place of own) {
      const part = this.below(/** @type {Relative} */ (place.life), depth + 1, left + width);
      place.x = part.middle;
      width += part.width;
      places.push(place, ...part.places);
    }
    if (all > shown.length) {
      const rest = this.place(this.more(key, all - shown.length, children.length > shown.length, `${all - shown.length} ${shown.length ? "more " : ""}${all - shown.length > 1 ? "children" : "child"} of #${life.uid}`, []), left + width + 0.5);
      own.push(rest);
      places.push(rest);
      width += 1;
    }
    return { places, middle: (own[0].x + own[own.length - 1].x) / 2, width };
  }

  /** Places the siblings of the focal organism on the right. @param {number} left @returns {number} columns */
  beside(left) {
    if (!this.siblings) return 0;
    const parents = new Set(this.focal.parents);
    const listed = [...this.lives.values()].filter(({ uid, parents: own }) => !this.places.has(String(uid)) && own.some((one) => parents.has(one)));
    const open = this.open.has("beside") || this.siblings === 1;
    const shown = open ? listed : [];
    shown.forEach((sibling, i) => this.place(this.one(sibling), left + i + 0.5));
    const rest = this.siblings - shown.length;
    if (rest > 0) this.place(this.more("beside", rest, listed.length > shown.length, `${rest} ${shown.length ? "more " : ""}sibling${rest > 1 ? "s" : ""}`, []), left + shown.length + 0.5);
    return shown.length + Number(rest > 0);
  }

  /** Draws lines from parents to children, including hidden children. */
  lines() {
    const at = (/** @type {number} */ uid) => this.places.get(String(uid));
    for (const { life, key } of this.places.values()) for (const uid of life?.parents ?? []) at(uid)?.to.push(key);
    for (const place of this.places.values()) {
      if (place.key.startsWith("down ")) at(Number(place.key.slice(5)))?.to.push(place.key);
      if (place.key === "beside") for (const uid of this.focal.parents) at(uid)?.to.push(place.key);
    }
  }

  /** Sets heights: later births are lower, and children do not overlap their parents. @returns {number} the total height */
  rows() {
    const born = (/** @type {Place} */ { life }) => life?.born ?? -Infinity;
    const drawn = [...this.places.values()];
    const known = [...new Set(drawn.map(born))].filter(Number.isFinite).sort((a, b) => a - b);
    const least = known[0] ?? 0;
    const scale = SPAN / Math.max(1, (known[known.length - 1] ?? 0) - least);
    /** @type {Map<Place, Place[]>} */
    const parents = new Map(drawn.map((place) => [place, drawn.filter(({ to }) => to.includes(place.key))]));
    const under = (/** @type {Place} */ place) => Math.max(0, ...(parents.get(place) ?? []).map(({ y }) => y + GAP));
    let y = drawn.some((place) => place.hidden && place.to.length) || drawn.some((place) => place.life && place.life.born === null) ? GAP : 0;
    let before = least;
    for (const tick of known) {
      const row = drawn.filter((place) => born(place) === tick);
      y += tick === least ? 0 : Math.min(STEPS[1], Math.max(STEPS[0], scale * (tick - before)));
      y = Math.max(y, ...row.map(under));
      for (const place of row) place.y = y;
      this.axis.push([tick, y]);
      before = tick;
    }
    for (const place of drawn) if (!Number.isFinite(born(place)) && !place.to.length) place.y = under(place);
    return Math.max(...drawn.map((place) => place.y)) + BOX[1];
  }
}
