// The server of a page saved as a file: plays the run stored in the page, and answers the page's requests.

import { MAGIC } from "./frame.js";

/** @typedef {import("./protocol.js").Message} Message @typedef {import("./protocol.js").Stored} Stored @typedef {import("./protocol.js").StoredKind} StoredKind */
/** @typedef {Record<string, Uint8Array | Uint16Array | Uint32Array | Int32Array | Float32Array | Float64Array>} Columns */
/** @typedef {Float64Array} Place x, y, z and heading in the units of a frame, energy and happiness; NaN if unknown */

const TYPES = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };
const AXES = ["x", "y", "z"], TOP = 65535; // positions are shares of the world's size, out of 65,535
const [BIRTH, DEATH] = [-1, -2]; // in place of a row of stored states
const TURN = 256, FINE = 65534, COARSE = 254; // steps of headings, states and colors
const HEAD = 28, WORDS = 3, HALF = 2 ** 32; // of a frame [bytes], of an organism [u32]
const [PACE, STATES, PANELS, FULL] = [50, 250, 100, 1000]; // [ms] between frames, states and panels; ticks per second at full speed
const [TICKS, MOST, CHILDREN] = [5, 100, 200]; // deaths: for how many ticks, and at most how many; children in a list

/** Stands for a WebSocket. @returns {Promise<WebSocket | "refused" | "no answer">} */
export async function dial() {
  const [head, clock, ...kinds] = await window.run;
  return /** @type {any} */ (new Shelf(JSON.parse(new TextDecoder().decode(head)), clock, kinds));
}

/** @param {[string, keyof typeof TYPES, number][]} columns name, type and length @param {ArrayBuffer} buffer @returns {Columns} */
function read(columns, buffer) {
  let at = 0;
  return Object.fromEntries(columns.map(([name, type, length]) => {
    const bytes = length * TYPES[type].BYTES_PER_ELEMENT;
    return [name, new TYPES[type](buffer.slice(at, (at += bytes)))];
  }));
}

/** A value from its number on a scale; NaN if unknown. @param {number} code @param {[number, number] | undefined} scale */
const valueOf = (code, scale) => (code && scale ? scale[0] + ((code - 1) / FINE) * (scale[1] - scale[0]) : NaN);

/** The color of a value: 1 to 255, or 0 if unknown. @param {number} value @param {[number, number]} scale */
const graded = (value, [low, high]) => (Number.isNaN(value) ? 0 : 1 + Math.round(COARSE * Math.min(1, Math.max(0, (value - low) / (high - low || 1)))));

/** The lives of a species, in order of their uids. */
class Lives {
  /** @param {StoredKind} kind @param {ArrayBuffer} buffer @param {Stored} head */
  constructor(kind, buffer, head) {
    this.kind = kind;
    this.head = head;
    const columns = (this.columns = read(kind.columns, buffer)), { step, hello } = head;
    this.n = columns.uid.length;
    this.uid = new Float64Array(columns.uid); // stored as differences
    this.born = new Int32Array(columns.born);
    this.end = new Int32Array(this.n); // the tick of death, or the first tick without it
    this.start = new Uint32Array(this.n + 1); // of its states
    for (let i = 0; i < this.n; i++) {
      if (i) (this.uid[i] += this.uid[i - 1]), (this.born[i] += this.born[i - 1]);
      this.end[i] = this.born[i] + columns.span[i];
      this.start[i + 1] = this.start[i] + Math.max(0, Math.ceil(this.end[i] / step) - this.first(i));
    }
    this.axes = AXES.filter((axis) => columns[axis]).map((axis) => [columns[axis], columns[`${axis} later`], columns[`${axis} at death`]]);
    this.now = new Float64Array(6);
    this.goal = new Float64Array(6);
    this.wraps = hello.edges === "torus";
    const shows = hello.species.find(({ name }) => name === kind.name)?.shows;
    this.size = shows?.size && `gene:${shows.size[0]}`; // columns of genes that show in bodies
    this.adult = shows?.grows?.[0] === "age" && !this.size ? shows.grows[1] : 0; // age [s] of full size
    this.stripes = shows?.stripes && `gene:${shows.stripes[0]}`;
    /** @type {Record<string, [number, number]>} */
    this.scales = { ...kind.scales, age: [0, kind.oldest * hello.dt] };
    /** @type {{uid: number, rows: Set<number>}} descendants of an organism */
    this.kin = { uid: NaN, rows: new Set() };
  }

  /** Number of the first stored tick of a life. @param {number} i */
  first(i) {
    return Math.ceil(Math.max(this.born[i], this.head.hello.first) / this.head.step);
  }

  /** @param {number} uid */
  row(uid) {
    let low = 0, high = this.n;
    while (low < high) this.uid[(low + high) >> 1] < uid ? (low = ((low + high) >> 1) + 1) : (high = (low + high) >> 1);
    return this.uid[low] === uid ? low : -1;
  }

