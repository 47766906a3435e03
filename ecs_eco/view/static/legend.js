// The legend: each kind with its population, a sparkline on its own scale, its trend, and births and deaths per tick.

import { RECENT } from "./charts.js";
import { LASTS } from "./over.js";
import { $, h, number, s } from "./dom.js";
import { sign } from "./marks.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{line: number[], change: number, births: number | null, deaths: number | null, extinct: number | null, causes: [string, number][], learns: boolean}} Brief current data of a kind from the charts; `change`: relative change in the last RECENT ticks; causes of death with deaths per tick, most frequent first */

const narrow = matchMedia("(max-width: 860px), (max-height: 520px)"); // as in style.css
const WIDE = 54, HIGH = 16; // size of a sparkline [px]
const NAMED = 0.15; // minimum share of deaths for a cause to be named
const STEADY = 0.03; // maximum relative change that counts as steady

/**
 * @param {Stage} stage
 * @param {{own: boolean, onown: (own: boolean) => void, onshow: (name: string, shown: boolean) => void, find: (name: string) => void, brief: (name: string) => Brief, other: () => Stage | null, all: (name: string) => number | undefined}} calls `all`: the size of a population of which the stage shows only a part
 * @returns {{count: () => void, look: () => void}} `count` is called after each drawing, `look` after new points
 */
export function legend(stage, calls) {
  const show = (/** @type {number} */ k, /** @type {boolean} */ on) => {
    stage.layers[k].show(on);
    stage.meadow.draw(true);
    stage.dirty = true;
    rows[k].toggle.setAttribute("aria-pressed", String(on));
    calls.onshow(stage.kinds[k].name, on);
  };
  const solo = (/** @type {number} */ k) => {
    const alone = stage.layers.every((layer, other) => layer.shown === (other === k));
    stage.layers.forEach((layer, other) => layer.shown !== (alone || other === k) && show(other, alone || other === k));
  };
  const rows = stage.kinds.map((kind, k) => row(stage, k, () => show(k, !stage.layers[k].shown), () => solo(k), () => calls.find(kind.name)));
  const box = h("input", { type: "checkbox", checked: calls.own, onchange: () => calls.onown(box.checked) });
  const note = h("label", { class: "legend-note", title: "Use the colors from the world file instead of a color-blind-safe palette" }, box, "colors from the world file");
  const periods = h("div", { class: "legend-periods", text: `rates: last ${RECENT} ticks${stage.kinds.some(({ moves }) => moves) ? `; marks: last ${LASTS}` : ""}` });
  const more = h("button", { class: "plain legend-more", type: "button", onclick: () => {
    open(!$("legend").classList.contains("full"));
    if (!stage.eye.touched) stage.eye.look(stage.eye.preset); // uses the free space
  } });
  const open = (/** @type {boolean} */ full) => {
    for (const [name, on] of /** @type {[string, boolean][]} */ ([["full", full], ["folded", !full]])) $("legend").classList.toggle(name, on);
    more.setAttribute("aria-expanded", String(full));
    more.textContent = full ? "less" : "births, deaths, causes";
  };
  open($("legend").classList.contains("full") || (!narrow.matches && !$("legend").classList.contains("folded"))); // at first, unfolded on wide pages
  narrow.onchange = () => open(!narrow.matches);
  $("legend").replaceChildren(...rows.map(({ root }) => root), ...marks(stage), note, periods, more);
  const size = (/** @type {number} */ k) => ((stage.kinds[k].every ?? 1) > 1 && calls.all(stage.kinds[k].name)) || stage.layers[k].block.n;
  const count = () => rows.forEach((one, k) => {
    const beside = calls.other()?.layers.find(({ kind }) => kind.name === stage.kinds[k].name);
    write(one.count, number(size(k)));
    write(one.other, beside ? number(beside.block.n) : "");
    one.other.classList.toggle("differs", Boolean(beside) && beside?.block.n !== stage.layers[k].block.n);
  });
  const look = () => rows.forEach((one, k) => !stage.kinds[k].inanimate && tell(one, calls.brief(stage.kinds[k].name), size(k), stage.kinds[k].every));
  count();
  look();
  return { count, look };
}

/** Explains the marks in the scene; a click hides or shows them. @param {Stage} stage */
function marks(stage) {
  if (!stage.kinds.some(({ moves }) => moves)) return [];
  const cross = (/** @type {string} */ colour, /** @type {number} */ r) => s("path", { d: `M${8 - r} ${8 - r}L${8 + r} ${8 + r}M${8 - r} ${8 + r}L${8 + r} ${8 - r}`, stroke: colour, "stroke-width": r / 2 - 0.2, fill: "none" });
  const one = (/** @type {string} */ text, /** @type {SVGElement} */ shape) => h("span", {}, s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, shape), text);
  const inView = h("span", { text: "none now" });
  stage.over.told = (drawn, all) => write(inView, !all ? "none now" : stage.over.shown ? `${drawn} of ${all} in view` : `${all} hidden`);
  const button = h("button", { class: "legend-marks", type: "button", "aria-pressed": String(stage.over.shown), title: "Show or hide marks of animals that were born or died in the last five ticks", onclick: () => {
    stage.over.shown = !stage.over.shown;
    button.setAttribute("aria-pressed", String(stage.over.shown));
    stage.dirty = true;
  } }, one("born", s("circle", { cx: 8, cy: 8, r: 5.5, fill: "none", stroke: "currentColor", "stroke-width": 2 })), one("died", cross("currentColor", 4.5)), one("killed", cross("var(--minus)", 6)), inView);
  return [button];
}

