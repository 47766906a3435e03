// Plays the story of a recorded run in a minute: the camera flies to each event, with a caption. In a live world, it flies to events as they happen.

import { number } from "./dom.js";
import * as overlay from "./overlay.js";
import { Vector3 } from "./vendor.js";

/** @typedef {import("./protocol.js").Entry} Entry @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{from: number, to: number, entry: Entry | null}} Scene ticks and the event; null: the whole world */

const [MINUTE, LONGEST] = [60, 8]; // [s] of a story and of a scene
const MOST = 10; // maximum number of events
const [LEAD, TAIL] = [30, 10]; // [ticks] before and after an event
const RANK = ["extinct", "sweep", "birth", "return", "boom", "crash"]; // if there are too many events, the last kinds are left out
const CLOSE = 0.08; // distance of the camera as a share of the world's diagonal
const FLIGHT = 1800; // [ms]

/** The scenes of a story in order of time; each begins where the one before has ended, or later. @param {Entry[]} entries @param {number} first @param {number} last tick @returns {Scene[]} */
export function scenes(entries, first, last) {
  const ranked = [...entries].sort((a, b) => RANK.indexOf(a.kind) - RANK.indexOf(b.kind)).slice(0, MOST).sort((a, b) => a.tick - b.tick);
  const all = [{ from: first, to: Math.min(last, first + TAIL), entry: /** @type {Entry | null} */ (null) }];
  ranked.forEach((entry, k) => {
    const from = Math.max(all[k].to, entry.tick - LEAD), gap = (ranked[k + 1]?.tick ?? last) - entry.tick;
    all.push({ from, to: Math.min(last, Math.max(from + 1, entry.tick + Math.min(TAIL, Math.ceil(gap / 2)))), entry });
  });
  return [...all, { from: Math.max(all[all.length - 1].to, last - TAIL), to: last, entry: null }];
}

export class Tour {
  /** @param {{page: () => {stage: Stage, charts: import("./charts.js").Charts, story: import("./story.js").Story, loop: import("./loop.js").Loop, hello: import("./protocol.js").Hello} | null, send: (request: {kind: string, [key: string]: unknown}) => void, speed: () => number | null, look: () => void}} calls */
  constructor(calls) {
    this.calls = calls;
    this.on = false;
    this.timer = this.flights = 0;
    /** @type {number | null} the organism in the middle of the scene */
    this.uid = null;
  }

  /** Starts or stops. */
  toggle() {
    const page = this.calls.page();
    if (this.on || !page) return this.stop();
    this.turn(true);
    if (page.hello.mode === "live") return overlay.flash("The camera will fly to each event as it happens.");
    page.loop.set(null);
    this.speed = this.calls.speed();
    this.scenes = scenes(page.story.entries, page.hello.first, page.hello.last ?? 0);
    this.next(0);
  }

  /** @param {boolean} on */
  turn(on) {
    this.on = on;
    clearTimeout(this.timer);
    clearInterval(this.flights);
    this.calls.page()?.story.player.setAttribute("aria-pressed", String(on));
  }

  stop() {
    if (!this.on) return;
    this.turn(false);
    overlay.notice(null);
    if (this.calls.page()?.hello.mode === "live") return;
    this.calls.send({ kind: "pause" });
    this.calls.send({ kind: "speed", value: this.speed });
  }

  /** Plays scene k and those after it. @param {number} k */
  next(k) {
    const page = this.calls.page(), scene = this.scenes?.[k];
    if (!page || !scene) return this.stop();
    const seconds = Math.min(LONGEST, MINUTE / (this.scenes?.length ?? 1)), { from, to, entry } = scene;
    if (!k || from > page.stage.tick + 1) this.calls.send({ kind: "seek", tick: from });
    this.calls.send({ kind: "speed", value: Math.max(0.5, (to - from) / seconds) });
    this.calls.send({ kind: "play" });
    const { ticks, lines } = page.charts, tick = k ? to : from, at = ticks.findLastIndex((one) => one <= tick);
    const numbers = page.hello.species.map(({ name }) => `${number(lines.n[name]?.[at])} ${name}`);
    this.caption(entry ?? { tick, text: `${k ? "The end" : page.hello.title || page.hello.world}: ${numbers.join(", ")}`, cause: "" });
    this.visit(entry);
    this.timer = setTimeout(() => this.next(k + 1), 1000 * seconds);
  }

  /** Called when an event happens in a live world; returns whether the tour shows it. @param {Entry} entry */
  tell(entry) {
    if (this.on && this.calls.page()?.hello.mode === "live") this.caption(entry), this.visit(entry);
    return this.on;
  }

  /** @param {{tick: number, text: string, cause: string}} entry */
  caption({ tick, text, cause }) {
    overlay.notice([`Tick ${number(tick)}. ${text}.`, cause].filter(Boolean).join(" "), { text: "Stop", does: () => this.stop() });
  }

  /** Flies to the species of an event and stays with one of its organisms; null: shows the whole world. @param {Entry | null} entry */
  visit(entry) {
    clearInterval(this.flights);
    this.calls.look();
    const stage = this.calls.page()?.stage;
    if (!stage || !entry?.species) return;
    const { eye } = stage;
    /** @type {Vector3 | null} */
    let last = null, happened = false;
    this.uid = null;
    this.flights = setInterval(() => {
      if (!happened && stage.tick >= entry.tick) [happened, this.uid] = [true, entry.kind === "birth" ? null : this.uid]; // the newborn is there now
      const place = (this.uid !== null && stage.place(this.uid)) || this.pick(stage, entry, last);
      if (!place) return; // the last one is dead: the camera stays
      last = place;
      eye.touched = true; // keeps this view when resized
      eye.fly([place.clone().addScaledVector(eye.direction("side"), Math.max(CLOSE * eye.span, 3 * eye.controls.minDistance)), place], FLIGHT);
      stage.dirty = true;
    }, FLIGHT / 2);
  }

  /** Chooses an organism: the youngest after a birth, else the nearest to a place or, without one, where there are most. @param {Stage} stage @param {Entry} entry @param {Vector3 | null} near */
  pick(stage, { tick, species, kind }, near) {
    const layer = stage.layers.find((one) => one.kind.name === species), n = layer?.block.n ?? 0;
    if (!layer || !n) return null;
    const born = kind === "birth" && stage.tick >= tick, some = born ? n : Math.min(n, 150);
    const rows = Array.from({ length: some }, (_, i) => Math.floor((i * n) / some));
    const places = rows.map((row) => stage.spot(layer, row, new Vector3())), reach = stage.eye.span / 12;
    const worth = (/** @type {Vector3} */ place, /** @type {number} */ i) =>
      born ? layer.uid(rows[i]) : near ? -place.distanceTo(near) : places.filter((other) => other.distanceTo(place) < reach).length;
    const worths = places.map(worth), best = worths.indexOf(Math.max(...worths));
    this.uid = layer.uid(rows[best]);
    return places[best];
  }
}
