// The panel of the selected organism, with facts, kin, nervous system, genome, and happiness and energy over time.

import { uPlot } from "./vendor.js";
import { $, h, number } from "./dom.js";
import { drawGenome } from "./genome.js";
import { kindsOf, sign, stroke } from "./marks.js";
import { drawNerves, signature, wired } from "./nerves.js";
import { seeing } from "./sight.js";
import { css } from "./theme.js";
import { Tree } from "./tree.js";

/** @typedef {import("./protocol.js").Organism} Organism */

const KIN = 12; // maximum number shown before "and more"

export class Panel {
  /**
   * @param {import("./protocol.js").Hello} hello
   * @param {{select: (uid: number | null) => void, other: () => import("./protocol.js").Hello | null, fill: () => void, follow: () => void, track: (uid: number) => void, tree: () => void, clade: (life: import("./protocol.js").Relative) => ReturnType<typeof import("./colours.js").cladeOf>, colourOf: (name: string) => string}} calls
   */
  constructor(hello, calls) {
    this.hello = hello;
    this.calls = calls;
    this.root = $("organism");
    /** @type {Organism | null} */
    this.organism = null;
    /** @type {ReturnType<typeof drawNerves> | null} */
    this.nerves = null;
    /** @type {ReturnType<typeof drawNerves> | null} */
    this.enlarged = null;
    /** @type {uPlot | null} */
    this.plot = null;
    this.kept = "";
    this.tree = new Tree({ select: calls.select, ask: calls.tree, clade: calls.clade, colourOf: calls.colourOf });
    this.points = false; // whether the chart shows points
    new ResizeObserver(() => this.plot?.setSize({ width: Math.max(200, this.root.clientWidth - 32), height: 130 })).observe(this.root);
    this.empty();
  }

  empty() {
    this.forget();
    const kind = kindsOf(this.hello).find((species) => species.moves) ?? this.hello.species[0];
    const replay = this.hello.mode === "replay" ? " In a replay, all data are available only for organisms recorded in detail." : "";
    this.root.replaceChildren(h("div", { class: "empty" }, kind ? sign(kind, "currentColor") : null,
      h("p", { text: `Click an organism, or press N for the next one, to see its senses, decisions and genome.${replay}` })));
  }

  forget() {
    this.tree.forget();
    this.root.classList.remove("past");
    this.organism = null;
    this.nerves = null;
    this.plot?.destroy();
    this.plot = null;
    this.kept = "";
  }

  /** Prepares to show an organism. @param {number | null} uid @param {boolean} second whether it belongs to the second world */
  expect(uid, second) {
    if (uid === null) this.empty();
    else if (this.organism?.uid !== uid || (this.organism.second ?? false) !== second) {
      this.forget();
      this.root.replaceChildren(h("div", { class: "empty", text: `Loading #${uid} …` }));
    }
  }

  /** Reports that there is no data. @param {string} why */
  refuse(why) {
    this.forget();
    this.root.replaceChildren(h("div", { class: "empty", text: why }));
  }

  /** @param {Organism} organism */
  show(organism) {
    const kept = [organism.uid, organism.detail, organism.alive, organism.note, organism.world, organism.both, Boolean(organism.nerves && signature(organism.nerves)), organism.genome !== null].join();
    if (kept !== this.kept) this.build(organism);
    this.kept = kept;
    this.organism = organism;
    if (this.saidAt) this.saidAt.textContent = organism.sentence ?? "";
    this.facts(organism);
    this.sees(organism);
    this.kin(organism);
    this.tree.show(organism, this.of(organism));
    if (organism.nerves) {
      this.nerves?.update(organism.nerves);
      if ($("large").open) this.enlarged?.update(organism.nerves);
    }
    this.trace(organism);
  }

