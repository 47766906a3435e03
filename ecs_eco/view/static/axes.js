// The size of a figure, and grid lines at round values with their labels.

import { s } from "./dom.js";
import { round } from "./ground.js";
import { css } from "./theme.js";

export const [WIDE, HIGH] = [360, 250]; // size of a figure in its own units
export const [LEFT, BOTTOM, TOP, RIGHT] = [52, 34, 10, 12]; // margins

/**
 * Grid lines at round values, with labels.
 * @param {number[]} across ends of the first axis
 * @param {(value: number) => number} x
 * @param {number[]} up ends of the second axis
 * @param {(value: number) => number} y
 * @param {string} unit of the second axis
 */
export function grid(across, x, up, y, unit = "") {
  const [stroke, fill] = [css("--line"), css("--soft")];
  return [
    ...roundValues(across).flatMap(([value, text]) => [s("line", { x1: x(value), x2: x(value), y1: TOP, y2: HIGH - BOTTOM, stroke }), s("text", { x: Math.min(x(value), WIDE - RIGHT - 3 * text.length), y: HIGH - BOTTOM + 14, "text-anchor": "middle", fill }, text)]),
    ...roundValues(up).flatMap(([value, text]) => [s("line", { x1: LEFT, x2: WIDE - RIGHT, y1: y(value), y2: y(value), stroke }), s("text", { x: LEFT - 5, y: y(value) + 4, "text-anchor": "end", fill }, text + unit)]),
  ];
}

/** Four to ten multiples of 1, 2 or 5 times a power of ten between two values, each with its exact label. @param {number[]} ends @returns {[number, string][]} */
export function roundValues([low, high]) {
  const step = round((high - low) / 4), first = Math.ceil(low / step - 1e-9), n = Math.floor(high / step + 1e-9) - first + 1;
  const maximumFractionDigits = Math.min(20, Math.max(0, -Math.floor(Math.log10(step))));
  const text = (/** @type {number} */ value) => value.toLocaleString("en", { maximumFractionDigits }).replaceAll(",", "\u202f").replace("-", "−");
  return Array.from({ length: n }, (_, k) => Number(((first + k) * step).toPrecision(12))).map((value) => [value, text(value)]);
}
