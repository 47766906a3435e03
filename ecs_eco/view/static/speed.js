// How fast time passes: the slider, from a tick a second to as fast as the world runs.

import { $, number } from "./dom.js";

const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, null]; // ticks a second; the last: as fast as it runs
const NORMAL = 10; // ticks a second that count as 1×

/** @param {number | null} speed */
function tell(speed) {
  const text = speed === null ? "as fast as it runs" : `${number(speed / NORMAL)}× · ${number(speed)} ticks/s`;
  $("speedText").textContent = text;
  $("speed").setAttribute("aria-valuetext", text);
}

/** Shows the speed that the server has. @param {number | null} speed */
export function showSpeed(speed) {
  const slot = SPEEDS.indexOf(speed);
  const nearest = slot >= 0 ? slot : SPEEDS.findIndex((one) => one === null || one >= (speed ?? Infinity));
  if (document.activeElement !== $("speed") || slot >= 0) $("speed").value = nearest;
  tell(speed);
}

/** Chooses a place on the slider; returns its speed [ticks/s], null for as fast as it runs. @param {number} slot */
export function speedAt(slot) {
  const value = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, slot))];
  $("speed").value = SPEEDS.indexOf(value);
  tell(value);
  return value;
}
