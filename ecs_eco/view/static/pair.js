// A second world next to the first: a branch or an unrelated world. Both share one clock and one camera.

import { $, announce, h, number } from "./dom.js";
import { kindsOf, sign } from "./marks.js";
import { Other } from "./other.js";
import * as overlay from "./overlay.js";
import { point } from "./pointer.js";
import { Stage } from "./stage.js";

/** @typedef {import("./protocol.js").Beside} Beside */
/** @typedef {import("./eye.js").Eye} Eye */
/** @typedef {{stage: Stage, charts: import("./charts.js").Charts, act: import("./act.js").Act | null}} Page */
/** @typedef {{stage: Stage, other: Other, names: string[], parts: Element[], ring: HTMLElement, tag: HTMLElement, here: HTMLElement, frames: number, recipe: Beside["recipe"], at: number | null, change: string, state?: Beside["state"], seen: number[]}} Two `seen`: position and target of the first camera at the last picture */

/**
 * @param {import("./connection.js").Connection} connection
 * @param {{page: () => Page | null, chosen: import("./chosen.js").Chosen, select: (uid: number | null, second?: boolean) => void, own: () => boolean, by: () => string, count: () => void}} calls
 */
export function pair(connection, calls) {
  /** @type {Two | null} */
  let two = null;

  connection.on("hello", () => close(true));
  connection.on("beside", (message) => {
    const page = calls.page();
    if (!page) return;
    if (message.closed !== undefined) return close();
    if (message.hello) two = open(page, message);
    if (!two) return;
    if (message.series) two.other.add(message.series);
    if (message.fates) two.stage.over.fates(message.fates);
    if (message.marks) {
      two.stage.ground.fence(message.marks.fences ?? []);
      two.stage.ground.use(message.marks.roads ?? [], message.marks.areas ?? []);
      two.stage.dirty = true;
    }
    if (message.state) say(two, message.state);
  });
  $("pairClose").addEventListener("click", () => connection.send({ kind: "whatif", close: true }));
  $("pairAgain").addEventListener("click", () => two?.recipe && again(two.recipe));

  /** @param {Page} page @param {Beside} message @returns {Two} */
  function open(page, { hello, names = ["", ""], at = null, change = "", recipe = null }) {
    close();
    const canvas = h("canvas", { id: "canvas2", tabindex: 0, role: "application", "aria-label": `The second world in three dimensions: ${names[1]}. Arrow keys move both.` });
    const over = h("canvas", { id: "over2", "aria-hidden": "true" });
    const ring = h("div", { class: "ring", hidden: true });
    const here = h("div", { class: "pane-name second", text: names[1], title: change || names[1] });
    const tag = h("div", { class: "tag", id: "trailLabel2", hidden: true });
    const parts = [canvas, over, h("div", { class: "pane-name first", text: names[0] }), here, ring, tag];
    $("over").after(...parts);
    $("stage").classList.add("pair");
    const stage = new Stage(canvas, /** @type {import("./protocol.js").Hello} */ (hello), over);
    stage.eye.touched = true; // this camera copies the view of the first camera
    [stage.peer, page.stage.peer] = [page.stage, stage];
    /** @type {Two} */
    const made = { stage, other: new Other(page.charts, names, at), names, parts, ring, tag, here, frames: page.stage.frames, recipe, at, change, seen: [] };
    stage.onrender = () => overlay.circle(stage, ring, tag);
    point(canvas, { page: () => ({ stage, act: page.act }), select: (uid) => calls.select(uid, true) });
    stage.eye.controls.addEventListener("change", () => {
      if (copying || two !== made) return;
      look(stage, page.stage);
      page.stage.eye.touched = true;
      made.seen = sight(page.stage.eye); // this view need not be copied back
    });
    page.stage.eye.cover = () => [...overlay.covered(), ...overlay.covered([canvas.offsetLeft, canvas.offsetTop])];
    two = made;
    paint(page.stage.dark);
    page.charts.rebuild();
    calls.chosen.mark();
    $("pair").hidden = false;
    $("pairAgain").hidden = !recipe;
    $("pairWhat").textContent = at === null ? names.join(" and ") : `What if, from tick ${number(at)} onward: ${change}`;
    announce(at === null ? `Two worlds side by side: ${names.join(" and ")}` : `Branched at tick ${number(at)}: ${change}`);
    calls.count();
    page.stage.jump = stage.jump = true;
    return made;
  }

  /** @param {boolean} [back] whether it will reopen immediately, as after a reconnection */
  function close(back = false) {
    const page = calls.page();
    if (!two || !page) return;
    if (calls.chosen.second && !back) calls.select(null);
    const { stage, other, parts } = two;
    two = null;
    stage.close();
    other.close();
    for (const part of parts) part.remove();
    $("stage").classList.remove("pair");
    $("pair").hidden = true;
    page.stage.eye.cover = overlay.covered;
    page.stage.peer = null;
    page.stage.dirty = true;
    calls.count();
  }

  let copying = false;

  /** Copies the view of one camera to another. @param {Stage} from @param {Stage} to */
  function look(from, to) {
    copying = true;
    const scale = to.eye.span / from.eye.span;
    const [here, there] = [from.eye.middle(), to.eye.middle()];
    const same = (/** @type {import("./vendor.js").Vector3} */ place) => (here.equals(there) ? place : place.clone().sub(here).multiplyScalar(scale).add(there));
    to.eye.controls.maxDistance = Math.max(to.eye.controls.maxDistance, from.eye.controls.maxDistance * scale);
    to.eye.put([same(from.eye.camera.position), same(from.eye.controls.target)]);
    to.eye.move(from.eye.shift);
    to.dirty = true;
    copying = false;
  }

  /** @param {boolean} dark */
  function paint(dark) {
    if (!two) return;
    two.stage.theme(dark, calls.own());
    two.stage.colourBy(calls.by());
    two.stage.dirty = true;
    const { state } = two;
    two.state = undefined; // so that its signs are drawn again
    if (state) say(two, state);
  }

  return {
    /** The second scene. */
    get stage() {
      return two?.stage ?? null;
    },
    /** The number of frames of the second world so far. */
    get frames() {
      return two ? two.stage.frames : 0;
    },
    paint,
    /** The color of a kind, which may be absent from the first world. @param {string} name */
    colourOf: (name) => two?.stage.colours[two.stage.kinds.findIndex((kind) => kind.name === name)],
    /** Reads a binary message: a frame of the first world and possibly one of the second. @param {ArrayBuffer} buffer */
    take(buffer) {
      const page = calls.page();
      if (!page) return 0;
      const number = page.stage.take(buffer);
      if (!two) return number;
      const there = page.stage.end < buffer.byteLength;
      $("stage").classList.toggle("alone", !there);
      if (there) two.stage.take(buffer, page.stage.end);
      return number;
    },
    /** Copies the view and the displayed kinds of the first scene to the second; called after each picture of the first. */
    follow() {
      const page = calls.page();
      if (!two || !page) return;
      const mine = page.stage.eye;
      const seen = sight(mine);
      if (seen.some((value, k) => Math.abs(value - (two?.seen[k] ?? Infinity)) > 1e-9 * mine.span)) look(page.stage, two.stage);
      two.seen = seen;
      for (const layer of two.stage.layers) {
        const shown = page.stage.layers.find(({ kind }) => kind.name === layer.kind.name)?.shown ?? true;
        if (layer.shown !== shown) layer.show(shown), two.stage.meadow.draw(true), (two.stage.dirty = true);
      }
      two.stage.over.shown = page.stage.over.shown;
    },
    /** @param {string} by */
    colourBy(by) {
      two?.stage.colourBy(by);
    },
  };
}

