// Sliders for the knobs of a world, and undo for what was done on this page.

import { $, h, number } from "./dom.js";

/** @typedef {import("./protocol.js").Parameter} Parameter @typedef {import("./protocol.js").Knob} Knob */

/** @typedef {{tick: number, what: Record<string, unknown>, key?: string, value?: unknown}} Change an intervention at a tick; of a parameter: its previous value */

const PATIENCE = 10_000; // [ms] for which values from before a change of this page are ignored

/** The current values of parameters, and the interventions of this page. */
export class Changes {
  /** @param {{send: (what: Record<string, unknown>, as?: string) => void, back: (tick: number) => void, now: () => number}} calls */
  constructor(calls) {
    this.calls = calls;
    /** @type {Change[]} interventions that can be undone, latest last */
    this.before = [];
    /** @type {Change | undefined} the last one, until it is undone or refused */
    this.last = undefined;
    /** @type {Parameter[]} */
    this.list = [];
    /** @type {Map<string, unknown>} parameter values when this page opened */
    this.first = new Map();
    /** @type {Map<string, {value: unknown, until: number}>} values that were sent, until the server confirms them */
    this.asked = new Map();
    /** @type {(() => void)[]} callbacks for changed values */
    this.heard = [];
  }

  /** @param {Parameter[]} list with current values */
  offer(list) {
    this.list = list;
    for (const parameter of list) {
      const { key, value } = parameter, asked = this.asked.get(key);
      if (!this.first.has(key)) this.first.set(key, value);
      if (asked && JSON.stringify(value) !== JSON.stringify(asked.value) && performance.now() < asked.until) parameter.value = asked.value;
      else this.asked.delete(key);
    }
    this.tell();
  }

  /** @param {string} key */
  find(key) {
    return this.list.find((parameter) => parameter.key === key);
  }

  /** @param {string} key @param {unknown} value */
  make(key, value) {
    const parameter = this.find(key);
    if (!parameter) return;
    this.did({ kind: "set", set: { [key]: value } }, { key, value: parameter.value });
    this.set({ [key]: value });
  }

  /** Notes an intervention, before it is sent. @param {Record<string, unknown>} what @param {{key?: string, value?: unknown}} [of] */
  did(what, of = {}) {
    this.before.push((this.last = { tick: this.calls.now(), what, ...of }));
    this.tell();
  }

  /** Undoes the last n: values are set back, and for anything else the world goes back to the tick before it. @param {number} n @param {string} as */
  back(n, as) {
    this.last = undefined;
    const gone = this.before.splice(-n), at = gone.findIndex(({ key }) => key === undefined), { tick } = gone[at] ?? {};
    const values = (at < 0 ? gone : gone.slice(0, at)).reverse().map(({ key, value }) => [key, value]);
    if (tick !== undefined) {
      this.calls.back(tick);
      for (const { what } of this.before.filter((one) => one.tick >= tick)) this.calls.send(what); // it forgot these, too
    }
    if (values.length) this.set(Object.fromEntries(values), as);
    this.tell();
  }

  /** Forgets interventions that the world no longer contains, because it has gone back. @param {number} tick */
  time(tick) {
    if (!this.before.some((one) => one.tick > tick)) return;
    this.before = this.before.filter((one) => one.tick <= tick);
    this.tell();
  }

  /** Restores the state before the last one, because it was refused. */
  refused() {
    const { last } = this, parameter = last?.key && this.find(last.key);
    if (!last || this.before.at(-1) !== last) return;
    this.before.pop();
    this.last = undefined;
    if (parameter) parameter.value = last.value;
    this.asked.delete(String(last.key));
    this.tell();
  }

  /** @param {Record<string, unknown>} values @param {string} [as] */
  set(values, as) {
    for (const [key, value] of Object.entries(values)) {
      const parameter = this.find(key);
      if (parameter) parameter.value = value;
      this.asked.set(key, { value, until: performance.now() + PATIENCE });
    }
    this.calls.send({ kind: "set", set: values }, as);
    this.tell();
  }

