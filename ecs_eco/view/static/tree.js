// The family tree in the organism panel: loaded while open, drawn as SVG, navigable by keyboard.

import { $, h, number, s } from "./dom.js";
import { BOX, Genealogy } from "./genealogy.js";

/** @typedef {import("./protocol.js").TreeMessage} TreeMessage @typedef {import("./protocol.js").Relative} Relative @typedef {import("./genealogy.js").Place} Place */

const PACE = 2000; // [ms] between requests in a live world
const GENERATIONS = [5, 2]; // generations of ancestors shown for organisms with one parent and with two
const TOP = 6; // [px]
const AXIS = 44; // [px]
const WAYS = /** @type {Record<string, [number, number]>} */ ({ ArrowUp: [0, -1], ArrowDown: [0, 1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] });

export class Tree {
  /**
   * @param {{select: (uid: number) => void, ask: () => void, clade: (life: import("./protocol.js").Relative) => ReturnType<typeof import("./colours.js").cladeOf>, colourOf: (name: string) => string}} calls
   */
  constructor(calls) {
    this.calls = calls;
    /** @type {import("./protocol.js").Hello | null} */
    this.hello = null; // the hello message of the organism's world
    this.second = false; // whether the organism is in the second world
    /** @type {number | null} */
    this.uid = null;
    /** @type {TreeMessage | null} */
    this.tree = null;
    this.tick = 0;
    this.at = 0; // time of the last request
    /** @type {number | null} */
    this.asked = null; // uid in the last request
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.later = undefined;
    /** @type {Map<Place, SVGElement>} */
    this.nodes = new Map();
    this.up = 0;
    this.drawn = "";
    /** @type {Set<string>} */
    this.open = new Set();
    this.back = false; // whether the previous tree had the keyboard focus
    this.box = h("div", { class: "tree-box" });
    this.root = h("details", { class: "tree", ontoggle: () => this.look() }, h("summary", { text: "Family tree" }), this.box);
  }

  /** Shows the tree of an organism if the section is open. @param {import("./protocol.js").Organism} organism @param {import("./protocol.js").Hello} hello of its world */
  show(organism, hello) {
    const second = organism.second ?? false;
    if (organism.uid !== this.uid || second !== this.second) {
      this.forget();
      this.uid = organism.uid;
    }
    [this.hello, this.second] = [hello, second];
    this.look();
  }

  forget() {
    this.back ||= this.box.contains(document.activeElement);
    this.uid = this.tree = this.asked = null;
    clearTimeout(this.later);
    this.drawn = "";
    this.open.clear();
    this.up = 0;
    this.box.replaceChildren();
  }

  /** Called when time reaches a tick. @param {number} tick */
  time(tick) {
    if (tick === this.tick) return;
    this.tick = tick;
    if (this.uid === null || !this.root.open || $("organism").hidden) return;
    if (this.hello?.mode === "live") this.look();
    else this.draw();
  }

  /** Requests the tree if the section is open, and at intervals in a live world. */
  look() {
    if (this.uid === null || !this.root.open) return;
    const stale = this.hello?.mode === "live" && this.tree?.tick !== this.tick;
    if (this.tree && !stale) return;
    const now = performance.now();
    const wait = this.asked === this.uid ? PACE - (now - this.at) : 0;
    clearTimeout(this.later);
    if (wait > 0) return void (this.later = setTimeout(() => this.look(), wait));
    [this.at, this.asked] = [now, this.uid];
    this.calls.ask();
  }

  /** Requests the tree again if the section is open, because colors have changed. */
  again() {
    this.asked = this.tree = null;
    this.look();
  }

  /** @param {TreeMessage} tree */
  take(tree) {
    if (tree.uid !== this.uid || (tree.second ?? false) !== this.second) return;
    this.tree = { ...tree, tick: this.tick };
    this.up ||= GENERATIONS[tree.lives[0].parents.length > 1 ? 1 : 0];
    this.draw();
  }

  /** @param {string} why */
  refuse(why) {
    this.box.replaceChildren(h("p", { class: "about", text: why }));
    this.drawn = "";
  }

  /** The state of an organism at the displayed tick. @param {Relative} life */
  state(life) {
    if (life.born === null) return "unknown";
    if (life.died && life.died.tick <= this.tick) return "dead";
    return life.born > this.tick ? "unborn" : "alive";
  }

