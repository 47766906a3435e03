// Interventions. Each one is an entry in [[interventions]] without a tick, which the server adds.

import { $, h, number } from "./dom.js";
import { Changes, Knobs } from "./knobs.js";

/** @typedef {import("./protocol.js").Parameter} Parameter */

const FENCE = ["Click one corner of the fence in the scene. Esc stops.", "Click the opposite corner of the fence. Esc stops."];

export class Act {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {{send: (what: Record<string, unknown>, as?: string) => void, aim: (words: string | null) => void, ask: () => void, now: () => number, back: (tick: number) => void, selected: () => {uid: number, species: string} | null}} calls
   */
  constructor(hello, calls) {
    this.hello = hello;
    this.calls = calls;
    this.names = [...hello.species, ...(hello.objects ?? [])].map(({ name }) => name);
    this.page = 0; // this page's number
    /** @type {string | undefined} */
    this.done = undefined;
    this.aiming = false;
    /** @type {number[][] | null} fence corners clicked so far; null if clicks place organisms */
    this.corners = null;
    this.sent = 0;
    this.changes = new Changes({ send: (what, as) => this.request(what, as), back: calls.back, now: calls.now });
    this.knobs = new Knobs(this.changes);
    this.log = h("ol", { class: "log", "aria-live": "polite" });
    $("act").replaceChildren(h("div", { class: "row undo" }, ...this.changes.buttons()), this.place(), this.cull(), ...(hello.size.length < 3 ? [this.fences()] : []), this.switches(), this.change(), h("h2", { text: "Log of all pages" }), this.log);
  }

  /** Sends an intervention that can be undone if the world can go back. @param {Record<string, unknown>} what */
  send(what) {
    if (this.hello.rewinds) this.changes.did(what);
    this.request(what);
  }

  /** @param {Record<string, unknown>} what @param {string} [as] its origin: "undo" or "reset" */
  request(what, as) {
    this.sent++;
    this.calls.send(what, as);
  }

  place() {
    this.newcomer = choice(this.names, "Kind to place");
    const count = h("input", { class: "input", type: "number", min: 1, max: 100000, value: 10, "aria-label": "How many" });
    this.many = count;
    this.aimer = h("button", { class: "button", type: "button", "aria-pressed": "false", text: "Click in the scene", onclick: () => this.aim(!this.aiming || this.corners !== null) });
    const random = h("button", { class: "button primary", type: "button", text: "At random positions", onclick: () => {
      if (count.reportValidity()) this.send({ kind: "add", species: this.newcomer?.value, count: Number(count.value) });
    } });
    return group("Place", h("label", { text: "kind" }), this.newcomer, h("label", { text: "how many" }), count, h("div", { class: "row full" }, random, this.aimer));
  }

  /** Turns placement by clicks on or off, for organisms or fence corners. @param {boolean} on @param {boolean} [fence] */
  aim(on, fence = false) {
    if (!on && !this.aiming) return;
    this.aiming = on;
    this.corners = on && fence ? [] : null;
    this.aimer?.setAttribute("aria-pressed", String(on && !fence));
    this.fencer?.setAttribute("aria-pressed", String(on && fence));
    this.calls.aim(!on ? null : fence ? FENCE[0] : "Click in the scene to place organisms. Esc stops.");
  }

  fences() {
    this.fencer = h("button", { class: "button", type: "button", "aria-pressed": "false", text: "Put up a fence", onclick: () => this.aim(this.corners === null, true) });
    const none = h("button", { class: "button", type: "button", text: "Remove all fences", onclick: () => this.send({ kind: "fence", remove: true }) });
    return group("Fence", h("p", { class: "about", text: "Walking animals cannot cross it; smells, sight and births can." }), h("div", { class: "row full" }, this.fencer, none));
  }

