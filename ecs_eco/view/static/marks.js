// The signs of kinds: a dart for who hunts, an egg for who moves, a disc for who grows, a square for things; and lines of charts.

import { s } from "./dom.js";

/**
 * @param {import("./protocol.js").Kind} kind
 * @param {string} colour
 */
export function sign(kind, colour) {
  const shape = kind.inanimate
    ? s("rect", { x: 4, y: 4, width: 8, height: 8, rx: 1.5, fill: colour })
    : kind.moves
      ? s("path", { d: kind.hunts ? "M14.5 8 3 3.2 5.8 8 3 12.8z" : "M14 8C11.5 4.6 8.6 3.6 6 3.6 3.4 3.6 2 5.6 2 8s1.4 4.4 4 4.4c2.6 0 5.5-1 8-4.4z", fill: colour })
      : s("circle", { cx: 8, cy: 8, r: 4.6, fill: colour });
  return s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, shape);
}

/**
 * Species and things in order, with who of them hunts: eats what moves.
 * @param {import("./protocol.js").Hello} hello
 * @returns {import("./protocol.js").Kind[]}
 */
export function kindsOf({ species, objects, foods }) {
  const moving = new Set(species.filter(({ moves }) => moves).map(({ name }) => name));
  const hunts = (/** @type {string} */ name) => Boolean(foods?.[name]?.some((food) => moving.has(food)));
  return [...species.map((kind) => ({ ...kind, hunts: hunts(kind.name) })), ...(objects ?? []).map((kind) => ({ ...kind, inanimate: true }))];
}

/** Dashes tell lines apart where colours do not. */
export const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 2]];

/**
 * @param {string} colour
 * @param {number[]} dash
 */
export function stroke(colour, dash) {
  const line = s("line", { x1: 0, x2: 18, y1: 4, y2: 4, stroke: colour, "stroke-width": 2.4, "stroke-dasharray": dash.join(" ") || null });
  return s("svg", { viewBox: "0 0 18 8", "aria-hidden": "true" }, line);
}
