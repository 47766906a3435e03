// The speed of time: a slider from one tick per second to full speed.

import { $, number } from "./dom.js";

const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, null]; // ticks per second; null: full speed
const NORMAL = 10; // ticks per second at 1×
const PATIENCE = 10_000; // [ms] for which answers to earlier requests are ignored
/** The last requested speed, until the server confirms it. @type {{speed: number | null, until: number} | null} */
let asked = null;

/** @param {number | null} speed */
function tell(speed) {
  const text = speed === null ? "full speed" : `${number(speed / NORMAL)}× · ${number(speed)} ticks/s`;
  $("speedText").textContent = text;
  $("speed").setAttribute("aria-valuetext", text);
}

/** Shows the server's speed. @param {number | null} speed */
export function showSpeed(speed) {
  if (asked && speed !== asked.speed && performance.now() < asked.until) return; // otherwise the slider would jump back
  asked = null;
  const slot = SPEEDS.indexOf(speed);
  const nearest = slot >= 0 ? slot : SPEEDS.findIndex((one) => one === null || one >= (speed ?? Infinity));
  if (document.activeElement !== $("speed") || slot >= 0) $("speed").value = nearest;
  tell(speed);
}

/** Selects a slider position; returns its speed [ticks/s], or null for full speed. @param {number} slot */
export function speedAt(slot) {
  const value = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, slot))];
  $("speed").value = SPEEDS.indexOf(value);
  tell(value);
  asked = { speed: value, until: performance.now() + PATIENCE };
  return value;
}
