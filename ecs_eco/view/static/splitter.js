// The border between scene and panels, moved by dragging or with arrow keys. The browser stores its position.

import { $ } from "./dom.js";

const KEPT = "ecs-eco-side";
const USUAL = 404, LEAST = 260, SCENE = 320; // [px]
const STEP = 40;

export function splitter() {
  const bar = $("splitter");
  const work = /** @type {HTMLElement} */ (bar.parentElement);
  const most = () => Math.max(LEAST, work.clientWidth - SCENE);
  /** @param {number} width [px] @param {boolean} [keep] */
  const set = (width, keep = true) => {
    const px = Math.round(Math.min(most(), Math.max(LEAST, width)));
    work.style.setProperty("--side", `${px}px`);
    for (const [name, value] of Object.entries({ valuenow: px, valuemin: LEAST, valuemax: most() })) bar.setAttribute(`aria-${name}`, String(value));
    try {
      if (keep) localStorage.setItem(KEPT, String(px));
    } catch {} // storage may be unavailable in private windows
  };
  const now = () => $("side").getBoundingClientRect().width;
  bar.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => bar.setPointerCapture(event.pointerId));
  bar.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => bar.hasPointerCapture(event.pointerId) && set(work.getBoundingClientRect().right - event.clientX));
  bar.addEventListener("dblclick", () => set(USUAL));
  bar.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const way = { ArrowLeft: STEP, ArrowRight: -STEP }[event.key];
    if (way === undefined) return;
    event.preventDefault();
    set(now() + way);
  });
  let kept = null;
  try {
    kept = localStorage.getItem(KEPT);
  } catch {}
  set(Number(kept) || USUAL, false);
}