  tell() {
    for (const listener of this.heard) listener();
  }

  /** Buttons that undo the last change or all changes. */
  buttons() {
    const undo = h("button", { class: "button", type: "button", text: "Undo", title: "Undo the last change. A changed value is set back; for any other change, the world goes back to the tick before it", disabled: true, onclick: () => this.back(1, "undo") });
    const reset = h("button", { class: "button", type: "button", text: "Reset all", title: "Undo all changes", disabled: true, onclick: () => this.back(this.before.length, "reset") });
    this.heard.push(() => (undo.disabled = reset.disabled = !this.before.length));
    return [undo, reset];
  }
}

const KEPT = "ecs-eco-knobs"; // in localStorage: whether they are unfolded
export const WIDE = 900; // [px] scenes of at least this width have space for them

/** Sliders for the knobs of a world, in the scene: unfolded if there is space, or as the user left them. */
export class Knobs {
  /** @param {Changes} changes */
  constructor(changes) {
    this.changes = changes;
    this.list = h("div", { class: "knobs" });
    this.element = /** @type {HTMLDetailsElement} */ ($("knobs"));
    const fit = () => (this.element.open = $("stage").clientWidth >= WIDE), unfold = new ResizeObserver(fit);
    this.element.replaceChildren(h("summary", { text: "Knobs", onclick: () => {
      unfold.disconnect();
      try {
        localStorage.setItem(KEPT, this.element.open ? "folded" : "open");
      } catch {} // storage may be unavailable in private windows
    } }), this.list, h("div", { class: "row" }, ...changes.buttons()));
    let kept = null;
    try {
      kept = localStorage.getItem(KEPT);
    } catch {}
    if (kept) this.element.open = kept === "open";
    else fit(), unfold.observe($("stage"));
    /** @type {{knob: Knob, slider: HTMLInputElement, show: () => void}[]} */
    this.sliders = [];
    changes.heard.push(() => this.sliders.forEach(({ show }) => show()));
  }

  /** @param {Knob[]} knobs */
  offer(knobs) {
    this.element.hidden = !knobs.length;
    if (JSON.stringify(knobs) === JSON.stringify(this.sliders.map(({ knob }) => knob))) return;
    this.sliders = knobs.map((knob, i) => this.slider(knob, `knob${i}`));
    for (const { show } of this.sliders) show();
  }

  /** @param {Knob} knob @param {string} id */
  slider(knob, id) {
    if (id === "knob0") this.list.replaceChildren();
    const { changes } = this, { key, label, unit } = knob;
    const text = h("output", { for: id }), parameter = () => changes.find(key);
    const tell = (/** @type {number} */ value) => (text.textContent = `${number(value)}${unit && unit !== "1" ? ` ${unit}` : ""}`);
    const chosen = () => {
      const value = Math.min(Number(slider.max), Math.max(Number(slider.min), Number(Number(slider.value).toPrecision(3))));
      return parameter()?.whole ? Math.round(value) : value;
    };
    let sliding = false;
    const slider = h("input", { type: "range", id, oninput: () => [(sliding = true), tell(chosen())], onchange: () => {
      sliding = false;
      if (chosen() !== parameter()?.value) changes.make(key, chosen());
    } });
    const reset = h("button", { class: "mini", type: "button", text: "↺", title: "Restore the value that it had when this page opened", "aria-label": `Reset ${label}`, onclick: () => changes.make(key, changes.first.get(key)) });
    const show = () => {
      const value = Number(parameter()?.value), ends = [Math.min(knob.low, value), Math.max(knob.high, value)];
      if (sliding || Number.isNaN(value)) return;
      Object.assign(slider, { min: String(ends[0]), max: String(ends[1]), step: parameter()?.whole ? "1" : String((ends[1] - ends[0]) / 200) });
      slider.value = String(value);
      tell(value);
      reset.disabled = changes.first.get(key) === value;
    };
    this.list.append(h("label", { for: id, text: label, title: [key, parameter()?.about].filter(Boolean).join(": ") }), text, slider, reset);
    return { knob, slider, show };
  }
}
