// While the camera follows an organism, bodies, objects, plants and rocks between it and the camera fade. The ground does not.

import { HIDES } from "./shaders.js";

/** @typedef {import("./stage.js").Stage} Stage */

const AROUND = 2.5; // radius of fading, relative to the organism's radius on the screen
const LEAST = 16; // [px]
const OWN = 1.5; // depth margin, relative to the organism's radius, so that it does not hide itself

/**
 * Sets where elements fade. Called before a picture is drawn.
 * @param {Stage} stage
 * @param {import("./vendor.js").Vector3 | null} place position of the selected organism [m]
 */
export function clear(stage, place) {
  const { eye, shared, renderer, canvas } = stage;
  const found = stage.selected === null ? null : stage.find(stage.selected);
  if (!place || !found || eye.preset !== "follow") {
    shared.clear.value = shared.followed.value = [0, 0, 0, 0];
    return;
  }
  shared.followed.value = [...place.toArray(), 1];
  const ratio = renderer.getPixelRatio();
  eye.camera.updateMatrixWorld();
  const way = eye.camera.position.clone().sub(place), distance = way.length();
  const { radius, least } = found.layer.own;
  const long = Math.max(0, ...(found.layer.kind.size ?? [])) / 2;
  const size = Math.max(radius.value, long, (least.value * distance) / shared.lens.value); // drawn size [m]
  const front = place.clone().addScaledVector(way, Math.min(0.5, (OWN * size) / distance)).project(eye.camera);
  const at = place.clone().project(eye.camera);
  const [wide, high] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
  const pixels = Math.max(LEAST * ratio, (AROUND * size * shared.lens.value) / distance);
  shared.clear.value = [((at.x + 1) / 2) * wide, ((at.y + 1) / 2) * high, (front.z + 1) / 2, pixels];
}

/** Makes a three.js material fade as well. @param {import("./vendor.js").MeshLambertMaterial} material @param {Record<string, {value: any}>} shared */
export function fadeable(material, shared) {
  material.onBeforeCompile = (shader) => {
    shader.uniforms.clear = shared.clear;
    shader.fragmentShader = HIDES + shader.fragmentShader.replace("void main() {", "void main() {\n  if (hides()) discard;");
  };
}