  /** The living at the end of a tick. @param {number} tick */
  alive(tick) {
    const rows = [];
    for (let i = 0; i < this.n; i++) if (this.born[i] <= tick && tick < this.end[i]) rows.push(i);
    return rows;
  }

  /** The state in a stored row, at birth or at death. @param {number} i @param {number} row @param {Place} [to] output */
  at(i, row, to = new Float64Array(6)) {
    const { columns: c, axes, kind: { scales } } = this, later = row >= 0;
    for (let axis = 0; axis < axes.length; axis++) {
      const [born, stored, died] = axes[axis];
      to[axis] = (born[i] + (later ? stored[row] : row === DEATH ? died[i] : 0)) & TOP;
    }
    to[3] = later ? c["heading later"][row] : NaN;
    to[4] = valueOf(later ? c["energy later"][row] : c[row === DEATH ? "energy at death" : "energy"][i], scales.energy);
    to[5] = later && scales.happiness ? valueOf(c["happiness later"][row], scales.happiness) : NaN;
    return to;
  }

  /** The state at a tick, interpolated between birth, stored states and death; valid until the next call. @param {number} i @param {number} tick */
  state(i, tick) {
    const { step, hello } = this.head, { now, goal } = this, first = this.first(i), k = Math.floor(tick / step) - first, count = this.start[i + 1] - this.start[i];
    const since = k < 0 ? Math.max(this.born[i], hello.first) : (first + k) * step, next = k + 1 < count;
    this.at(i, k < 0 ? BIRTH : this.start[i] + k, now);
    if (next || this.columns.dies[i]) this.at(i, next ? this.start[i] + k + 1 : DEATH, goal);
    else goal.set(now);
    const until = next ? (first + k + 1) * step : this.end[i], share = Math.min(1, (tick - since) / Math.max(1, until - since));
    for (let part = 0; part < 6; part++) {
      if (Number.isNaN(now[part])) now[part] = goal[part];
      const way = goal[part] - now[part], around = part === 3 ? TURN : part < 2 && this.wraps ? TOP : 0;
      if (Number.isNaN(way)) continue;
      now[part] += share * (way - (around && around * Math.round(way / around)));
      if (around) now[part] = (now[part] + around) % around;
    }
    return now;
  }

  /** @param {number} i @param {number} tick @param {string} by @param {Place} state */
  colour(i, tick, by, state) {
    if (by === "energy") return graded(state[4], this.scales.energy);
    if (by === "happiness") return this.scales.happiness ? graded(state[5], this.scales.happiness) : 0;
    if (by === "age") return graded((tick - this.born[i]) * this.head.hello.dt, this.scales.age);
    if (by.startsWith("kin:")) return this.descends(Number(by.slice(4))).has(i) ? 255 : 0;
    return this.columns[by]?.[i] ?? 0;
  }

  /** The rows of an organism and its descendants. @param {number} uid */
  descends(uid) {
    if (this.kin.uid === uid) return this.kin.rows;
    const rows = new Set([this.row(uid)]);
    for (let i = 0; i < this.n; i++) if (this.parents(i).some((parent) => parent >= uid && rows.has(this.row(parent)))) rows.add(i);
    this.kin = { uid, rows };
    return rows;
  }

  /** @param {number} i */
  parents(i) {
    return [this.columns.parent[i], this.columns.parent2[i]].filter(Boolean);
  }

  /** The longest line of ancestors; null if some are not in the file. @param {number} i @returns {number | null} */
  generation(i) {
    if (this.kind.every > 1) return null;
    let line = new Set([i]), length = -1;
    for (; line.size; length++) line = new Set([...line].flatMap((one) => this.parents(one)).map((uid) => this.row(uid)).filter((row) => row >= 0));
    return length;
  }

  /** @param {Place} place @returns {number[]} x, y, z [m] */
  metres(place) {
    return AXES.map((_, axis) => (place[axis] / TOP) * (this.head.hello.size[axis] ?? 0));
  }