  /** @param {boolean} [anew] redraw even if nothing has changed */
  draw(anew = false) {
    const { tree } = this;
    if (!tree) return;
    const key = JSON.stringify([tree.lives, tree.siblings, [...this.open], this.up, tree.lives.map((life) => this.state(life))]);
    if (key === this.drawn && !anew) return this.ages();
    this.drawn = key;
    const laid = new Genealogy(tree, this.open, this.up);
    const focus = this.box.querySelector("g:focus")?.getAttribute("data-key") ?? (this.back ? String(tree.uid) : null);
    const scrolled = this.box.querySelector(".tree-scroll");
    const before = scrolled && { width: scrolled.scrollWidth, left: scrolled.scrollLeft };
    const [width, height] = [laid.width + 4, laid.height + 2 * TOP];
    const drawing = s("svg", { class: "tree-drawing", width, height, viewBox: `-2 ${-TOP} ${width} ${height}`, role: "group", "aria-label": `Family tree of ${tree.lives[0].species} #${tree.uid}; move between organisms with the arrow keys` });
    for (const [, y] of laid.axis) drawing.append(s("line", { class: "tree-tick", x1: -2, x2: width, y1: y + BOX[1] / 2, y2: y + BOX[1] / 2 }));
    for (const place of laid.places.values()) for (const to of place.to) drawing.append(this.line(place, /** @type {Place} */ (laid.places.get(to))));
    this.nodes = new Map([...laid.places.values()].map((place) => [place, this.node(place, tree.uid)]));
    drawing.append(...this.nodes.values());
    const scrolls = h("div", { class: "tree-scroll" }, drawing);
    this.box.replaceChildren(h("div", { class: "tree-row" }, this.axis(laid, height), scrolls));
    const middle = laid.places.get(String(tree.uid))?.x ?? 0;
    scrolls.scrollLeft = before?.width === scrolls.scrollWidth ? before.left : middle - scrolls.clientWidth / 2;
    this.ages();
    this.back = false;
    if (focus) this.focus([...this.nodes].find(([place]) => place.key === focus) ?? [...this.nodes].find(([place]) => place.life?.uid === tree.uid));
  }

  /** Draws the ticks of birth on the left. @param {Genealogy} laid @param {number} height */
  axis(laid, height) {
    const root = s("svg", { class: "tree-axis", width: AXIS, height, viewBox: `0 ${-TOP} ${AXIS} ${height}`, "aria-hidden": "true" });
    let last = -Infinity;
    for (const [tick, y] of laid.axis) {
      if (y - last < 13) continue;
      last = y;
      root.append(s("text", { x: AXIS - 6, y: y + BOX[1] / 2 + 4, "text-anchor": "end" }, number(tick)));
    }
    root.append(s("text", { x: 0, y: 4 }, "born"), s("line", { x1: AXIS - 1, x2: AXIS - 1, y1: BOX[1] / 2, y2: height - TOP }));
    return root;
  }

  /** @param {Place} from @param {Place} to */
  line(from, to) {
    const [top, bottom] = [from.y + (from.life ? BOX[1] : 20), to.y];
    return s("path", { class: to.life && from.life ? "tree-line" : "tree-line more", d: `M${from.x} ${top}V${to.above ? bottom - 9 : top + 9}H${to.x}V${bottom}` });
  }

  /** @param {Place} place @param {number} uid of the focal organism */
  node(place, uid) {
    const { life, x, y, hidden } = place;
    const left = x - BOX[0] / 2;
    const does = () => (life ? life.uid !== uid && this.calls.select(life.uid) : this.more(place));
    const about = life ? this.words(life) : place.what;
    const acts = life ? life.born !== null : place.opens;
    const root = s("g", { class: `tree-node ${life ? this.state(life) : "more"}${life?.uid === uid ? " focal" : ""}`, "data-key": place.key, role: acts ? "button" : "img",
      tabindex: life?.uid === uid ? 0 : -1, "aria-label": about, "aria-current": life?.uid === uid ? "true" : null,
      ...(acts ? { onclick: does } : {}), onkeydown: (/** @type {KeyboardEvent} */ event) => this.key(event, place, does) }, s("title", {}, about));
    if (!life) {
      root.append(s("rect", { x: left + 8, y, width: BOX[0] - 16, height: 20, rx: 10 }), s("text", { x, y: y + 14, class: "name" }, `+${number(hidden)}`));
      return root;
    }
    const dead = this.state(life) === "dead" && life.died;
    root.append(s("rect", { x: left, y, width: BOX[0], height: BOX[1], rx: 7, style: life.species ? `stroke: ${this.calls.colourOf(life.species)}` : null }),
      s("text", { x, y: y + 14, class: "name" }, fit(`#${life.uid}`, BOX[0] - 6, 11.5)),
      s("text", { x, y: y + 26, class: dead ? "cause" : "" }, fit(dead ? `† ${dead.cause}` : SAYS[this.state(life)] ?? "", BOX[0] - 6, 10)),
      s("text", { x, y: y + 37, class: "age" }, dead ? `${number(life.age)} s` : ""));
    const clade = this.calls.clade(life);
    if (clade) root.append(s("circle", { class: "clade", cx: left + 2, cy: y + 2, r: 5.5, fill: clade.fill }));
    return root;
  }