/**
 * @param {Stage} stage
 * @param {number} k
 * @param {() => void} hide
 * @param {() => void} solo
 * @param {() => void} find
 */
function row(stage, k, hide, solo, find) {
  const kind = stage.kinds[k];
  const count = h("b", { text: "0" }), other = h("b", { class: "other" });
  const line = s("polyline", { fill: "none", stroke: stage.colours[k], "stroke-width": 1.6, "stroke-linejoin": "round" });
  const spark = s("svg", { class: "spark", viewBox: `0 0 ${WIDE} ${HIGH}`, width: WIDE, height: HIGH, role: "img", "aria-label": "no curve yet" }, line);
  const way = h("span", { class: "way" });
  const flow = h("small", { class: "flow" }), genes = h("small", { class: "flow shows", text: shown(kind) });
  const toggle = h("button", { class: "legend-row", type: "button", "aria-pressed": String(stage.layers[k].shown), title: `Show or hide ${kind.name}`, onclick: hide },
    sign(kind, stage.colours[k]), h("span", { class: "named", text: kind.name }), spark, way, count, other, flow, genes);
  const small = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ does) => h("button", { class: "mini", type: "button", text, title: label, "aria-label": label, onclick: does });
  const root = h("div", { class: "legend-line" }, toggle, small("◉", `Show only ${kind.name}, or all kinds again`, solo), kind.inanimate ? null : small("⊕", `Select one ${kind.name}`, find));
  return { root, toggle, count, other, line, spark, way, flow, drawn: "" };
}

/** The genes that show in bodies. @param {import("./protocol.js").Kind} kind */
function shown({ shows, build, shape }) {
  const [size, stripes] = [shape ? undefined : shows?.size, build ? shows?.stripes : undefined];
  return [size ? `size: gene ${size[0]}` : "", stripes ? `stripes: gene ${stripes[0]} (none at ${number(stripes[1])}, widest at ${number(stripes[2])})` : ""].filter(Boolean).join(", ");
}

/**
 * @param {ReturnType<typeof row>} one
 * @param {Brief} brief
 * @param {number} n current population
 * @param {number} [every] of how many organisms one is shown
 */
function tell(one, { line, change, births, deaths, extinct, causes, learns }, n, every = 1) {
  const key = line.join();
  if (key !== one.drawn && line.length > 1) {
    one.drawn = key;
    const low = Math.min(...line), span = Math.max(...line) - low || 1;
    one.line.setAttribute("points", line.map((value, i) => `${((i * WIDE) / (line.length - 1)).toFixed(1)},${(HIGH - 2 - ((HIGH - 4) * (value - low)) / span).toFixed(1)}`).join(" "));
    one.spark.setAttribute("aria-label", `from ${number(line[0])} to ${number(line[line.length - 1])}`);
  }
  write(one.way, !n || line.length < 2 ? "" : Math.abs(change) < STEADY ? "→" : change > 0 ? "↗" : "↘");
  one.way.title = line.length < 2 ? "" : `${change < 0 ? "−" : "+"}${Math.round(Math.abs(100 * change))}% in the last ${RECENT} ticks`;
  const gone = n === 0 && extinct !== null;
  one.root.classList.toggle("gone", gone);
  write(one.flow, gone ? `extinct at tick ${number(extinct)}` : n === 0 && !line.some(Boolean) ? "none so far" : [...(births === null ? [] : [...(learns ? ["learns"] : []), `+${rate(births)} −${rate(deaths)} per tick`, ...(deaths ? whereof(causes) : [])]), ...(every > 1 ? [`1 in ${every} shown`] : [])].join(", "));
}

/** The most frequent recent causes of death. @param {[string, number][]} causes with deaths per tick, most frequent first */
export function whereof(causes) {
  const all = causes.reduce((sum, [, rate]) => sum + rate, 0);
  return causes.filter(([, rate]) => rate >= NAMED * all).slice(0, 3).map(([cause, rate]) => `${rate > 0.995 * all ? "all" : `${Math.round((100 * rate) / all)}%`} ${cause}`);
}

/** @param {number | null} value */
const rate = (value) => number(value === null ? null : Number(value.toPrecision(2)), 2);

/** @param {HTMLElement} element @param {string} text */
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