  /** @param {number[]} place [m] */
  placeAt(place) {
    const at = place.map((value) => Math.round(value * 100) / 100);
    if (this.corners) {
      this.corners.push(at);
      if (this.corners.length < 2) return this.calls.aim(FENCE[1]);
      const [[a, b], [c, d]] = this.corners;
      this.aim(false);
      return this.send({ kind: "fence", region: [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)] });
    }
    if (!this.many?.reportValidity()) return;
    this.send({ kind: "add", species: this.newcomer?.value, count: Number(this.many.value), at_place: at });
  }

  cull() {
    const species = choice(this.names, "Kind to cull");
    const share = h("input", { type: "range", min: 1, max: 100, value: 20, "aria-label": "Share to cull, in percent" });
    const text = h("output", { text: "20%", style: "min-width:48px;text-align:right" });
    share.addEventListener("input", () => (text.textContent = `${share.value}%`));
    const which = choice(["random", "oldest", "youngest", "richest", "poorest", "largest", "smallest"], "Order");
    this.remover = h("button", { class: "button danger", type: "button", text: "Remove the selected organism", disabled: true, onclick: () => {
      const selected = this.calls.selected();
      if (selected) this.send({ kind: "cull", species: selected.species, uids: [selected.uid], cause: "removed" });
    } });
    const go = h("button", { class: "button primary", type: "button", text: "Cull", onclick: () =>
      this.send({ kind: "cull", species: species.value, share: Number(share.value) / 100, which: which.value }) });
    return group("Cull", h("label", { text: "kind" }), species, h("label", { text: "share" }), h("div", { class: "row" }, share, text),
      h("label", { text: "order" }), which, h("div", { class: "row full" }, go, this.remover));
  }

  switches() {
    const all = "all species";
    const species = choice([all, ...this.hello.species.map(({ name }) => name)], "Species");
    this.switched = species;
    species.addEventListener("change", () => this.standing(this.switchedAs));
    const button = (/** @type {"reproduction" | "learning"} */ what, /** @type {boolean} */ on) => h("button", {
      class: "button", type: "button", text: on ? "on" : "off", "aria-label": `${what} ${on ? "on" : "off"}`, "data-switch": `${what} ${on}`, "aria-pressed": "false",
      onclick: () => this.send({ kind: "switch", [what]: on, ...(species.value === all ? {} : { species: species.value }) }),
    });
    const row = (/** @type {"reproduction" | "learning"} */ what) => [h("label", { text: what }), h("div", { class: "row" }, button(what, true), button(what, false))];
    return group("Switch", h("label", { text: "species" }), species, ...row("reproduction"), ...row("learning"));
  }

  /** Updates switches and log; reloads the parameters after an intervention. @param {import("./protocol.js").Marks} marks */
  mark({ switches, interventions = [] }) {
    this.standing(switches);
    const done = JSON.stringify([interventions.length, interventions.at(-1)]);
    if (this.done !== undefined && this.done !== done) this.calls.ask();
    this.done = done;
  }

  /** Shows the switch states of the chosen species, or of all species if they agree. @param {import("./protocol.js").Marks["switches"]} now */
  standing(now) {
    this.switchedAs = now;
    const all = Object.entries(now ?? {}), chosen = all.filter(([name]) => name === this.switched?.value);
    for (const button of $("act").querySelectorAll("[data-switch]")) {
      const [what, on] = /** @type {HTMLElement} */ (button).dataset.switch?.split(" ") ?? [];
      const states = (chosen.length ? chosen : all).map(([, switches]) => switches[/** @type {"learning"} */ (what)]).filter((state) => state !== null);
      button.setAttribute("aria-pressed", String(states.length > 0 && states.every((state) => String(state) === on)));
    }
  }

  change() {
    const list = h("datalist", { id: "parameterKeys" });
    const key = h("input", { class: "input", list: "parameterKeys", placeholder: "Type to search", "aria-label": "Parameter", autocomplete: "off", spellcheck: "false" });
    const value = h("input", { class: "input", "aria-label": "New value", autocomplete: "off" });
    const about = h("p", { class: "about", text: "" });
    const slider = h("input", { type: "range", "aria-label": "Value slider", step: "any", hidden: true, oninput: () => (value.value = String(Number(Number(slider.value).toPrecision(3)))) });
    value.addEventListener("input", () => (slider.value = value.value));
    const { changes } = this, found = () => changes.find(key.value);
    const go = h("button", { class: "button primary", type: "button", text: "Change", disabled: true, onclick: () => {
      if (value.reportValidity() && found()) changes.make(key.value, read(value.value));
    } });
    let shown = /** @type {unknown} */ (null);
    changes.heard.push(() => {
      const now = found()?.value;
      if (now === undefined || now === shown) return;
      value.value = slider.value = written(shown = now);
    });
    key.addEventListener("input", () => {
      const parameter = found();
      go.disabled = !parameter;
      about.textContent = parameter ? tell(parameter) : "";
      slider.hidden = typeof parameter?.value !== "number";
      if (!parameter) return;
      value.value = written(shown = parameter.value);
      const numeric = typeof parameter.value === "number";
      value.type = numeric ? "number" : "text";
      set(value, { step: numeric ? "any" : null, min: numeric ? parameter.low : null, max: numeric ? parameter.high : null });
      if (numeric) set(slider, { min: parameter.low ?? Math.min(0, 2 * Number(parameter.value)), max: parameter.high ?? Math.max(1e-6, 2 * Number(parameter.value)) });
      slider.value = value.value;
    });
    this.keys = list;
    return group("All parameters", h("label", { text: "key" }), key, list, h("label", { text: "value" }), value, h("span"), slider, about, h("div", { class: "row full" }, go));
  }

  /** @param {Parameter[]} list @param {import("./protocol.js").Knob[]} [knobs] */
  offer(list, knobs = []) {
    this.changes.offer(list);
    this.knobs.offer(knobs);
    this.keys?.replaceChildren(...list.map(({ key, about }) => h("option", { value: key, text: about ?? "" })));
  }

  /** Enables or disables the button that removes the selected organism. @param {boolean} there */
  selected(there) {
    if (this.remover) this.remover.disabled = !there;
  }

  /** Adds entries to the log, or replaces all of them. @param {import("./protocol.js").LogMessage} message */
  record({ page, entries }) {
    if (page !== undefined) this.log.replaceChildren(), (this.page = page);
    for (const entry of entries) this.log.prepend(line(entry, entry.page === this.page));
    while (this.log.childElementCount > 200) this.log.lastElementChild?.remove();
    const refused = entries.some(({ level, asked, page }) => level === "error" && asked === "act" && page === this.page);
    if (page === undefined && refused) this.changes.refused();
  }
}

