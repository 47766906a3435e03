// Who is selected, and in which of two worlds: that world's scene leads; in the other one those who are in both have a ring, too.

/** @typedef {import("./stage.js").Stage} Stage */

export class Chosen {
  /** @param {{first: () => Stage | null, second: () => Stage | null}} stages */
  constructor(stages) {
    this.stages = stages;
    /** @type {number | null} */
    this.uid = null;
    this.second = false;
  }

  /** The scene of the world that it is of. */
  get stage() {
    return this.second ? this.stages.second() : this.stages.first();
  }

  /** The scene of the other world. */
  get other() {
    return this.second ? this.stages.first() : this.stages.second();
  }

  /** Where it is drawn, null where it is not [m]. */
  get place() {
    return this.uid === null ? null : this.stage?.place(this.uid) ?? null;
  }

  /** @param {number | null} uid @param {boolean} second whether it is one of the second world */
  take(uid, second) {
    this.uid = uid;
    this.second = second && uid !== null;
    this.mark();
  }

  /** Marks it in its own scene, and in no other one until it is known to be in both. */
  mark() {
    for (const stage of [this.stage, this.other]) if (stage) stage.over.organism = null;
    this.stage?.select(this.uid);
    this.other?.select(null);
  }

  /** What a request says of it. */
  get asked() {
    return { uid: this.uid, ...(this.second ? { second: true } : {}) };
  }

  /** Takes its state; returns whether it is that of the selected one. @param {import("./protocol.js").Organism} organism */
  told(organism) {
    if (organism.uid !== this.uid || (organism.second ?? false) !== this.second) return false;
    if (this.stage) (this.stage.over.organism = organism), (this.stage.dirty = true);
    if (this.other && (this.other.selected !== null) !== (organism.both ?? false)) this.other.select(organism.both ? this.uid : null);
    return true;
  }

  /** Whether the camera follows it. */
  get followed() {
    return this.stage?.eye.preset === "follow";
  }

  /** Lets the camera follow it: that of its own scene, whose look the other one copies. */
  follow() {
    const { stage, other } = this;
    if (!stage) return;
    if (other) this.stay(other);
    stage.eye.followed = this.place;
    stage.eye.look("follow");
    stage.eye.touched ||= this.second; // it is not laid out anew by itself
    stage.dirty = true;
  }

  /** The camera of a scene follows nobody. @param {Stage} stage */
  stay({ eye }) {
    if (eye.preset === "follow") (eye.preset = "side"), (eye.touched = true);
  }
}
