// Interventions: what somebody does to the world. Each is an entry of [[interventions]] without its tick; the server adds that.

import { $, h, number } from "./dom.js";

/** @typedef {import("./protocol.js").Parameter} Parameter */

export class Act {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {{send: (what: Record<string, unknown>) => void, aim: (on: boolean) => void, now: () => number, selected: () => {uid: number, species: string} | null}} calls
   */
  constructor(hello, calls) {
    this.hello = hello;
    this.calls = calls;
    this.names = [...hello.species, ...(hello.objects ?? [])].map(({ name }) => name);
    this.aiming = false;
    this.sent = 0;
    /** @type {Parameter[]} */
    this.parameters = [];
    this.log = h("ol", { class: "log", "aria-live": "polite" });
    $("act").replaceChildren(this.place(), this.cull(), this.switches(), this.change(), h("h2", { text: "Done and said" }), this.log);
  }

  /** @param {Record<string, unknown>} what */
  send(what) {
    this.sent++;
    this.calls.send(what);
  }

  place() {
    this.newcomer = choice(this.names, "Kind to place");
    const count = h("input", { class: "input", type: "number", min: 1, max: 100000, value: 10, "aria-label": "How many" });
    this.many = count;
    this.aimer = h("button", { class: "button", type: "button", "aria-pressed": "false", text: "Click into the scene", onclick: () => this.aim(!this.aiming) });
    const random = h("button", { class: "button primary", type: "button", text: "At random places", onclick: () => {
      if (count.reportValidity()) this.send({ kind: "add", species: this.newcomer?.value, count: Number(count.value) });
    } });
    return group("Place", h("label", { text: "kind" }), this.newcomer, h("label", { text: "how many" }), count, h("div", { class: "row full" }, random, this.aimer));
  }

  /** Whether the next click into the scene places organisms. @param {boolean} on */
  aim(on) {
    this.aiming = on;
    this.aimer?.setAttribute("aria-pressed", String(on));
    this.calls.aim(on);
  }

  /** @param {number[]} place [m] */
  placeAt(place) {
    if (!this.many?.reportValidity()) return;
    const at = place.map((value) => Math.round(value * 100) / 100);
    this.send({ kind: "add", species: this.newcomer?.value, count: Number(this.many.value), at_place: at });
  }

  cull() {
    const species = choice(this.names, "Kind to cull");
    const share = h("input", { type: "range", min: 1, max: 100, value: 20, "aria-label": "Share that dies, in percent" });
    const text = h("output", { text: "20 %", style: "min-width:48px;text-align:right" });
    share.addEventListener("input", () => (text.textContent = `${share.value} %`));
    const which = choice(["random", "oldest", "youngest", "richest", "poorest"], "Who first");
    this.remover = h("button", { class: "button danger", type: "button", text: "Remove the selected one", disabled: true, onclick: () => {
      const selected = this.calls.selected();
      if (selected) this.send({ kind: "cull", species: selected.species, uids: [selected.uid], cause: "removed" });
    } });
    const go = h("button", { class: "button primary", type: "button", text: "Cull", onclick: () =>
      this.send({ kind: "cull", species: species.value, share: Number(share.value) / 100, which: which.value }) });
    return group("Cull", h("label", { text: "kind" }), species, h("label", { text: "share" }), h("div", { class: "row" }, share, text),
      h("label", { text: "who first" }), which, h("div", { class: "row full" }, go, this.remover));
  }

  switches() {
    const all = "all species";
    const species = choice([all, ...this.hello.species.map(({ name }) => name)], "Species");
    const button = (/** @type {"reproduction" | "learning"} */ what, /** @type {boolean} */ on) => h("button", {
      class: "button", type: "button", text: on ? "on" : "off", "aria-label": `${what} ${on ? "on" : "off"}`,
      onclick: () => this.send({ kind: "switch", [what]: on, ...(species.value === all ? {} : { species: species.value }) }),
    });
    const row = (/** @type {"reproduction" | "learning"} */ what) => [h("label", { text: what }), h("div", { class: "row" }, button(what, true), button(what, false))];
    return group("Switch", h("label", { text: "species" }), species, ...row("reproduction"), ...row("learning"));
  }

  change() {
    const list = h("datalist", { id: "parameterKeys" });
    const key = h("input", { class: "input", list: "parameterKeys", placeholder: "type to search", "aria-label": "Parameter", autocomplete: "off", spellcheck: "false" });
    const value = h("input", { class: "input", "aria-label": "New value", autocomplete: "off" });
    const about = h("p", { class: "about", text: "" });
    const go = h("button", { class: "button primary", type: "button", text: "Change", disabled: true, onclick: () => {
      const parsed = read(value.value);
      if (value.reportValidity()) this.send({ kind: "set", set: { [key.value]: parsed } });
    } });
    key.addEventListener("input", () => {
      const found = this.parameters.find((parameter) => parameter.key === key.value);
      go.disabled = !found;
      about.textContent = found ? tell(found) : "";
      if (!found) return;
      value.value = typeof found.value === "string" ? found.value : JSON.stringify(found.value);
      const numeric = typeof found.value === "number";
      value.type = numeric ? "number" : "text";
      set(value, { step: numeric ? "any" : null, min: numeric ? found.low : null, max: numeric ? found.high : null });
    });
    this.keys = list;
    return group("Change a parameter", h("label", { text: "key" }), key, list, h("label", { text: "value" }), value, about, h("div", { class: "row full" }, go));
  }

  /** @param {Parameter[]} list */
  offer(list) {
    this.parameters = list;
    this.keys?.replaceChildren(...list.map(({ key, about }) => h("option", { value: key, text: about ?? "" })));
  }

  /** Somebody else is selected. @param {boolean} there */
  selected(there) {
    if (this.remover) this.remover.disabled = !there;
  }

  /** @param {import("./protocol.js").Said} said */
  note({ level, text, field }) {
    this.log.prepend(h("li", { class: level }, h("time", { text: number(this.calls.now()) }), h("span", { text: field ? `${field}: ${text}` : text })));
    while (this.log.childElementCount > 60) this.log.lastElementChild?.remove();
  }
}

/** @param {string} title @param {...(Node | null)} content */
const group = (title, ...content) => h("fieldset", {}, h("legend", { text: title }), h("div", { class: "form" }, ...content));

/** @param {string[]} names @param {string} label */
const choice = (names, label) => h("select", { class: "input", "aria-label": label }, ...names.map((name) => h("option", { text: name, value: name })));

/** What a parameter is, in a line. @param {Parameter} parameter */
function tell({ about, unit, low, high }) {
  const limits = low !== null && low !== undefined ? (high !== null && high !== undefined ? `, ${number(low)} to ${number(high)}` : `, at least ${number(low)}`) : "";
  return `${about ?? ""}${unit ? ` [${unit}]` : ""}${limits}`;
}

/** A number, true or false, a list where it reads as one; else text. @param {string} text */
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
