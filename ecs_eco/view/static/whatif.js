// "What if …?": chooses the tick at which the world branches, and a change.

import { $, announce, h, number } from "./dom.js";
import { save } from "./save.js";

/** @typedef {import("./protocol.js").Parameter} Parameter */
/** @typedef {{label: string, fields: () => (Node | null)[], what: () => Record<string, unknown> | null}} Change a kind of change: its form and the resulting intervention */

export class WhatIf {
  /**
   * @param {import("./connection.js").Connection} connection
   * @param {() => {hello: import("./protocol.js").Hello, tick: number, counts: Record<string, number>} | null} now
   */
  constructor(connection, now) {
    this.connection = connection;
    this.now = now;
    /** @type {Parameter[]} */
    this.parameters = [];
    this.kind = "set";
    this.outcome = h("section", { class: "pairs", "aria-label": "Pairs with other seeds" });
    /** @type {HTMLDialogElement} */
    this.dialog = $("ask");
    connection.on("params", ({ list, forks }) => this.offer(list, forks));
    connection.on("beside", ({ hello }) => hello && this.dialog.open && this.dialog.close());
    connection.on("said", ({ level, field, text, at }) => {
      if ((field !== "whatif" && field !== "pairs") || level !== "error" || !this.problem) return;
      this.problem.textContent = at ? `${at}: ${text}` : text;
      this.problem.hidden = false;
      if (this.go) this.go.disabled = false;
    });
    connection.on("pairs", (pairs) => this.told(pairs));
    connection.on("hello", (hello) => ($("whatif").hidden = !hello.forks));
    $("whatif").addEventListener("click", () => this.open());
  }

  open() {
    const now = this.now();
    if (!now?.hello.forks || this.dialog.open) return;
    this.connection.send({ kind: "pause" });
    this.connection.send({ kind: "params" });
    this.build(now);
    this.dialog.showModal();
  }

