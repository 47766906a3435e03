// Buttons and keys that play, pause, step, and set the speed, the displayed period and its repetition.

import { $, number } from "./dom.js";
import { BACK, PAUSE, PLAY, STEP } from "./icons.js";
import { showSpeed, speedAt } from "./speed.js";

/** @typedef {import("./protocol.js").State} State */

export class Transport {
  /**
   * @param {{page: () => {hello: import("./protocol.js").Hello, stage: import("./stage.js").Stage, timeline: import("./timeline.js").Timeline, loop: import("./loop.js").Loop} | null,
   *   send: (request: {kind: string, [key: string]: unknown}) => void, played: () => void}} calls
   */
  constructor(calls) {
    this.calls = calls;
    /** @type {State | null} */
    this.state = null;
    for (const [id, icon] of Object.entries({ play: PLAY, step: STEP, back: BACK })) $(id).innerHTML = icon;
    const does = { back: () => this.back(), play: () => this.play(), step: () => this.step(1), shorter: () => this.zoom(1), longer: () => this.zoom(-1), whole: () => this.whole(), loop: () => this.loop() };
    for (const [id, work] of Object.entries(does)) $(id).addEventListener("click", work);
    $("speed").addEventListener("input", () => this.speed(Number($("speed").value)));
  }

  /** @param {State} now */
  show(now) {
    const hello = this.calls.page()?.hello;
    const changed = this.state?.playing !== now.playing;
    this.state = now;
    if (changed) {
      $("play").innerHTML = now.playing ? PAUSE : PLAY;
      $("play").setAttribute("aria-label", now.playing ? "Pause" : "Play");
    }
    const over = now.done && hello?.mode === "live";
    $("step").disabled = now.done;
    $("back").disabled = now.tick <= (hello?.first ?? 0) || (hello?.mode === "live" && !hello.rewinds);
    $("play").disabled = over;
    $("rate").textContent = over ? "done" : now.done ? "the end" : now.playing ? `${number(now.rate, 2)} ticks/s` : now.tick === hello?.first ? "press Play" : "paused";
    showSpeed(now.speed);
    this.calls.page()?.loop.heard(now);
  }

  /** @param {number} slot */
  speed(slot) {
    this.calls.send({ kind: "speed", value: speedAt(slot) });
  }

  /** Plays or pauses; at the end of a recorded run, plays from its beginning or from the start of the repeating period. */
  play() {
    const page = this.calls.page();
    if (this.state?.done && page?.hello.mode === "replay") this.calls.send({ kind: "seek", tick: page.loop.ends?.[0] ?? page.hello.first });
    this.calls.send({ kind: this.state?.playing ? "pause" : "play" });
    if (page && this.state?.playing) page.loop.held = true;
    this.calls.played();
  }

  /** @param {number} ticks */
  step(ticks) {
    this.calls.send({ kind: "step", ticks });
  }

  /** Goes one tick back, if that is possible. */
  back() {
    const page = this.calls.page();
    if (!page || (page.hello.mode === "live" && !page.hello.rewinds)) return;
    if (this.state?.playing) this.calls.send({ kind: "pause" });
    page.loop.held = true;
    this.calls.send({ kind: "seek", tick: Math.max(page.hello.first, (this.state?.tick ?? page.stage.tick) - 1) });
  }

  /** Selects a shorter (1) or longer (−1) period. @param {number} way */
  zoom(way) {
    const timeline = this.calls.page()?.timeline;
    timeline?.stretch.step(way, timeline.tick);
  }

  whole() {
    this.calls.page()?.timeline.stretch.all();
  }

  loop() {
    this.calls.page()?.loop.toggle();
  }
}