  /** @param {Organism} organism */
  build(organism) {
    this.plot?.destroy();
    this.plot = null;
    const kind = this.kind(organism);
    this.nerves = organism.nerves ? drawNerves(organism.nerves, kind.wiring) : null;
    this.saidAt = h("p", { class: "said" });
    this.factsAt = h("dl", { class: "facts" });
    this.diedAt = h("dl", { class: "facts died", hidden: true });
    this.seesAt = h("div", { class: "sees", hidden: true });
    this.kinAt = h("div");
    this.traceAt = h("div", { class: "chart" });
    const head = h("div", { class: "who" }, sign(kind, this.calls.colourOf(organism.species)), h("strong", { text: `${organism.species} #${organism.uid}` }),
      h("span", { class: organism.alive ? "state" : "state dead", text: organism.alive ? "alive" : "dead" }),
      h("span", { class: "grow" }),
      h("button", { class: "button", type: "button", text: "Follow", title: "Follow with the camera (3)", disabled: !organism.alive, onclick: this.calls.follow }),
      h("button", { class: "icon", type: "button", text: "✕", "aria-label": "Deselect", title: "Deselect (Esc)", onclick: () => this.calls.select(null) }));
    const world = organism.world === undefined ? null : h("p", { class: organism.second ? "world second" : "world" }, "world: ", h("b", { text: organism.world }), { true: ", born before the worlds diverged", false: ", born after the worlds diverged" }[String(organism.both)] ?? "");
    this.root.replaceChildren(head, ...(world ? [world] : []), this.saidAt, ...this.note(organism), this.factsAt, this.diedAt, this.seesAt, this.kinAt, this.tree.root);
    const past = organism.as_of === undefined ? "" : ` in its last tick, ${number(organism.as_of)}`;
    this.root.classList.toggle("past", past !== "");
    if (this.nerves) this.root.append(part(`Nervous system${past}`, this.nerves.root, h("button", { class: "plain", type: "button", text: "enlarge", onclick: () => this.enlarge() })));
    if (organism.nerves && kind.wiring) this.root.append(h("dl", { class: "wiring" }, ...wired(organism.nerves, kind.wiring).flatMap(([name, text]) => [h("dt", { text: name }), h("dd", { text })])));
    this.root.append(part("Happiness and energy", this.traceAt));
    if (organism.genome) this.root.append(part("Genome", drawGenome(organism.genome)));
  }

  /** @param {Organism} organism @returns {import("./protocol.js").Kind} */
  kind(organism) {
    return kindsOf(this.of(organism)).find(({ name }) => name === organism.species) ?? { name: organism.species, color: "#888888", radius: 1 };
  }

  /** The organism's world. @param {Organism} organism */
  of(organism) {
    return (organism.second && this.calls.other()) || this.hello;
  }

  /** Explains which data were recorded, if not all were. @param {Organism} organism */
  note(organism) {
    const { mode, file } = this.of(organism);
    if (!organism.note && (organism.detail === "full" || mode === "live")) return [];
    const fill = mode === "replay" && !file && organism.detail !== "full"
      && h("button", { class: "button", type: "button", text: "Fill in", title: "Rerun from the nearest checkpoint", onclick: (/** @type {Event} */ event) => {
        const button = /** @type {HTMLButtonElement} */ (event.currentTarget);
        button.disabled = true;
        setTimeout(() => (button.disabled = false), 4000);
        this.calls.fill();
      } });
    const text = organism.note || (organism.detail === "record" ? "Only birth and death were recorded." : "Recorded in snapshots.");
    return [h("div", { class: "note" }, h("span", { text }), fill)];
  }

  /** @param {Organism} organism */
  facts(organism) {
    const { energy, energy_max: most, place, nerves, died } = organism;
    const share = energy !== null && most ? Math.max(0, Math.min(1, energy / most)) : null;
    const energyAt = h("dd", { text: number(energy) + (most ? ` / ${number(most)}` : "") });
    if (share !== null) energyAt.append(h("span", { class: "meter" }, h("i", { style: `width:${(100 * share).toFixed(1)}%` })));
    const items = [
      fact("age", organism.age === null ? "–" : `${number(organism.age)} s`),
      h("div", {}, h("dt", { text: "energy" }), energyAt),
      fact("happiness", number(nerves?.happiness ?? last(organism.trace?.happiness))),
      fact("sex", organism.sex === null || organism.sex === "" ? "–" : String(organism.sex)),
      fact("generation", number(organism.generation)),
      fact("born", organism.born === null ? "–" : `tick ${number(organism.born)}`),
      wide("position [m]", place ? place.slice(0, this.of(organism).size.length).map((value) => value.toFixed(1)).join(", ") : "–"),
      fact("heading", organism.heading === null ? "–" : `${Math.round((((organism.heading * 180) / Math.PI) % 360 + 360) % 360)}°`),
      ...(organism.size ? [fact("size [m]", organism.size.map((value) => number(value)).join(" × "))] : []),
      fact("reward", number(nerves?.reward)),
    ];
    this.factsAt?.replaceChildren(...items);
    const key = JSON.stringify([died, organism.alive]);
    if (!this.diedAt || this.diedAt.dataset.key === key) return;
    this.diedAt.dataset.key = key;
    this.diedAt.hidden = !died;
    if (died) {
      const killer = typeof died.killer === "number" ? h("button", { class: "uid", type: "button", text: `#${died.killer}`, onclick: () => this.calls.select(Number(died.killer)) }) : died.killer;
      const text = h("dd", { text: `${died.cause}, tick ${number(died.tick)} ` });
      if (killer) text.append(killer);
      this.diedAt.replaceChildren(h("div", { class: "wide" }, h("dt", { text: organism.alive ? "will die" : "died" }), text));
    }
  }

