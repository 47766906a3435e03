// A repeating period: when its end is passed, the page asks the server to go back to its beginning.

import { $, announce, number } from "./dom.js";

const NAME = "Repeat the displayed period (R)";

export class Loop {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {import("./timeline.js").Timeline} timeline
   * @param {(request: {kind: string, [key: string]: unknown}) => void} send
   */
  constructor(hello, timeline, send) {
    this.hello = hello;
    this.timeline = timeline;
    this.send = send;
    /** @type {import("./protocol.js").State | null} */
    this.state = null;
    this.asked = false; // whether the page has requested to go back
    this.held = false; // whether a stop was requested but not yet confirmed by the server
    this.possible = hello.mode === "replay" || Boolean(hello.rewinds);
    this.why = this.possible ? "" : hello.stays || "this world cannot go back in time";
    this.say();
  }

  /** The repeating period, or null. */
  get ends() {
    return this.timeline.loop;
  }

  /** @param {import("./stretch.js").Ends | null} ends */
  set(ends) {
    this.timeline.loop = ends;
    this.asked = false;
    this.say();
    this.timeline.draw();
  }

  /** Turns repetition of the displayed period on or off. */
  toggle() {
    if (!this.possible) return announce(`Cannot repeat: ${this.why}`);
    if (this.ends) this.set(null);
    else {
      const [from, to] = this.timeline.stretch.ends, { newest } = this.timeline;
      const end = this.hello.mode === "live" ? Math.min(to, Math.max(newest, from + 1)) : to;
      this.set([from, end]);
      if (this.state?.playing && this.timeline.tick < from && from <= newest) this.again();
    }
    announce(this.ends ? this.words() : "Repeat is off");
  }

  words() {
    return this.ends ? `Repeating ticks ${number(this.ends[0])} to ${number(this.ends[1])}` : "";
  }

  say() {
    const button = $("loop");
    button.disabled = !this.possible;
    button.setAttribute("aria-pressed", String(this.ends !== null));
    button.title = this.why ? `${NAME}: not available, ${this.why}` : this.ends ? `${this.words()} (R)` : NAME;
  }

  /** Goes back to the beginning of the period and continues playing. */
  again() {
    if (!this.ends) return;
    this.asked = true;
    this.send({ kind: "seek", tick: this.ends[0] });
    this.send({ kind: "play" }); // a recorded run stops at its end
  }

  /** Called when time reaches a tick. @param {number} tick */
  at(tick) {
    if (this.ends && this.state?.playing && !this.held && !this.asked && tick >= this.ends[1]) this.again();
  }

  /** @param {import("./protocol.js").State} now */
  heard(now) {
    const before = this.state;
    this.state = now;
    this.held = false;
    if (!this.ends) return;
    if (now.tick < this.ends[1]) this.asked = false;
    if (now.done && before?.playing && !now.playing && !this.asked) this.again();
    this.at(now.tick);
  }
}