  /** @param {NonNullable<ReturnType<typeof this.now>>} now */
  build({ hello, tick, counts }) {
    this.names = hello.species.map(({ name }) => name);
    this.tick = h("input", { class: "input", type: "number", value: tick, step: 1, max: tick, "aria-label": "From tick", disabled: hello.mode === "replay" });
    this.tick.addEventListener("input", () => (this.chosen = true));
    this.chosen = false;
    this.kept = h("span", { class: "about", text: hello.mode === "replay" ? "the displayed tick" : "now" });
    this.changes = this.all(hello, counts);
    if (!(this.kind in this.changes)) this.kind = "set";
    const choice = Object.entries(this.changes).map(([key, { label }]) => h("label", { class: "pick" }, h("input", { type: "radio", name: "change", value: key, checked: key === this.kind, onchange: () => this.choose(key) }), h("span", { text: label })));
    this.fields = h("div", { class: "form" });
    this.problem = h("p", { class: "problem", role: "alert", hidden: true });
    this.go = h("button", { class: "button primary", type: "submit", text: "Branch" });
    this.seeds = h("input", { class: "input", type: "number", min: 2, max: 1000, value: 20, "aria-label": "Number of pairs" });
    this.end = h("input", { class: "input", type: "number", min: 1, step: 1, value: tick + 2000, "aria-label": "Last tick of the pairs" });
    const many = h("button", { class: "button", type: "button", text: "Run pairs", title: "Run both worlds with seeds 1, 2, … in the background, on all cores", onclick: () => this.replicate() });
    const form = h("form", { class: "ask" },
      h("div", { class: "row" }, h("label", { class: "from" }, "From tick ", this.tick), this.kept),
      h("div", { class: "ideas", role: "group", "aria-label": "Ideas" }, "quick choices:", ...this.ideas(hello, counts)),
      h("fieldset", {}, h("legend", { text: "the change" }), h("div", { class: "picks" }, ...choice), this.fields),
      h("div", { class: "row" }, h("label", { class: "from" }, "Is it chance? ", this.seeds, " pairs"), h("label", { class: "from" }, "to tick ", this.end), many), this.problem,
      h("div", { class: "row end" }, h("button", { class: "button", type: "button", text: "Cancel", onclick: () => this.dialog.close() }), this.go));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.send(this.changes?.[this.kind].what() ?? null);
    });
    this.dialog.replaceChildren(h("h2", { id: "askTitle", text: "What if …?" }),
      h("p", { class: "about", text: "This runs two worlds side by side: the original and a copy with one change. The original is not affected." }), form, this.outcome);
    this.choose(this.kind);
  }

  /** Buttons that send common changes. @param {import("./protocol.js").Hello} hello @param {Record<string, number>} counts */
  ideas(hello, counts) {
    const animals = hello.species.filter(({ name, moves }) => moves && counts[name]).map(({ name }) => name);
    const idea = (/** @type {string} */ text, /** @type {Record<string, unknown>} */ what) => h("button", { class: "toggle", type: "button", text, onclick: () => this.send(what) });
    return [
      ...animals.slice(0, 3).map((name) => idea(`without ${name}`, { kind: "cull", species: name, share: 1 })),
      ...animals.slice(0, 1).map((name) => idea(`twice as many ${name}`, { kind: "add", species: name, count: counts[name] })),
      idea("no more births", { kind: "switch", reproduction: false }),
    ];
  }

  /** @param {import("./protocol.js").Hello} hello @param {Record<string, number>} counts @returns {Record<string, Change>} */
  all(hello, counts) {
    const kinds = [...hello.species, ...(hello.objects ?? [])].map(({ name }) => name);
    const row = (/** @type {string} */ text, /** @type {HTMLElement[]} */ ...field) => [h("label", { text }), ...field];
    const key = h("input", { class: "input", list: "whatifKeys", placeholder: "Type to search", "aria-label": "Value", autocomplete: "off", spellcheck: "false", required: true });
    const value = h("input", { class: "input", "aria-label": "New value", autocomplete: "off", required: true });
    const about = h("p", { class: "about" });
    const times = (/** @type {string} */ text, /** @type {number} */ factor) => h("button", { class: "toggle", type: "button", text, onclick: () => (value.value = String(Number((Number(value.value) * factor).toPrecision(6)))) });
    const factors = h("div", { class: "row" }, times("× ½", 0.5), times("× 2", 2), times("× 10", 10));
    this.keys = h("datalist", { id: "whatifKeys" });
    const told = () => {
      const found = this.parameters.find((parameter) => parameter.key === key.value);
      key.setCustomValidity(found ? "" : "choose a key from the list");
      about.textContent = found ? `${found.about ?? ""}${found.unit ? ` [${found.unit}]` : ""}, now ${found.value}` : "";
      if (found) value.value = typeof found.value === "string" ? found.value : JSON.stringify(found.value);
      factors.hidden = typeof found?.value !== "number";
    };
    key.addEventListener("input", told);
    told();
    const [fewer, more, whom] = [choice(kinds, "Kind to reduce"), choice(kinds, "Kind to increase"), choice(["all species", ...this.names ?? []], "Species")];
    const share = h("input", { class: "input", type: "number", min: 1, max: 100, value: 50, "aria-label": "Share to cull, in percent", required: true });
    const first = choice(["random", "oldest", "youngest", "richest", "poorest", "largest", "smallest"], "Order");
    const count = h("input", { class: "input", type: "number", min: 1, max: 1000000, value: 20, "aria-label": "How many to add", required: true });
    more.addEventListener("change", () => (count.value = String(Math.max(1, counts[more.value] ?? 20))));
    const [w, d] = hello.size;
    /** @type {Record<string, Record<string, unknown>>} */
    const lines = { "across the middle, west to east": { line: [[0, d / 2], [w, d / 2]] }, "across the middle, south to north": { line: [[w / 2, 0], [w / 2, d]] }, "around the middle": { region: [w / 4, d / 4, (3 * w) / 4, (3 * d) / 4] } };
    const fence = choice(Object.keys(lines), "Position of the fence");
    const what = choice(["reproduction", "learning"], "Property to switch"), on = choice(["off", "on"], "Off or on");
    return {
      set: { label: "a value", fields: () => [...row("value of", key), this.keys ?? null, ...row("is", value), h("span"), factors, about], what: () => ({ kind: "set", set: { [key.value]: parsed(value.value) } }) },
      cull: { label: "fewer", fields: () => [...row("kind", fewer), ...row("percent", share), ...row("order", first)], what: () => ({ kind: "cull", species: fewer.value, share: Number(share.value) / 100, which: first.value }) },
      add: { label: "more", fields: () => [...row("kind", more), ...row("how many", count)], what: () => ({ kind: "add", species: more.value, count: Number(count.value) }) },
      ...(hello.size.length < 3 ? { fence: { label: "a fence", fields: () => row("where", fence), what: () => ({ kind: "fence", ...lines[fence.value] }) } } : {}),
      switch: { label: "a switch", fields: () => [...row("species", whom), ...row("what", what), ...row("is", on)], what: () => ({ kind: "switch", [what.value]: on.value === "on", ...(whom.value === "all species" ? {} : { species: whom.value }) }) },
      none: { label: "nothing", fields: () => [h("p", { class: "about", text: "A control: both worlds stay identical, down to the last animal." })], what: () => null },
    };
  }

  /** @param {string} kind of change */
  choose(kind) {
    this.kind = kind;
    this.fields?.replaceChildren(...(this.changes?.[kind].fields() ?? []).filter((field) => field !== null));
    if (this.problem) this.problem.hidden = true;
  }

  /** @param {Parameter[]} list @param {number[]} [forks] first and last tick at which a branch can start */
  offer(list, forks) {
    this.parameters = list;
    this.keys?.replaceChildren(...list.map(({ key, about }) => h("option", { value: key, text: about ?? "" })));
    if (!forks || !this.tick || !this.kept || this.now()?.hello.mode === "replay") return;
    const [first, last] = forks;
    for (const [name, value] of [["min", first], ["max", last]]) this.tick.setAttribute(String(name), String(value));
    this.kept.textContent = first < last ? `available: ${number(first)} to ${number(last)}, the current tick` : "only the current tick is available";
    this.tick.disabled = first === last;
    if (!this.chosen) this.tick.value = String(last); // time may have passed before the world paused
  }

  /** Runs pairs of worlds with other seeds, with and without the chosen change. */
  replicate() {
    const [seeds, end, tick] = [this.seeds, this.end, this.tick];
    if (!seeds?.reportValidity() || !end?.reportValidity() || !tick?.reportValidity()) return;
    if (this.problem) this.problem.hidden = true;
    this.connection.send({ kind: "pairs", tick: tick.disabled ? null : Number(tick.value), what: this.changes?.[this.kind].what() ?? null, seeds: Number(seeds.value), ticks: Number(end.value) });
  }

  /** Shows the progress of the pairs, or their outcome. @param {import("./protocol.js").Pairs} pairs */
  told({ done = 0, of = 1, command = "", stopped, problem, lines, figure, html }) {
    if (stopped) return this.outcome.replaceChildren();
    const again = h("pre", { class: "recipe", tabindex: 0, text: command });
    if (problem) return this.outcome.replaceChildren(h("p", { class: "problem", role: "alert", text: problem }), again);
    if (!lines || !html) {
      const stop = h("button", { class: "button", type: "button", text: "Stop", onclick: () => this.connection.send({ kind: "pairs", stop: true }) });
      return this.outcome.replaceChildren(h("div", { class: "row" }, h("progress", { value: done, max: of, "aria-label": "Finished runs" }), h("span", { text: `${done} of ${of} runs` }), stop), again);
    }
    const picture = h("img", { alt: "Numbers over time: means and intervals with and without the change", src: URL.createObjectURL(new Blob([figure ?? ""], { type: "image/svg+xml" })) });
    const report = h("button", { class: "button", type: "button", text: "Save the report", onclick: () => save("pairs.html", new Blob([html], { type: "text/html" })) });
    this.outcome.replaceChildren(h("h3", { text: `${of / 2} pairs` }), h("ul", {}, ...lines.map((text) => h("li", { text }))), picture, h("div", { class: "row" }, report), again);
    announce("The pairs are finished.");
  }

  /** @param {Record<string, unknown> | null} what */
  send(what) {
    if (!this.tick?.reportValidity()) return;
    if (this.go) this.go.disabled = true;
    this.connection.send({ kind: "whatif", tick: this.tick.disabled ? null : Number(this.tick.value), what });
  }
}

/** @param {string[]} names @param {string} label */
const choice = (names, label) => h("select", { class: "input", "aria-label": label }, ...names.map((name) => h("option", { text: name, value: name })));

/** Parses a number, true, false or a list; returns any other text unchanged. @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}
