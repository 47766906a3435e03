// The introduction: a description of the world, its food web, and hints that can be closed.

import { $, h, number, s } from "./dom.js";
import { kindsOf, sign } from "./marks.js";

const [WIDE, ROW, GAP] = [360, 74, 30]; // dimensions of the food web in its own units
const KEPT = "ecs-eco-hints"; // in localStorage: closed hints

/** @type {Record<string, string>} */
export const HINTS = {
  select: "Click an animal: the Organism tab shows what it senses and decides.",
  pause: "Press Play or space to start and to pause. Drag the timeline below to go to another tick.",
  why: "The Why tab explains events and causes of death.",
};

/**
 * The trophic level of each species: 0 for plants; species in a cycle take the level implied by the other
 * species.
 * @param {string[]} names
 * @param {Record<string, string[]>} foods
 */
export function levels(names, foods) {
  /** @type {Record<string, number>} */
  const level = Object.fromEntries(names.map((name) => [name, 0]));
  for (let round = 0; round < names.length; round++)
    for (const name of names) {
      const below = (foods[name] ?? []).filter((food) => food in level && food !== name).map((food) => level[food]);
      level[name] = below.length ? Math.min(names.length - 1, 1 + Math.max(...below)) : 0;
    }
  return level;
}

/**
 * All foods of each species: its diet, including food that harms it, and anything else that it has eaten.
 * @param {import("./protocol.js").Hello} hello
 * @param {string[]} causes of death so far, as "deer: eaten by wolf"
 * @returns {Record<string, string[]>}
 */
export function eats({ eats, foods }, causes) {
  /** @type {Record<string, Set<string>>} */
  const all = Object.fromEntries(Object.entries(eats ?? foods ?? {}).map(([eater, diet]) => [eater, new Set(diet)]));
  for (const cause of causes) {
    const [food, eater] = cause.split(": eaten by ");
    if (eater) (all[eater] ??= new Set()).add(food);
  }
  return Object.fromEntries(Object.entries(all).map(([eater, diet]) => [eater, [...diet]]));
}

/**
 * The food web: arrows point from food to eater, dashed if the food harms it.
 * @param {import("./protocol.js").Hello} hello
 * @param {(name: string) => string} colourOf
 * @param {string[]} causes
 */
function web(hello, colourOf, causes) {
  const foods = eats(hello, causes), eaten = Object.values(foods).flat();
  const harms = (/** @type {string} */ food, /** @type {string} */ eater) => hello.eats?.[eater]?.includes(food) && !hello.foods?.[eater]?.includes(food);
  const kinds = kindsOf(hello).filter(({ inanimate, name }) => !inanimate || eaten.includes(name));
  const names = kinds.map(({ name }) => name);
  const level = levels(names, foods);
  const rows = [...new Set(Object.values(level))].sort((a, b) => b - a).map((height) => kinds.filter(({ name }) => level[name] === height));
  const high = rows.length * ROW;
  /** @type {Record<string, [number, number]>} */
  const at = {};
  rows.forEach((row, r) => row.forEach(({ name }, i) => (at[name] = [(WIDE * (i + 1)) / (row.length + 1), r * ROW + GAP])));
  const meals = names.flatMap((eater) => (foods[eater] ?? []).filter((food) => food in at).map((food) => /** @type {[string, string]} */ ([food, eater])));
  const words = meals.map(([food, eater]) => `${eater} eats ${food}${harms(food, eater) ? ", which harms it" : ""}`).join("; ");
  const root = s("svg", { viewBox: `0 0 ${WIDE} ${high}`, class: "web", role: "img", "aria-label": `Who eats whom: ${words || "no species eats another"}` });
  for (const [food, eater] of meals) {
    const [[x0, y0], [x1, y1]] = [at[food], at[eater]];
    const own = food === eater;
    const d = own ? `M${x1 + 16},${y1 - 6}c26,-18 26,30 2,18` : `M${x0},${y0 - 20}C${x0},${(y0 + y1) / 2} ${x1},${(y0 + y1) / 2} ${x1},${y1 + 26}`;
    root.append(s("path", { d, class: harms(food, eater) ? "meal harms" : "meal", "data-meal": `${food} ${eater}` }));
    if (!own) root.append(s("path", { d: `M${x1},${y1 + 19}l-5,9h10z`, class: "meal-head" }));
  }
  for (const kind of kinds) {
    const [x, y] = at[kind.name];
    const mark = sign(kind, colourOf(kind.name));
    for (const [name, value] of Object.entries({ x: x - 11, y: y - 19, width: 22, height: 22 })) mark.setAttribute(name, String(value));
    root.append(mark, s("text", { x, y: y + 16, "text-anchor": "middle" }, kind.name));
  }
  return root;
}

/**
 * Fills the "World" tab.
 * @param {import("./protocol.js").Hello} hello
 * @param {(name: string) => string} colourOf
 * @param {string[]} causes of death so far, as "deer: eaten by wolf"
 */
export function world(hello, colourOf, causes) {
  const size = hello.size.map((side) => number(side)).join(" × ");
  const facts = [["size", `${size} m, ${hello.edges === "torus" ? "torus: organisms that leave on one side enter on the opposite side" : "with walls"}`], ["tick length", `${number(hello.dt)} s`],
    ["seed", String(hello.seed ?? "–")], ["species", hello.species.map(({ name }) => name).join(", ")]];
  $("world").replaceChildren(h("h2", { text: hello.title || hello.world }),
    ...(hello.about ?? "").split(/\n\s*\n/).filter(Boolean).map((text) => h("p", { class: "tale", text })),
    h("dl", { class: "facts" }, ...facts.map(([name, text]) => h("div", { class: "wide" }, h("dt", { text: name }), h("dd", { class: "wraps", text })))),
    h("h2", { text: "Food web" }), h("div", { class: "meals" }, web(hello, colourOf, causes)),
    ...(hello.file ? [h("h2", { text: "This file" }), ...hello.file.map((text) => h("p", { class: "tale", text }))] : []));
}

/** Draws the food web again, for new causes of death. @type {typeof world} */
export const meals = (hello, colourOf, causes) => document.querySelector("#world .meals")?.replaceChildren(web(hello, colourOf, causes));

/** Hints that disappear when they are closed or the user has followed them. @returns {(name: string) => void} call this with the user's action */
export function hints() {
  const root = $("hints");
  const gone = new Set(recalled());
  const go = (/** @type {string} */ name) => {
    if (gone.has(name)) return;
    gone.add(name);
    try {
      localStorage.setItem(KEPT, JSON.stringify([...gone]));
    } catch {} // storage may be unavailable in private windows
    draw();
  };
  const draw = () => {
    const left = Object.entries(HINTS).filter(([name]) => !gone.has(name));
    root.hidden = !left.length;
    root.replaceChildren(...left.map(([name, text]) => h("li", { "data-hint": name }, text, h("button", { class: "mini", type: "button", text: "✕", "aria-label": `Close the hint: ${text}`, onclick: () => go(name) }))));
  };
  draw();
  return go;
}

/** @returns {string[]} */
function recalled() {
  try {
    const gone = JSON.parse(localStorage.getItem(KEPT) ?? "[]");
    return Array.isArray(gone) ? gone : [];
  } catch {
    return [];
  }
}
