// Icons of kinds (the silhouette of an animal, a disc for plants, a square for objects), and line samples for charts.

import { outline } from "./body.js";
import { s } from "./dom.js";

/**
 * @param {import("./protocol.js").Kind} kind
 * @param {string} colour
 */
export function sign(kind, colour) {
  const shapes = kind.inanimate
    ? [s("rect", { x: 4, y: 4, width: 8, height: 8, rx: 1.5, fill: colour })]
    : kind.moves || kind.rests
      ? outline(kind.build ?? "grazer", kind.variant).map((polygon) => s("polygon", { points: polygon.map(([x, y]) => `${(8 + 3.6 * x).toFixed(1)},${(8 - 3.6 * y).toFixed(1)}`).join(" "), fill: colour }))
      : [s("circle", { cx: 8, cy: 8, r: 4.6, fill: colour })];
  return s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, ...shapes);
}

/**
 * Species and objects in order, with their silhouettes and whether they hunt (eat animals).
 * @param {import("./protocol.js").Hello} hello
 * @returns {import("./protocol.js").Kind[]}
 */
export function kindsOf({ species, objects, foods, size }) {
  const moving = new Set(species.filter(({ moves }) => moves).map(({ name }) => name));
  const living = new Set(species.map(({ name }) => name));
  const hunts = (/** @type {string} */ name) => Boolean(foods?.[name]?.some((food) => moving.has(food)));
  const dead = (/** @type {string} */ name) => Boolean(foods?.[name]?.length && foods[name].every((food) => !living.has(food)));
  /** @type {Record<string, number>} */
  const like = {};
  const animals = species.map((kind) => {
    const build = `${hunts(kind.name) ? "hunter" : dead(kind.name) ? "scavenger" : "grazer"}${(size?.length ?? 2) > 2 ? " water" : ""}`;
    const rests = !kind.moves && kind.sessile === false;
    if (kind.moves || rests) like[build] = (like[build] ?? -1) + 1;
    return { ...kind, rests, hunts: hunts(kind.name), build, variant: like[build] ?? 0 };
  });
  return [...animals, ...(objects ?? []).map((kind) => ({ ...kind, inanimate: true }))];
}

/** Dash patterns, which distinguish lines when colors do not. */
export const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 2]];

/**
 * @param {string} colour
 * @param {number[]} dash
 */
export function stroke(colour, dash) {
  const line = s("line", { x1: 0, x2: 18, y1: 4, y2: 4, stroke: colour, "stroke-width": 2.4, "stroke-dasharray": dash.join(" ") || null });
  return s("svg", { viewBox: "0 0 18 8", "aria-hidden": "true" }, line);
}
