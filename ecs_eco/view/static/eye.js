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
   * @param {number} largest radius of the largest body [m], which the camera does not enter
   */
  constructor(canvas, size, levels, largest) {
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
    this.controls.minDistance = Math.max(this.span / 600, 5 * largest);
    this.controls.mouseButtons = { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.ROTATE };
    this.controls.touches = { ONE: TOUCH.PAN, TWO: TOUCH.DOLLY_ROTATE };
    this.controls.maxPolarAngle = size.length > 2 ? Math.PI * 0.92 : Math.PI * 0.49;
    /** @type {Preset} */
    this.preset = "side";
    this.touched = false; // whether the user has moved the camera since the preset was chosen
    this.controls.addEventListener("start", () => {
      this.touched = true;
      this.flight = null;
    });
    /** @type {{from: Vector3[], to: Vector3[], start: number, lasts: number} | null} */
    this.flight = null;
    /** @type {Vector3 | null} */
    this.followed = null;
    /** @type {() => number[][]} the left, top, right and bottom [px] of each element over the scene */
    this.cover = () => [];
    /** @type {number[][]} the same at the last check */
    this.covered = [];
    this.width = this.height = 1; // [px]
    this.shift = [0, 0]; // shift of the picture [px] that keeps the world clear of these elements
  }

  /** The center of the world. */
  middle() {
    return new Vector3(this.size[0] / 2, this.size[1] / 2, (this.levels[0] + this.levels[1]) / 2);
  }

  /** The viewing direction of a preset. @param {Preset} preset */
  direction(preset) {
    if (preset === "top") return new Vector3(0, -0.012, 1).normalize();
    return this.size.length > 2 ? new Vector3(0.34, -1, 0.3).normalize() : new Vector3(0, -0.86, 0.66).normalize();
  }

  /** The corners of the world and points along its edges. @param {number} parts segments per edge */
  edges(parts) {
    const points = [];
    const ends = [[0, this.size[0]], [0, this.size[1]], this.levels];
    for (let axis = 0; axis < 3; axis++)
      for (const u of ends[(axis + 1) % 3])
        for (const v of ends[(axis + 2) % 3])
          for (let k = 0; k <= parts; k++) {
            const point = new Vector3();
            point.setComponent(axis, ends[axis][0] + ((ends[axis][1] - ends[axis][0]) * k) / parts);
            points.push(point.setComponent((axis + 1) % 3, u).setComponent((axis + 2) % 3, v));
          }
    return points;
  }

  /**
   * The distance at which the whole world is in view, clear of elements over the scene, and the shift of the picture [px].
   * @param {Vector3} direction
   */
  fit(direction) {
    const [w, h] = [this.width, this.height];
    this.covered = this.cover();
    const probe = this.camera.clone();
    probe.clearViewOffset();
    const middle = this.middle();
    const points = this.edges(8);
    const clear = (/** @type {number} */ distance, /** @type {number[]} */ [dx, dy]) => {
      probe.position.copy(middle).addScaledVector(direction, distance);
      probe.lookAt(middle);
      probe.updateMatrixWorld();
      return points.every((point) => {
        const seen = point.clone().project(probe);
        const [x, y] = [((seen.x + 1) / 2) * w + dx, ((1 - seen.y) / 2) * h + dy];
        if (seen.z >= 1 || x < 0.02 * w || x > 0.98 * w || y < 0.02 * h || y > 0.98 * h) return false;
        return !this.covered.some(([left, top, right, bottom]) => x > left && x < right && y > top && y < bottom);
      });
    };
    let best = { distance: this.span * 10, shift: [0, 0] };
    for (const shift of this.shifts()) {
      let [near, far] = [this.span * 0.2, best.distance];
      if (!clear(far, shift)) continue;
      for (let k = 0; k < 16; k++) {
        const distance = (near + far) / 2;
        if (clear(distance, shift)) far = distance;
        else near = distance;
      }
      if (far < 0.99 * best.distance) best = { distance: far, shift };
    }
    return best;
  }

  /** Candidate shifts of the picture that may use the free space better. */
  shifts() {
    const [w, h] = [this.width, this.height];
    const left = Math.max(0, ...this.covered.filter(([a]) => a < w / 3).map(([, , c]) => c));
    const right = Math.max(0, ...this.covered.filter(([, , c]) => c > (2 * w) / 3).map(([a]) => w - a));
    const top = Math.max(0, ...this.covered.filter(([, b, , d]) => b < h / 3 && d < h / 2).map(([, , , d]) => d));
    return [0, 0.25, 0.5].flatMap((down) => [0, (left - right) / 2, -right / 2].map((across) => [across, down * top]));
  }

  /**
   * Moves to a preset.
   * @param {Preset} preset
   * @param {boolean} [fly] whether the camera moves smoothly
   */
  look(preset, fly = true) {
    this.preset = preset;
    this.touched = false;
    const direction = this.direction(preset);
    let target = this.middle();
    let { distance, shift } = this.fit(direction);
    if (preset === "follow" && this.followed) {
      target = this.followed.clone();
      shift = [0, 0];
      distance = Math.min(distance, Math.max(this.span * 0.08, this.controls.minDistance * 3));
    }
    this.controls.maxDistance = Math.max(this.span * 4, distance);
    this.move(shift);
    const to = [target.clone().addScaledVector(direction, distance), target];
    this.fly(to, fly ? FLIGHT : 0);
  }

  /** Moves smoothly, if the user's system allows motion. @param {Vector3[]} to positions of camera and target @param {number} lasts [ms] */
  fly(to, lasts) {
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (lasts && !still) this.flight = { from: [this.camera.position.clone(), this.controls.target.clone()], to, start: performance.now(), lasts };
    else this.put(to);
  }

  /** Shifts the picture. @param {number[]} shift [px] */
  move(shift) {
    this.shift = shift;
    this.camera.setViewOffset(this.width, this.height, -shift[0], -shift[1], this.width, this.height);
  }

  /** @param {Vector3[]} places positions of camera and target */
  put([position, target]) {
    this.flight = null;
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.controls.update();
  }

  /**
   * Sets the position of the followed organism.
   * @param {Vector3 | null} place
   */
  follow(place) {
    if (place && this.followed && this.preset === "follow") {
      const step = place.clone().sub(this.followed);
      if (this.flight) for (const end of this.flight.to) end.add(step);
      else {
        this.camera.position.add(step);
        this.controls.target.add(step);
        this.controls.update(); // reports it at once: the camera of a second world copies this one
      }
    }
    this.followed = place ? place.clone() : null;
  }

  /** Keeps the camera above the ground. @param {import("./ground.js").Relief} relief */
  rise(relief) {
    const { position, near } = this.camera, [x, y] = this.size;
    if (this.size.length > 2 || position.x < 0 || position.x > x || position.y < 0 || position.y > y) return;
    position.z = Math.max(position.z, relief.at(position.x, position.y) + 3 * near);
  }

  /**
   * Updates the camera and returns whether anything moved.
   * @param {number} now [ms]
   */
  update(now) {
    if (this.flight) {
      const share = Math.min(1, (now - this.flight.start) / this.flight.lasts);
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
   * Moves the camera by keyboard: along the ground, around the target, and closer.
   * @param {number} right as a share of the distance to the target
   * @param {number} ahead
   * @param {number} [turn] [rad]
   * @param {number} [zoom] factor
   * @param {number} [tilt] [rad] toward the view from above
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
    [this.width, this.height] = [width, Math.max(1, height)];
    this.camera.aspect = width / this.height;
    this.move(this.shift);
    if (!this.touched) this.look(this.preset, false);
  }
}
