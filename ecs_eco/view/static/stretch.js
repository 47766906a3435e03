// The stretch of time that the timeline shows: all of it, or a part that is chosen by the wheel, by dragging with shift, by keys or by buttons.

const LEAST = 10; // [ticks] that are shown
const STEP = 2; // by which a key or a button zooms
const NOTCH = 0.0016; // of the wheel [1/px], as an exponent
const DRAGGED = 5; // [px] from which a drag chooses a stretch

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
    /** @type {Ends | null} what is being dragged over */
    this.choosing = null;
  }

  /** First and last tick that are shown. @returns {Ends} */
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
   * Shows so much more, or less, so that a tick stays where it is.
   * @param {number} factor
   * @param {number} about
   */
  zoom(factor, about) {
    const [from, to] = this.ends;
    const length = Math.max(LEAST, (to - from) * factor);
    const start = about - ((about - from) / Math.max(1, to - from)) * length;
    this.choose(start, start + length);
  }

  /** By a key or a button: nearer where `way` is 1, farther where it is −1; a tick that is out of sight comes to the middle. @param {number} way @param {number} tick */
  step(way, tick) {
    const [from, to] = this.ends;
    const length = (to - from) * STEP ** -way;
    if (tick >= from && tick <= to) this.zoom(STEP ** -way, tick);
    else this.choose(tick - length / 2, tick + length / 2);
  }

  /** Moves along by a share of what is shown. @param {number} share */
  move(share) {
    if (!this.part) return;
    const by = (this.part[1] - this.part[0]) * share;
    this.choose(this.part[0] + by, this.part[1] + by);
  }

  /** Shows the whole time. */
  all() {
    this.part = null;
    this.changed();
  }

  /** Time goes on: a stretch that it leaves goes with it. @param {number} before @param {number} now */
  follow(before, now) {
    if (!this.part) return;
    const [from, to] = this.part;
    if (before < from || before > to || (now >= from && now <= to)) return;
    const start = now > to && now - to < to - from ? now - 0.1 * (to - from) : now - 0.5 * (to - from);
    this.choose(start, start + to - from);
  }

  /**
   * Zooms by the wheel, moves by it sideways or with shift, and chooses what is dragged over with shift.
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
      event.stopPropagation(); // the slider stays
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