  /** The message "organism". @param {number} i @param {number} tick */
  organism(i, tick) {
    const { hello, step, causes } = this.head, { columns: c, born, end } = this;
    const died = c.dies[i] ? { tick: end[i], cause: causes[c.cause[i]] ?? "unknown", killer: c.killer[i] || null } : null;
    const alive = born[i] <= tick && tick < end[i], now = Math.min(tick, end[i]);
    const states = Array.from({ length: this.start[i + 1] - this.start[i] }, (_, k) => ({ tick: (this.first(i) + k) * step, row: this.start[i] + k })).filter((one) => one.tick < end[i]);
    const far = (/** @type {{tick: number}} */ one) => Math.abs(one.tick - now);
    const near = alive || born[i] <= tick ? states.filter((one) => alive || one.tick <= now).sort((a, b) => far(a) - far(b))[0] : undefined;
    const stored = near && (!alive || far(near) < tick - born[i] || far(near) === 0) ? near : undefined;
    const state = this.at(i, stored?.row ?? BIRTH), heading = state[3], energy = state[4], place = this.metres(state);
    const trace = states.filter((one) => one.tick <= now), known = born[i] <= tick;
    const when = stored ? `State at tick ${stored.tick.toLocaleString("en")}.` : `State at birth, tick ${born[i].toLocaleString("en")}.`;
    const plain = (/** @type {number} */ value) => (Number.isNaN(value) ? null : value);
    return {
      kind: "organism", uid: this.uid[i], species: this.kind.name, alive, born: born[i], died, age: Math.max(0, now - born[i]) * hello.dt, sex: null,
      energy: known ? plain(energy) : null, energy_max: this.scales.energy[1], place: known ? place : null, heading: known && stored ? (heading * 2 * Math.PI) / TURN : null,
      parents: this.parents(i), children: this.children(this.uid[i]), generation: this.generation(i), genome: null, nerves: null, detail: stored ? "snapshot" : "record",
      trace: { tick: trace.map((one) => one.tick), ...Object.fromEntries(["energy", "happiness"].map((name) => [name, trace.map(({ row }) => plain(this.at(i, row)[name === "energy" ? 4 : 5]))])) },
      note: known ? `${stored?.tick === tick ? "" : `${when} `}Stored every ${step > 1 ? `${step} ticks` : "tick"}, without its nervous system.${this.kind.every > 1 ? ` Only 1 in ${this.kind.every} of its species is in this file, so kin may be missing.` : ""}` : "Not born yet.",
      ...(alive || !known || !stored ? {} : { as_of: stored.tick }),
    };
  }

  /** @param {number} uid */
  children(uid) {
    const { parent, parent2 } = this.columns, found = [];
    for (let i = 0; i < this.n; i++) if (parent[i] === uid || parent2[i] === uid) found.push(this.uid[i]);
    return found.slice(-CHILDREN);
  }
}

export class Shelf {
  /** @param {Stored} head @param {ArrayBuffer} clock @param {ArrayBuffer[]} kinds */
  constructor(head, clock, kinds) {
    this.readyState = WebSocket.OPEN;
    this.head = head;
    this.clock = read(head.clock.columns, clock);
    this.lives = kinds.map((buffer, k) => new Lives(head.kinds[k], buffer, head));
    this.tick = head.hello.first;
    this.last = Number(head.hello.last);
    /** @type {number | null} ticks per second */
    this.speed = 10;
    this.playing = false;
    this.by = "species";
    /** @type {number | null} */
    this.selected = null;
    this.number = 0; // of frames
    this.seen = this.panel = ""; // contents of the last frame and panel
    this.marked = -1;
    this.fated = -1; // the last tick whose deaths were sent
    this.news = true;
    this.stateAt = this.panelAt = -Infinity;
    this.then = performance.now();
    this.part = 0; // of the next tick
    this.onopen = () => {};
    this.onclose = () => {};
    this.onmessage = (/** @type {{data: string | ArrayBuffer}} */ _) => {};
    setTimeout(() => {
      this.onopen();
      for (const message of [head.hello, head.story, head.series]) this.tell(message);
      setInterval(() => this.turn(performance.now()), PACE);
    });
  }

  /** @param {object} message */
  tell(message) {
    this.onmessage({ data: JSON.stringify(message) });
  }

  /** @param {string} words a request as JSON */
  send(words) {
    const request = JSON.parse(words), { kind } = request;
    if (kind === "ack" || kind === "field") return;
    if (kind === "play" || kind === "pause") this.playing = kind === "play";
    else if (kind === "step") [this.playing, this.tick] = [false, Math.min(this.last, this.tick + (request.ticks ?? 1))];
    else if (kind === "seek") this.tick = Math.min(this.last, Math.max(this.head.hello.first, Math.round(request.tick)));
    else if (kind === "speed") this.speed = request.value;
    else if (kind === "colour") this.by = request.by;
    else if (kind === "select") [this.selected, this.panel, this.panelAt] = [request.uid, "", -Infinity];
    else if (kind === "why") this.tell(this.head.why);
    else this.tell({ kind: "said", level: "info", text: kind === "tree" ? "Family trees are not in this file." : "This is not in the file.", field: kind });
    this.news = true;
  }