  /** @param {Organism} organism */
  sees(organism) {
    const words = organism.alive ? seeing(this.kind(organism), organism) : "";
    if (!this.seesAt || this.seesAt.dataset.key === words) return;
    this.seesAt.dataset.key = words;
    this.seesAt.hidden = !words;
    this.seesAt.replaceChildren(h("span", { text: "sees" }), words);
  }

  /** @param {Organism} organism */
  kin(organism) {
    const key = `${organism.parents}/${organism.children}/${organism.both}`;
    const apart = organism.second && !organism.both;
    if (!this.kinAt || this.kinAt.dataset.key === key) return;
    this.kinAt.dataset.key = key;
    const track = h("button", { class: "plain", type: "button", text: "track descendants", disabled: apart, title: apart ? "Both worlds use the family colors of the first world" : "Color all its descendants", onclick: () => this.calls.track(organism.uid) });
    this.kinAt.replaceChildren(this.family("parents", organism.parents), this.family("children", organism.children), track);
  }

  /** @param {string} title @param {number[]} uids */
  family(title, uids) {
    const one = (/** @type {number} */ uid) => h("button", { class: "uid", type: "button", text: `#${uid}`, onclick: () => this.calls.select(uid) });
    const row = h("div", { class: "kin" }, h("span", { text: title }), ...uids.slice(0, KIN).map(one));
    if (!uids.length) row.append("none");
    if (uids.length > KIN) {
      const more = h("button", { class: "plain", type: "button", text: `and ${uids.length - KIN} more`, onclick: () => more.replaceWith(...uids.slice(KIN).map(one)) });
      row.append(more);
    }
    return row;
  }

  enlarge() {
    if (!this.organism?.nerves) return;
    this.enlarged = drawNerves(this.organism.nerves, this.kind(this.organism).wiring);
    this.enlarged.root.setAttribute("style", "max-height:78vh");
    const dialog = $("large");
    dialog.replaceChildren(h("h2", { text: `Nervous system of ${this.organism.species} #${this.organism.uid}` }), this.enlarged.root,
      h("form", { method: "dialog" }, h("button", { class: "button", text: "Close" })));
    dialog.showModal();
  }

  /** @param {Organism} organism */
  trace({ trace }) {
    if (!trace?.tick.length || !this.traceAt) return;
    const data = [trace.tick, trace.happiness ?? trace.tick.map(() => null), trace.energy ?? trace.tick.map(() => null)];
    if (!this.plot) this.plot = this.draw(this.traceAt);
    this.points = trace.tick.length < 3; // a line needs at least two points
    this.plot.setData(/** @type {any} */ (data));
  }

  /** @param {HTMLElement} place */
  draw(place) {
    const hues = ["#CC79A7", css("--accent")];
    const dash = [5, 3];
    const points = { show: () => this.points, size: 6 };
    place.replaceChildren(h("div", { class: "chart-head" }, h("span", { class: "key" }, stroke(hues[0], []), "happiness (left)"), h("span", { class: "key" }, stroke(hues[1], dash), "energy (right)")));
    const axis = { stroke: css("--soft"), font: "11px " + css("--font"), ticks: { show: false }, grid: { stroke: css("--line"), width: 1 } };
    const text = (/** @type {uPlot} */ _, /** @type {number[]} */ splits) => splits.map((value) => number(value));
    return new uPlot({
      width: Math.max(200, this.root.clientWidth - 32), height: 130, padding: [6, 12, 0, 12], legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false } },
      scales: { x: { time: false }, h: {}, e: {} },
      axes: [{ ...axis, size: 24, space: 70, values: text }, { ...axis, scale: "h", size: 42, space: 26, values: text }, { ...axis, scale: "e", side: 1, size: 42, space: 26, grid: { show: false }, values: text }],
      series: [{}, { scale: "h", stroke: hues[0], width: 1.8, points }, { scale: "e", stroke: hues[1], width: 1.8, dash, points }],
    }, [[]], place);
  }

  /** Redraws after a change of theme. */
  redraw() {
    const { organism } = this;
    this.kept = "";
    if (organism) this.show(organism);
    this.tree.draw(true);
  }
}

/** @param {string} name @param {string} text */
const fact = (name, text) => h("div", {}, h("dt", { text: name }), h("dd", { text, title: text }));

/** A fact whose text may wrap onto a second line. @param {string} name @param {string} text */
const wide = (name, text) => h("div", {}, h("dt", { text: name }), h("dd", { text, class: "wraps" }));

/** @param {(number | null)[] | undefined} list */
const last = (list) => (list?.length ? list[list.length - 1] : null);

/** @param {string} title @param {Element} content @param {Element} [extra] */
function part(title, content, extra) {
  return h("section", { class: "part" }, h("div", { class: "part-head" }, h("h2", { text: title }), extra ?? null), content);
}
