// The selected organism and its world. That world's scene controls the camera; the other scene also marks the organism with a ring if it exists in both worlds.

/** @typedef {import("./stage.js").Stage} Stage */

export class Chosen {
  /** @param {{first: () => Stage | null, second: () => Stage | null}} stages */
  constructor(stages) {
    this.stages = stages;
    /** @type {number | null} */
    this.uid = null;
    this.second = false;
  }

  /** The scene of the organism's world. */
  get stage() {
    return this.second ? this.stages.second() : this.stages.first();
  }

  /** The scene of the other world. */
  get other() {
    return this.second ? this.stages.first() : this.stages.second();
  }

  /** The organism's position in the scene [m], or null if it is not drawn. */
  get place() {
    return this.uid === null ? null : this.stage?.place(this.uid) ?? null;
  }

  /** @param {number | null} uid @param {boolean} second whether it belongs to the second world */
  take(uid, second) {
    this.uid = uid;
    this.second = second && uid !== null;
    this.mark();
  }

  /** Marks the organism in its own scene, and in the other scene only if it is known to exist in both. */
  mark() {
    for (const stage of [this.stage, this.other]) if (stage) stage.over.organism = null;
    this.stage?.select(this.uid);
    this.other?.select(null);
  }

  /** The request fields that identify the organism. */
  get asked() {
    return { uid: this.uid, ...(this.second ? { second: true } : {}) };
  }

  /** Stores a state; returns whether it belongs to the selected organism. @param {import("./protocol.js").Organism} organism */
  told(organism) {
    if (organism.uid !== this.uid || (organism.second ?? false) !== this.second) return false;
    if (this.stage) (this.stage.over.organism = organism), (this.stage.dirty = true);
    if (this.other && (this.other.selected !== null) !== (organism.both ?? false)) this.other.select(organism.both ? this.uid : null);
    return true;
  }

  /** Whether the camera follows the organism. */
  get followed() {
    return this.stage?.eye.preset === "follow";
  }

  /** Makes the camera of the organism's scene follow it; the other scene copies that camera. */
  follow() {
    const { stage, other } = this;
    if (!stage) return;
    if (other) this.stay(other);
    stage.eye.followed = this.place;
    stage.eye.look("follow");
    stage.eye.touched ||= this.second; // keeps the camera when the layout changes
    stage.dirty = true;
  }

  /** Stops a scene's camera from following the organism. @param {Stage} stage */
  stay({ eye }) {
    if (eye.preset === "follow") (eye.preset = "side"), (eye.touched = true);
  }
}