/** A line in the log. @param {import("./protocol.js").LogEntry} entry @param {boolean} own whether this page sent the request */
function line({ tick, page, level, text, what, as }, own) {
  const who = page === null ? "the world" : own ? "this page" : `page ${page}`;
  const begin = level === "error" && page !== null ? `refused: ${what ? `${what}. ` : ""}` : as ? `${as}: ` : "";
  return h("li", { class: level }, h("time", { text: number(tick), title: "tick" }), h("b", { text: who }), h("span", { text: begin + text }));
}

/** @param {string} title @param {...(Node | null)} content */
const group = (title, ...content) => h("fieldset", {}, h("legend", { text: title }), h("div", { class: "form" }, ...content));

/** @param {string[]} names @param {string} label */
const choice = (names, label) => h("select", { class: "input", "aria-label": label }, ...names.map((name) => h("option", { text: name, value: name })));

/** A one-line description of a parameter. @param {Parameter} parameter */
function tell({ about, unit, low, high }) {
  const limits = low !== null && low !== undefined ? (high !== null && high !== undefined ? `, ${number(low)} to ${number(high)}` : `, at least ${number(low)}`) : "";
  return `${about ?? ""}${unit ? ` [${unit}]` : ""}${limits}`;
}

/** @param {unknown} value */
const written = (value) => (typeof value === "string" ? value : JSON.stringify(value));

/** Parses a number, true, false or a list; returns any other text unchanged. @param {string} text */
function read(text) {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

/** @param {HTMLElement} element @param {Record<string, number | string | null | undefined>} attributes */
function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined) element.removeAttribute(name);
    else element.setAttribute(name, String(value));
  }
}
