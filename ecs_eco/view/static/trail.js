// The track of the selected organism over recent frames.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, LineBasicMaterial, LineSegments } from "./vendor.js";

const LONG = 240; // maximum number of steps

export class Trail {
  /** @param {import("./stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    const geometry = new BufferGeometry();
    this.attribute = new BufferAttribute(new Float32Array(LONG * 6), 3).setUsage(DynamicDrawUsage);
    geometry.setAttribute("position", this.attribute);
    this.drawn = new LineSegments(geometry, new LineBasicMaterial({ color: "#8aa0ab", transparent: true, opacity: 0.8 }));
    this.drawn.frustumCulled = false;
    stage.scene.add(this.drawn);
    this.count = this.frame = 0;
    /** @type {import("./vendor.js").Vector3 | null} */
    this.last = null;
  }

  /** Clears the track. */
  clear() {
    this.count = 0;
    this.last = null;
    this.drawn.geometry.setDrawRange(0, 0);
  }

  /** Extends the track. @param {import("./vendor.js").Vector3 | null} place */
  step(place) {
    const { stage, last } = this;
    if (!place || this.frame === stage.frames) return;
    this.frame = stage.frames;
    this.last = place.clone();
    if (!last || last.distanceTo(place) > 0.2 * Math.min(stage.hello.size[0], stage.hello.size[1])) return;
    const slot = this.count++ % LONG;
    this.attribute.setXYZ(2 * slot, last.x, last.y, last.z);
    this.attribute.setXYZ(2 * slot + 1, place.x, place.y, place.z);
    this.attribute.needsUpdate = true;
    this.drawn.geometry.setDrawRange(0, 2 * Math.min(this.count, LONG));
  }
}
