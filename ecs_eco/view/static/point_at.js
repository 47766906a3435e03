// Finds what is at a point of the canvas: an organism or a position on the ground.

import { Raycaster, Vector2, Vector3 } from "./vendor.js";

/** @typedef {import("./stage.js").Stage} Stage */

/**
 * The organism nearest to a point of the canvas, preferring animals to plants and plants to objects.
 * @param {Stage} stage
 * @param {number} x [px]
 * @param {number} y [px]
 * @param {number} reach [px]
 */
export function pick(stage, x, y, reach) {
  const at = new Vector3();
  const matrix = stage.eye.camera.projectionMatrix.clone().multiply(stage.eye.camera.matrixWorldInverse);
  const m = matrix.elements;
  const [w, h] = [stage.canvas.clientWidth / 2, stage.canvas.clientHeight / 2];
  let best = null;
  let least = reach * reach;
  for (const layer of stage.layers) {
    if (!layer.shown) continue;
    const handicap = layer.kind.inanimate ? 16 : layer.kind.moves ? 0 : 9; // [px²]
    for (let row = 0; row < layer.block.n; row++) {
      stage.spot(layer, row, at);
      const depth = m[3] * at.x + m[7] * at.y + m[11] * at.z + m[15];
      if (depth <= 0) continue;
      const dx = ((m[0] * at.x + m[4] * at.y + m[8] * at.z + m[12]) / depth + 1) * w - x;
      const dy = (1 - (m[1] * at.x + m[5] * at.y + m[9] * at.z + m[13]) / depth) * h - y;
      const distance = dx * dx + dy * dy + handicap;
      if (distance < least) {
        least = distance;
        best = { layer, row };
      }
    }
  }
  return best && { uid: best.layer.uid(best.row), kind: best.layer.kind };
}

/**
 * The position [m] on the ground (in water: on the middle plane) under a point of the canvas.
 * @param {Stage} stage
 * @param {number} x [px]
 * @param {number} y [px]
 */
export function under(stage, x, y) {
  const { size } = stage.hello;
  const ray = new Raycaster();
  ray.setFromCamera(new Vector2((x / stage.canvas.clientWidth) * 2 - 1, 1 - (y / stage.canvas.clientHeight) * 2), stage.eye.camera);
  const { origin, direction } = ray.ray;
  const at = new Vector3();
  if (size.length > 2) {
    const middle = stage.eye.middle();
    const normal = stage.eye.camera.getWorldDirection(new Vector3());
    at.copy(direction).multiplyScalar(middle.sub(origin).dot(normal) / direction.dot(normal)).add(origin);
  } else {
    let level = 0;
    for (let k = 0; k < 8; k++) { // moves toward the point where the ray meets the ground
      at.copy(direction).multiplyScalar((level - origin.z) / direction.z).add(origin);
      level = stage.relief.at(at.x, at.y);
    }
  }
  const inside = [at.x, at.y, at.z].slice(0, size.length).every((value, axis) => value >= 0 && value <= size[axis]);
  return inside ? [at.x, at.y, at.z].slice(0, size.length) : null;
}