  /** Advances time, and sends what the page lacks. @param {number} now [ms] */
  turn(now) {
    if (this.playing) {
      this.part += ((now - this.then) / 1000) * (this.speed ?? FULL);
      this.tick = Math.min(this.last, this.tick + Math.floor(this.part));
      this.part %= 1;
      if (this.tick === this.last) [this.playing, this.news] = [false, true];
    }
    this.then = now;
    const { tick, by, head } = this, seen = `${tick} ${by}`, panel = `${tick} ${this.selected}`;
    const land = head.marks.findLastIndex(([since]) => since <= tick);
    if (land !== this.marked) this.tell(head.marks[(this.marked = land)][1]);
    if (this.selected !== null && panel !== this.panel && now >= this.panelAt + PANELS) {
      [this.panel, this.panelAt] = [panel, now];
      this.organism(this.selected);
    }
    if (seen !== this.seen) {
      this.onmessage({ data: this.frame() });
      const list = this.fates(tick < this.fated ? -1 : this.fated);
      [this.seen, this.fated, this.news] = [seen, tick, this.news || !this.playing];
      if (list.length) this.tell({ kind: "fates", list });
    }
    if (!this.news && !(this.playing && now >= this.stateAt + STATES)) return;
    [this.news, this.stateAt] = [false, now];
    const n = Object.fromEntries(this.lives.map(({ kind }) => [kind.name, this.clock[`n ${kind.name}`][tick - head.hello.first]]));
    const scales = Object.fromEntries(this.lives.filter((lives) => lives.scales[by]).map((lives) => [lives.kind.name, lives.scales[by]]));
    this.tell({ kind: "state", playing: this.playing, speed: this.speed, tick, rate: this.playing ? this.speed ?? FULL : 0, done: tick === this.last, n, scales, pages: 1 });
  }

  /** @param {number} uid */
  organism(uid) {
    const lives = this.lives.find((one) => one.row(uid) >= 0);
    if (lives) return this.tell(lives.organism(lives.row(uid), this.tick));
    this.selected = null;
    this.tell({ kind: "said", level: "error", text: `Organism ${uid} is not in this file.`, field: "select" });
  }

  /** Deaths of animals within the last ticks. @param {number} after */
  fates(after) {
    const { tick } = this, found = [];
    for (const [k, lives] of this.lives.entries()) {
      if (!this.head.hello.species[k].moves) continue;
      for (let i = 0; i < lives.n; i++) {
        if (!lives.columns.dies[i] || lives.end[i] > tick || lives.end[i] <= Math.max(after, tick - TICKS)) continue;
        const place = lives.metres(lives.at(i, DEATH));
        found.push([lives.end[i], k, lives.uid[i], ...place, lives.columns.killer[i]]);
      }
    }
    return found.sort((a, b) => a[0] - b[0]).slice(-MOST);
  }

  /** All organisms at this tick, as a binary frame. */
  frame() {
    const { tick, by, lives, clock, head } = this, objects = head.hello.objects?.length ?? 0;
    const rows = lives.map((one) => one.alive(tick)), things = clock.objects.subarray(objects);
    const counts = [...rows.map(({ length }) => length), ...clock.objects.subarray(0, objects)];
    const all = counts.reduce((sum, n) => sum + n, 0), wide = Number(lives.some((one) => one.n && one.uid[one.n - 1] >= HALF));
    const deep = head.hello.size.length > 2, more = Number(deep && lives.some(({ size, stripes }) => size || stripes)); // genes follow
    const buffer = new ArrayBuffer(HEAD + 4 * (counts.length + (WORDS + wide + more) * all)), view = new DataView(buffer);
    const at = tick - head.hello.first;
    [MAGIC, ++this.number, tick, wide + 2 * more].forEach((word, i) => view.setUint32(4 * i, word, true));
    view.setFloat32(16, clock.light?.[at] ?? 1, true);
    view.setFloat32(20, clock.sun?.[at] ?? Math.PI / 2, true);
    [counts.length, ...counts].forEach((word, i) => view.setUint32(24 + 4 * i, word, true));
    const words = new Uint32Array(buffer, HEAD + 4 * counts.length);
    let next = 0, upper = WORDS * all, shown = (WORDS + wide) * all;
    rows.forEach((some, k) => some.forEach((i) => {
      const state = lives[k].state(i, tick), { columns, size, stripes, adult } = lives[k];
      const genes = (size ? columns[size][i] : adult ? graded((tick - lives[k].born[i]) * head.hello.dt, [0, adult]) : 0) | (stripes ? columns[stripes][i] << 8 : 0);
      words[next++] = Math.round(state[0]) | (Math.round(state[1]) << 16);
      words[next++] = (deep ? Math.round(state[2]) : genes) | ((Math.round(state[3] || 0) & 255) << 16) | (lives[k].colour(i, tick, by, state) << 24);
      words[next++] = lives[k].uid[i] % HALF;
      if (wide) words[upper++] = Math.floor(lives[k].uid[i] / HALF);
      if (more) words[shown++] = genes;
    }));
    words.set(things, next);
    return buffer;
  }
}
