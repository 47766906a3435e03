// The pointer over the scene: a click selects an organism or places new ones, and a tooltip names the organism under the pointer.

import * as overlay from "./overlay.js";
import { pick, under } from "./point_at.js";

/** @typedef {{stage: import("./stage.js").Stage, act: import("./act.js").Act | null}} Page */

/**
 * @param {HTMLCanvasElement} canvas
 * @param {{page: () => Page | null, select: (uid: number | null) => void}} calls
 */
export function point(canvas, calls) {
  /** @type {{x: number, y: number} | null} */
  let pressed = null;
  let hovered = 0;
  canvas.addEventListener("pointerdown", (event) => {
    pressed = event.button === 0 ? { x: event.offsetX, y: event.offsetY } : null;
  });
  canvas.addEventListener("pointerup", (event) => {
    const page = calls.page();
    if (!page || !pressed || Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) > 5) return;
    if (page.act?.aiming) {
      const place = under(page.stage, event.offsetX, event.offsetY);
      if (place) page.act.placeAt(place);
      return;
    }
    const found = pick(page.stage, event.offsetX, event.offsetY, event.pointerType === "touch" ? 26 : 15);
    if (found && !found.kind.inanimate) calls.select(found.uid);
    else calls.select(null);
  });
  canvas.addEventListener("pointermove", (event) => {
    const page = calls.page();
    if (!page || event.buttons || event.pointerType === "touch" || performance.now() - hovered < 80) return;
    hovered = performance.now();
    const found = page.act?.aiming ? null : pick(page.stage, event.offsetX, event.offsetY, 12);
    overlay.tip(found ? { x: event.offsetX + canvas.offsetLeft, y: event.offsetY + canvas.offsetTop } : null, found ? `${found.kind.name} #${found.uid}` : "");
  });
  canvas.addEventListener("pointerleave", () => overlay.tip(null));
}
