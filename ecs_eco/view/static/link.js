// A link that stores tick, camera, selection, panel, color and field in the fragment of the address, which is never sent to a server.
// A reloaded page returns to the view that it showed.

import { Vector3 } from "./vendor.js";
import { $, announce } from "./dom.js";

/** @typedef {{tick?: number, eye?: number[], uid?: number, of?: string, tab?: string, colour?: string, field?: string, follow?: string}} Sight */

const KEPT = "ecs-eco-view"; // in sessionStorage: the world and the view of this tab

/** Parses the fragment of an address; returns null if it has no parameters. @param {string} hash @returns {Sight | null} */
export function read(hash) {
  const words = new URLSearchParams(hash.slice(1));
  /** @type {Sight} */
  const found = {};
  for (const name of /** @type {const} */ (["tick", "uid"])) {
    const value = Number(words.get(name) ?? NaN);
    if (Number.isSafeInteger(value) && value >= 0) found[name] = value;
  }
  const eye = (words.get("eye") ?? "").split(",").map(Number);
  if ([6, 8].includes(eye.length) && eye.every(Number.isFinite)) found.eye = eye;
  for (const name of /** @type {const} */ (["of", "tab", "colour", "field", "follow"])) {
    const value = words.get(name);
    if (value) found[name] = value;
  }
  return Object.keys(found).length ? found : null;
}

/** The address of a view. @param {Sight} sight */
export function written(sight) {
  const words = Object.entries(sight).filter(([, value]) => value !== undefined && value !== "").map(([name, value]) => `${name}=${Array.isArray(value) ? value.map((part) => Number(part.toPrecision(5))) : encodeURIComponent(value)}`);
  return `${location.href.split("#")[0]}#${words.join("&")}`;
}

/** The current view. @param {import("./stage.js").Stage} stage @param {import("./chosen.js").Chosen} chosen @param {string} tab @param {string} by the quantity that colors organisms @returns {Sight} */
export function shown({ tick, eye }, { uid, second, followed }, tab, by) {
  const place = [...eye.camera.position.toArray(), ...eye.controls.target.toArray(), ...eye.shift];
  return { tick, eye: place, uid: uid ?? undefined, of: second ? "second" : undefined, tab, colour: by === "species" ? undefined : by, field: $("field").value, follow: followed ? "yes" : undefined };
}

/** Stores the view for when this page is reloaded. @param {string} world @param {Sight} sight */
export function keep(world, sight) {
  try {
    sessionStorage.setItem(KEPT, JSON.stringify([world, written(sight)]));
  } catch {} // storage may be unavailable, as for the credential
}

/** The stored view of this world, if the page was reloaded or is visited again. @param {string} world */
export function kept(world) {
  const [entry] = performance.getEntriesByType("navigation");
  try {
    const [of, address] = JSON.parse(sessionStorage.getItem(KEPT) ?? "[]");
    return of === world && /** @type {PerformanceNavigationTiming} */ (entry).type !== "navigate" ? read(new URL(address).hash) : null;
  } catch {
    return null;
  }
}

/** Moves the camera to a stored position. @param {import("./stage.js").Stage} stage @param {number[]} eye */
export function lookFrom(stage, eye) {
  stage.eye.move([eye[6] ?? 0, eye[7] ?? 0]);
  stage.eye.put([new Vector3(...eye.slice(0, 3)), new Vector3(...eye.slice(3, 6))]);
  stage.eye.touched = true; // keeps this view when resized
  stage.dirty = true;
}

/** Copies the address to the address bar and the clipboard. @param {string} address */
export async function copy(address) {
  history.replaceState(history.state, "", address);
  let words = "The link is in the address bar";
  try {
    await navigator.clipboard.writeText(address);
    words = "The link is copied and is also in the address bar";
  } catch {} // clipboard access may be forbidden
  announce(words);
  $("share").title = `${words}. It stores tick, camera, selection, panel, color and field`;
  return words;
}
