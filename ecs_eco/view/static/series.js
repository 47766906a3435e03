// Helpers for series of numbers by tick, and the choice of charts.

import { uPlot } from "./vendor.js";
import { css } from "./theme.js";

/** @typedef {(number | null)[]} Line */

const KEPT = "ecs-eco-charts-2"; // in localStorage: which charts are hidden

/**
 * Shades the hours without light; where it is unknown, as at the next tick at which it is known.
 * @param {uPlot} u
 * @param {number[]} ticks
 * @param {Line} light 0 … 1
 */
export function nights(u, ticks, light) {
  if (!light.some((value) => value !== null && value < 0.98)) return;
  const { left, top, width, height } = u.bbox;
  u.ctx.save();
  u.ctx.fillStyle = css("--night");
  let next = 1, from = left;
  const known = light.toReversed().map((value) => (next = value ?? next)).toReversed();
  for (let i = 1; i < ticks.length; i++) {
    const to = u.valToPos(ticks[i], "x", true);
    if (to < left || to - from < 1) continue;
    u.ctx.globalAlpha = 0.4 * (1 - Math.min(1, Math.max(0, known[i])));
    u.ctx.fillRect(Math.round(from), top, Math.round(Math.min(to, left + width)) - Math.round(from), height);
    from = to;
    if (to > left + width) break;
  }
  u.ctx.restore();
}

/**
 * Formats numbers as comma-separated text.
 * @param {number[]} ticks
 * @param {string[]} names of columns
 * @param {Record<string, Line>} lines
 * @param {(name: string) => string} unit
 */
export function table(ticks, names, lines, unit) {
  const heads = names.map((name) => `${name || "the world"} [${unit(name)}]`);
  return csv([["tick", ...heads], ...ticks.map((tick, i) => [tick, ...names.map((name) => lines[name][i])])]);
}

/** Rows as comma-separated text; missing cells are empty. @param {(string | number | null | undefined)[][]} rows */
export function csv(rows) {
  const cell = (/** @type {string} */ text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  return rows.map((row) => row.map((value) => cell(String(value ?? ""))).join(",")).join("\n") + "\n";
}

/**
 * Appends n values, with gaps for missing values.
 * @param {Line} line
 * @param {Line | undefined} values
 * @param {number} length number of earlier ticks
 * @param {number} n
 */
export function append(line, values, length, n) {
  while (line.length < length) line.push(null);
  for (let i = 0; i < n; i++) {
    const value = values?.[i] ?? null;
    line.push(value === null || Number.isNaN(value) ? null : value);
  }
}

export const REPORT = "report "; // prefix of reporter names; each reporter has its own chart

/** The lines of a message by chart. @param {import("./protocol.js").Series} series @returns {Record<string, Record<string, Line> | undefined>} */
export const grouped = (series) => ({
  n: series.n, happiness: series.happiness, genes: series.genes, births: series.births, causes: flat(series.causes ?? {}), energy: flat(series.energy ?? {}), flows: flat(series.flows ?? {}),
  ...Object.fromEntries(Object.entries(series.reports ?? {}).map(([name, lines]) => [REPORT + name, lines])),
});

/** Deaths by species and cause, one line each. @param {Record<string, Record<string, Line>>} causes */
export const flat = (causes) => Object.fromEntries(Object.entries(causes).flatMap(([species, lines]) => Object.entries(lines).map(([cause, line]) => [`${species}: ${cause}`, line])));

const RARE = ["births", "plane", "spread", "energy", "scatter"]; // hidden until the user selects them

/** The charts that were hidden in this browser. @returns {string[]} */
export function recalled() {
  try {
    return JSON.parse(localStorage.getItem(KEPT) ?? "null") ?? RARE;
  } catch {
    return RARE;
  }
}

/** @param {string[]} hidden */
export function remember(hidden) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(hidden));
  } catch {} // storage may be unavailable in private windows
}
