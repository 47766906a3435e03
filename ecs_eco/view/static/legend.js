// The legend: each kind with its number, a sparkline on its own scale, where it goes, and births and deaths a tick.

import { $, h, number, s } from "./dom.js";
import { sign } from "./marks.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{line: number[], births: number | null, deaths: number | null, extinct: number | null}} Brief what the charts know of a kind now */

const WIDE = 54, HIGH = 16; // of a sparkline [px]
const STEADY = 0.05; // change over the sparkline below which a number is steady

/**
 * @param {Stage} stage
 * @param {{own: boolean, onown: (own: boolean) => void, onshow: (name: string, shown: boolean) => void, find: (name: string) => void, brief: (name: string) => Brief}} calls
 * @returns {{count: () => void, look: () => void}} after each drawing, and after new points
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
  const note = h("label", { class: "legend-note", title: "Else a palette that colour-blind people tell apart" }, box, "colours of the world file");
  $("legend").replaceChildren(...rows.map(({ root }) => root), ...marks(stage), note);
  const count = () => rows.forEach((one, k) => write(one.count, number(stage.layers[k].block.n)));
  const look = () => rows.forEach((one, k) => !stage.kinds[k].inanimate && tell(one, calls.brief(stage.kinds[k].name), stage.layers[k].block.n));
  count();
  look();
  return { count, look };
}

/** What the marks in the scene mean; a click hides them. @param {Stage} stage */
function marks(stage) {
  if (!stage.kinds.some(({ moves }) => moves)) return [];
  const cross = (/** @type {string} */ colour, /** @type {number} */ r) => s("path", { d: `M${8 - r} ${8 - r}L${8 + r} ${8 + r}M${8 - r} ${8 + r}L${8 + r} ${8 - r}`, stroke: colour, "stroke-width": r / 2 - 0.2, fill: "none" });
  const one = (/** @type {string} */ text, /** @type {SVGElement} */ shape) => h("span", {}, s("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, shape), text);
  const button = h("button", { class: "legend-marks", type: "button", "aria-pressed": String(stage.over.shown), title: "Marks of animals that were born or died in the last five ticks: show or hide", onclick: () => {
    stage.over.shown = !stage.over.shown;
    button.setAttribute("aria-pressed", String(stage.over.shown));
    stage.dirty = true;
  } }, one("born", s("circle", { cx: 8, cy: 8, r: 5.5, fill: "none", stroke: "currentColor", "stroke-width": 2 })), one("died", cross("currentColor", 4.5)), one("eaten", cross("var(--minus)", 6)));
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
  const count = h("b", { text: "0" });
  const line = s("polyline", { fill: "none", stroke: stage.colours[k], "stroke-width": 1.6, "stroke-linejoin": "round" });
  const spark = s("svg", { class: "spark", viewBox: `0 0 ${WIDE} ${HIGH}`, width: WIDE, height: HIGH, role: "img" }, line);
  const way = h("span", { class: "way" });
  const flow = h("small", { class: "flow" });
  const toggle = h("button", { class: "legend-row", type: "button", "aria-pressed": String(stage.layers[k].shown), title: `Show or hide ${kind.name}`, onclick: hide },
    sign(kind, stage.colours[k]), h("span", { class: "named" }, kind.name, flow), spark, way, count);
  const small = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ does) => h("button", { class: "mini", type: "button", text, title: label, "aria-label": label, onclick: does });
  const root = h("div", { class: "legend-line" }, toggle, small("◉", `Only ${kind.name}, or all again`, solo), kind.inanimate ? null : small("⊕", `Find one: ${kind.name}`, find));
  return { root, toggle, count, line, spark, way, flow, drawn: "" };
}

/**
 * @param {ReturnType<typeof row>} one
 * @param {Brief} brief
 * @param {number} n how many there are
 */
function tell(one, { line, births, deaths, extinct }, n) {
  const key = line.join();
  if (key !== one.drawn && line.length > 1) {
    one.drawn = key;
    const low = Math.min(...line), span = Math.max(...line) - low || 1;
    one.line.setAttribute("points", line.map((value, i) => `${((i * WIDE) / (line.length - 1)).toFixed(1)},${(HIGH - 2 - ((HIGH - 4) * (value - low)) / span).toFixed(1)}`).join(" "));
    one.spark.setAttribute("aria-label", `from ${number(line[0])} to ${number(line[line.length - 1])}`);
  }
  const change = line.length > 1 && line[0] ? line[line.length - 1] / line[0] - 1 : 0;
  write(one.way, line.length < 2 ? "" : Math.abs(change) < STEADY ? "→" : change > 0 ? "↗" : "↘");
  one.way.title = line.length < 2 ? "" : `${change < 0 ? "−" : "+"}${Math.round(Math.abs(100 * change))} % since the line begins`;
  const gone = n === 0 && extinct !== null;
  one.root.classList.toggle("gone", gone);
  write(one.flow, gone ? `extinct at ${number(extinct)}` : births === null ? "" : `+${rate(births)} −${rate(deaths)} a tick`);
}

/** @param {number | null} value */
const rate = (value) => number(value === null ? null : Number(value.toPrecision(2)), 2);

/** @param {HTMLElement} element @param {string} text */
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
