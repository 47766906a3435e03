// The period shown in the timeline: the whole time span, or a part selected with the wheel, by dragging with
// shift, with keys or with buttons.

const LEAST = 10; // [ticks] minimum displayed period
const STEP = 2; // zoom factor of keys and buttons
const NOTCH = 0.0016; // zoom of the wheel [1/px], as an exponent
const DRAGGED = 5; // [px] minimum drag that selects a period

/** @typedef {[number, number]} Ends first and last tick */

export class Stretch {
  /**
   * @param {() => Ends} whole
   * @param {() => void} changed
   */
  constructor(whole, changed) {
    this.whole = whole;
    this.changed = changed;
    /** @type {Ends | null} */
    this.part = null;
    /** @type {Ends | null} the period being selected */
    this.choosing = null;
  }

  /** First and last displayed tick. @returns {Ends} */
  get ends() {
    return this.part ?? this.whole();
  }

  /** Shows a part. @param {number} from @param {number} to */
  choose(from, to) {
    const [first, last] = this.whole();
    const length = Math.round(Math.min(last - first, Math.max(LEAST, to - from)));
    const start = Math.round(Math.min(last - length, Math.max(first, from)));
    this.part = length >= last - first ? null : [start, start + length];
    this.changed();
  }

  /**
   * Zooms by a factor while a tick keeps its position.
   * @param {number} factor
   * @param {number} about
   */
  zoom(factor, about) {
    const [from, to] = this.ends;
    const length = Math.max(LEAST, (to - from) * factor);
    const start = about - ((about - from) / Math.max(1, to - from)) * length;
    this.choose(start, start + length);
  }

  /** Zooms with a key or a button: in if `way` is 1, out if it is −1. If the tick is out of view, it moves to the middle. @param {number} way @param {number} tick */
  step(way, tick) {
    const [from, to] = this.ends;
    const length = (to - from) * STEP ** -way;
    if (tick >= from && tick <= to) this.zoom(STEP ** -way, tick);
    else this.choose(tick - length / 2, tick + length / 2);
  }

  /** Moves by a share of the displayed period. @param {number} share */
  move(share) {
    if (!this.part) return;
    const by = (this.part[1] - this.part[0]) * share;
    this.choose(this.part[0] + by, this.part[1] + by);
  }

  /** Shows all time. */
  all() {
    this.part = null;
    this.changed();
  }

  /** Moves the displayed period when the current tick leaves it. @param {number} before @param {number} now */
  follow(before, now) {
    if (!this.part) return;
    const [from, to] = this.part;
    if (before < from || before > to || (now >= from && now <= to)) return;
    const start = now > to && now - to < to - from ? now - 0.1 * (to - from) : now - 0.5 * (to - from);
    this.choose(start, start + to - from);
  }

  /**
   * Zooms with the wheel, moves by horizontal scrolling or with shift and wheel, and selects a period by dragging with shift.
   * @param {HTMLElement} root
   * @param {(x: number) => number} tickAt [px] from the left of the window
   */
  listen(root, tickAt) {
    root.addEventListener("wheel", (event) => {
      event.preventDefault();
      const sideways = event.shiftKey && !event.deltaX ? event.deltaY : event.deltaX;
      if (Math.abs(sideways) > Math.abs(event.shiftKey ? 0 : event.deltaY)) this.move(sideways / root.clientWidth);
      else this.zoom(Math.exp(event.deltaY * NOTCH * (event.deltaMode === 1 ? 30 : 1)), tickAt(event.clientX));
    }, { passive: false });
    let from = 0;
    root.addEventListener("pointerdown", (event) => {
      if (!event.shiftKey || event.button !== 0) return;
      event.preventDefault();
      event.stopPropagation(); // so that the slider does not move
      from = event.clientX;
      this.choosing = [tickAt(from), tickAt(from)];
      root.setPointerCapture(event.pointerId);
    }, { capture: true });
    root.addEventListener("mousedown", (event) => event.shiftKey && event.preventDefault(), { capture: true });
    root.addEventListener("pointermove", (event) => {
      if (!this.choosing) return;
      this.choosing = /** @type {Ends} */ ([tickAt(from), tickAt(event.clientX)].sort((a, b) => a - b));
      this.changed();
    });
    root.addEventListener("pointerup", (event) => {
      const chosen = this.choosing;
      this.choosing = null;
      if (chosen && Math.abs(event.clientX - from) > DRAGGED) this.choose(...chosen);
      else if (chosen) this.changed();
    });
    root.addEventListener("pointercancel", () => {
      this.choosing = null;
      this.changed();
    });
  }
}