  /** Describes an organism. @param {Relative} life */
  words(life) {
    if (life.born === null) return `#${life.uid}, no data`;
    const state = this.state(life);
    const fate = state === "dead" ? `${life.died?.cause} at ${number(life.age)} s, tick ${number(life.died?.tick)}` : state === "unborn" ? "not yet born" : "alive";
    const young = life.young === null ? "" : `, ${number(life.young)} ${life.young === 1 ? "child" : "children"}`;
    const clade = this.calls.clade(life);
    return `${life.species} #${life.uid}, born at tick ${number(life.born)}, ${fate}${young}${clade ? `, ${clade.words}` : ""}`;
  }

  /** Updates the ages of living organisms. */
  ages() {
    for (const [{ life }, node] of this.nodes) {
      const at = node.querySelector(".age");
      if (at && life && life.born !== null && this.state(life) === "alive") at.textContent = `${number((this.tick - life.born) * (this.hello?.dt ?? 1))} s`;
    }
  }

  /** Expands a group. @param {Place} place */
  more({ key }) {
    if (key.startsWith("up ")) this.up += GENERATIONS[(this.tree?.lives[0].parents.length ?? 0) > 1 ? 1 : 0];
    else this.open.add(key);
    this.back = this.box.contains(document.activeElement);
    this.draw();
  }

  /** @param {KeyboardEvent} event @param {Place} place @param {() => void} does */
  key(event, place, does) {
    const way = WAYS[event.key];
    if (way) this.focus(this.nearest(place, way));
    else if (event.key === "Enter" || event.key === " ") does();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** The next box in a direction, preferably along a line. @param {Place} from @param {[number, number]} way */
  nearest(from, [right, down]) {
    const kin = (/** @type {Place} */ { key, to }) => (down > 0 ? from.to.includes(key) : to.includes(from.key));
    const nodes = [...this.nodes];
    const way = (/** @type {Place} */ { x, y }) => (right ? right * (x - from.x) : down * (y - from.y));
    const cost = (/** @type {Place} */ { x, y }) => (right ? Math.abs(x - from.x) + 3 * Math.abs(y - from.y) : Math.abs(y - from.y) + 3 * Math.abs(x - from.x));
    const ahead = nodes.filter(([place]) => way(place) > 0);
    const along = down ? ahead.filter(([place]) => kin(place)) : [];
    return (along.length ? along : ahead).sort(([a], [b]) => cost(a) - cost(b))[0];
  }

  /** @param {[Place, SVGElement] | undefined} found */
  focus(found) {
    if (!found) return;
    for (const node of this.nodes.values()) node.setAttribute("tabindex", node === found[1] ? "0" : "-1");
    found[1].focus();
  }
}

const SAYS = /** @type {Record<string, string>} */ ({ alive: "alive", unborn: "not yet", unknown: "unknown" });
const pen = document.createElement("canvas").getContext("2d");

/** The longest prefix of a text that fits: whole words ("† eaten" for "† eaten by wolf") or part of a word.
 * @param {string} text @param {number} room [px] @param {number} size [px] */
export function fit(text, room, size) {
  if (!pen) return text;
  pen.font = `600 ${size}px ${getComputedStyle(document.body).fontFamily}`;
  const words = text.split(" ");
  while (words.length > 2 && pen.measureText(words.join(" ")).width > room) words.pop();
  text = words.length < text.split(" ").length ? words.join(" ").replace(/ (by|of|from)$/, "") : text;
  if (pen.measureText(text).width <= room) return text;
  let cut = text;
  while (cut.length > 1 && pen.measureText(`${cut}…`).width > room) cut = cut.slice(0, -1);
  return `${cut.trimEnd()}…`;
}
