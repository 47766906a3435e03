// Icons of kinds (the silhouette of an animal or tree, a disc for other plants, the form of objects), and line samples for charts.

import { formOf, lookOf, outline } from "./body.js";
import { s } from "./dom.js";

/**
 * @param {import("./protocol.js").Kind} kind
 * @param {string} colour
 */
export function sign(kind, colour) {
  const form = formOf(kind), round = { disc: [5, 5], plate: [6, 3.6], capsule: [6.5, 2.8] }[form];
  const shapes = form === "box"
    ? [s("rect", { x: 3, y: 4, width: 10, height: 8, fill: colour })]
    : round
      ? [s("ellipse", { cx: 8, cy: 8, rx: round[0], ry: round[1], fill: colour })]
      : outline(form, kind.variant).map((polygon) => s("polygon", { points: polygon.map(([x, y]) => `${(7.8 + 3.6 * x).toFixed(1)},${(10.6 - 3.6 * y).toFixed(1)}`).join(" "), fill: colour }));
  return s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, ...shapes);
}

const PLANTS = ["tree", "conifer", "shrub", "clover"];
/** Shapes of species that are not named after one: hunters, scavengers, small grazers, grazers. */
const OTHERS = { land: ["wolf", "bird", "insect", "deer"], water: ["fish", "krill", "copepod", "copepod"] };

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
    const named = lookOf(kind.name), still = named && PLANTS.includes(named);
    const rests = !kind.moves && kind.sessile === false && !still;
    const shape = () => (hunts(kind.name) ? 0 : dead(kind.name) ? 1 : kind.radius < 0.03 ? 2 : 3);
    const build = kind.look ?? (kind.moves || rests ? (!still && named) || OTHERS[(size?.length ?? 2) > 2 ? "water" : "land"][shape()] : still ? named : undefined);
    const variant = build && build !== (kind.look ?? named) ? (like[build] = (like[build] ?? -1) + 1) : 0;
    return { ...kind, rests, hunts: hunts(kind.name), build, variant };
  });
  return [...animals, ...(objects ?? []).map((kind) => ({ ...kind, inanimate: true, build: kind.remains || lookOf(kind.name) === "carcass" ? "carcass" : undefined }))];
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
