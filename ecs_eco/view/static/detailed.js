// Stretches of a recorded run with more detail on organisms, as thin bars on the timeline and as text.

import { number } from "./dom.js";
import { css } from "./theme.js";

/** @typedef {import("./protocol.js").Detailed} Detailed */

const ROW = 4; // [px]

/** A description of a stretch. @param {Detailed} stretch */
export function words({ kind, first, last, species, n, wrong }) {
  const ticks = `ticks ${number(first)} to ${number(last)}`;
  if (kind === "filled") return `Filled in: ${ticks}${wrong === null ? "" : `, differs from the record from tick ${number(wrong)} on`}`;
  return `${kind === "full" ? "All details" : `Details (at most ${number(n)} focal organisms per species)`} of ${species.join(", ")}: ${ticks}`;
}

/** Total height of the bars [px]. @param {Detailed[]} stretches */
export const heightOf = (stretches) => ROW * rows(stretches).length;

/**
 * Draws the bars, with recorded stretches above rerun stretches.
 * @param {CanvasRenderingContext2D} pen
 * @param {(tick: number) => number} at
 * @param {Detailed[]} stretches
 * @param {number} low lower edge of the bars [px]
 */
export function bars(pen, at, stretches, low) {
  rows(stretches).forEach((row, k, { length }) => {
    for (const { kind, first, last, wrong } of row) {
      const y = low - ROW * (length - k) + 1;
      pen.fillStyle = css(wrong !== null ? "--minus" : kind === "filled" ? "--plus" : "--accent");
      pen.fillRect(at(first), y, Math.max(2, at(last + 1) - at(first)), ROW - 1);
    }
  });
}

/** @param {Detailed[]} stretches */
function rows(stretches) {
  const filled = stretches.filter(({ kind }) => kind === "filled");
  return [stretches.filter(({ kind }) => kind !== "filled"), filled].filter((row) => row.length);
}