/** Shows the current differences. @param {Two} two @param {NonNullable<Beside["state"]>} state */
function say(two, state) {
  const { text, clauses, there } = state;
  if (two.state?.text === text) return;
  two.state = state;
  const kinds = kindsOf(two.stage.hello);
  const parts = Object.entries(clauses).map(([name, clause]) => {
    const k = kinds.findIndex((kind) => kind.name === name);
    return h("span", { class: "clause" }, k >= 0 ? sign(kinds[k], two.stage.colours[k]) : null, clause);
  });
  const told = Object.values(clauses).join("; ");
  const rest = told && text.slice(text.indexOf(told) + told.length).replace(/^; /, "").replace(/^\.$/, "");
  $("pairSays").replaceChildren(...(parts.length ? [h("span", { text: text.slice(0, text.indexOf(":") + 1) }), ...parts, ...(rest ? [rest] : [])] : [text]));
  $("stage").classList.toggle("alone", !there);
}

/** The camera's position and target, and the shift of the picture. @param {Eye} eye */
const sight = ({ camera, controls, shift }) => [...camera.position.toArray(), ...controls.target.toArray(), ...shift];

/** Shows how to reproduce this branch without the page. @param {{toml: string, command: string}} recipe */
function again({ toml, command }) {
  const part = (/** @type {string} */ title, /** @type {string} */ text) => {
    const copied = h("button", { class: "button", type: "button", text: "Copy", onclick: async () => {
      try {
        await navigator.clipboard.writeText(text);
        copied.textContent = "Copied";
      } catch {
        getSelection()?.selectAllChildren(code);
        copied.textContent = "Selected";
      }
    } });
    const code = h("pre", { class: "recipe", tabindex: 0, text });
    return [h("div", { class: "part-head" }, h("h3", { text: title }), copied), code];
  };
  const dialog = $("again");
  dialog.replaceChildren(h("h2", { id: "againTitle", text: "Reproduce this without the page" }),
    ...(command ? part("Command", command) : []), ...(toml ? part("In the world file", toml) : []),
    h("p", { class: "about", text: "One pair of runs can differ by chance. To test whether a change makes a difference, run many seeds with ecs-eco compare." }),
    h("form", { method: "dialog" }, h("button", { class: "button", type: "submit", text: "Close" })));
  dialog.showModal();
}
