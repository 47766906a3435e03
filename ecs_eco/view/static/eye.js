// The camera: presets (top, side, follow), orbiting, and flights between them.

import { MOUSE, OrbitControls, PerspectiveCamera, TOUCH, Vector3 } from "./vendor.js";

/** @typedef {"top" | "side" | "follow"} Preset */

const UP = new Vector3(0, 0, 1);
const FLIGHT = 600; // [ms]

export class Eye {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {number[]} size of the world [m]
   * @param {[number, number]} levels lowest and highest point [m]
   */
  constructor(canvas, size, levels) {
    this.size = size;
    this.levels = levels;
    this.span = Math.hypot(size[0], size[1], levels[1] - levels[0]);
    this.camera = new PerspectiveCamera(36, 1, this.span / 2000, this.span * 12);
    this.camera.up.copy(UP);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.18;
    this.controls.zoomToCursor = true;
    this.controls.maxDistance = this.span * 4;
    this.controls.minDistance = this.span / 600;
    this.controls.mouseButtons = { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.ROTATE };
    this.controls.touches = { ONE: TOUCH.PAN, TWO: TOUCH.DOLLY_ROTATE };
    this.controls.maxPolarAngle = size.length > 2 ? Math.PI * 0.92 : Math.PI * 0.49;
    /** @type {Preset} */
    this.preset = "side";
    this.touched = false; // whether somebody has moved the camera since the preset
    this.controls.addEventListener("start", () => {
      this.touched = true;
      this.flight = null;
    });
    /** @type {{from: Vector3[], to: Vector3[], start: number} | null} */
    this.flight = null;
    /** @type {Vector3 | null} */
    this.followed = null;
  }

  /** The middle of the world. */
  middle() {
    return new Vector3(this.size[0] / 2, this.size[1] / 2, (this.levels[0] + this.levels[1]) / 2);
  }

  /** Where one looks from. @param {Preset} preset */
  direction(preset) {
    if (preset === "top") return new Vector3(0, -0.012, 1).normalize();
    return this.size.length > 2 ? new Vector3(0.34, -1, 0.3).normalize() : new Vector3(0, -0.82, 0.86).normalize();
  }

  /**
   * Distance at which all of the world is in sight.
   * @param {Vector3} direction
   */
  fit(direction) {
    const probe = this.camera.clone();
    const middle = this.middle();
    const corners = [];
    for (const x of [0, this.size[0]]) for (const y of [0, this.size[1]]) for (const z of this.levels) corners.push(new Vector3(x, y, z));
    let [near, far] = [this.span * 0.2, this.span * 10];
    for (let k = 0; k < 24; k++) {
      const distance = (near + far) / 2;
      probe.position.copy(middle).addScaledVector(direction, distance);
      probe.lookAt(middle);
      probe.updateMatrixWorld();
      const inside = corners.every((corner) => {
        const seen = corner.clone().project(probe);
        return Math.abs(seen.x) < 0.94 && Math.abs(seen.y) < 0.86 && seen.z < 1;
      });
      if (inside) far = distance;
      else near = distance;
    }
    return far;
  }

  /**
   * Looks from a preset.
   * @param {Preset} preset
   * @param {boolean} [fly] whether the camera moves there smoothly
   */
  look(preset, fly = true) {
    this.preset = preset;
    this.touched = false;
    const direction = this.direction(preset);
    let target = this.middle();
    let distance = this.fit(direction);
    if (preset === "follow" && this.followed) {
      target = this.followed.clone();
      distance = Math.min(distance, Math.max(this.span * 0.14, this.controls.minDistance * 4));
    }
    const to = [target.clone().addScaledVector(direction, distance), target];
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (fly && !still) this.flight = { from: [this.camera.position.clone(), this.controls.target.clone()], to, start: performance.now() };
    else this.put(to);
  }

  /** @param {Vector3[]} places of camera and target */
  put([position, target]) {
    this.flight = null;
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.controls.update();
  }

  /**
   * Where the followed organism is now.
   * @param {Vector3 | null} place
   */
  follow(place) {
    if (place && this.followed && this.preset === "follow") {
      const step = place.clone().sub(this.followed);
      if (this.flight) for (const end of this.flight.to) end.add(step);
      else {
        this.camera.position.add(step);
        this.controls.target.add(step);
      }
    }
    this.followed = place ? place.clone() : null;
  }

  /**
   * Moves on; says whether anything moved.
   * @param {number} now [ms]
   */
  update(now) {
    if (this.flight) {
      const share = Math.min(1, (now - this.flight.start) / FLIGHT);
      const eased = share * share * (3 - 2 * share);
      const { from, to } = this.flight;
      this.camera.position.lerpVectors(from[0], to[0], eased);
      this.controls.target.lerpVectors(from[1], to[1], eased);
      if (share >= 1) this.flight = null;
      this.controls.update();
      return true;
    }
    return this.controls.update();
  }

  /**
   * By keyboard: moves along the ground, turns, comes nearer.
   * @param {number} right share of the distance to the target
   * @param {number} ahead
   * @param {number} [turn] [rad]
   * @param {number} [zoom] factor
   * @param {number} [tilt] [rad] towards the view from above
   */
  nudge(right, ahead, turn = 0, zoom = 1, tilt = 0) {
    this.touched = true;
    this.flight = null;
    const arm = this.camera.position.clone().sub(this.controls.target);
    const forward = arm.clone().setZ(0).normalize().negate();
    const side = new Vector3().crossVectors(forward, UP);
    const step = side.multiplyScalar(right * arm.length()).addScaledVector(forward, ahead * arm.length());
    this.controls.target.add(step);
    const slope = Math.min(this.controls.maxPolarAngle, Math.max(0.02, arm.angleTo(UP) - tilt));
    const level = Math.hypot(arm.x, arm.y) || 1e-9;
    const length = zoom * arm.length();
    arm.set((arm.x / level) * Math.sin(slope), (arm.y / level) * Math.sin(slope), Math.cos(slope)).multiplyScalar(length).applyAxisAngle(UP, turn);
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
  }

  /** @param {number} width @param {number} height */
  resize(width, height) {
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    if (!this.touched) this.look(this.preset, false);
  }
}
