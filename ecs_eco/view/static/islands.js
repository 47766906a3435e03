// The map of an archipelago. An island is a disc with sectors for its species; the width of an arrow shows the number of migrants. A click opens an island.

import { safe } from "./colours.js";
import { Connection } from "./connection.js";
import { $, announce, h, number, s } from "./dom.js";
import { PAUSE, PLAY } from "./icons.js";
import { door, notice } from "./overlay.js";
import { splitter } from "./splitter.js";
import { isDark, onTheme, recallTheme, switchTheme } from "./theme.js";
import { taken } from "./credential.js";

/** @typedef {import("./protocol.js").Islands} Islands */

const SIZE = 700; // size of the map in its own units
const LEGIBLE = 0.9; // relative font size below which text no longer shrinks with the map
const RADII = [20, 66]; // radius of an empty island and of the most populous one
const BEND = 0.13; // curvature of routes, as a share of their length
const WIDTHS = [1.2, 9]; // widths of the routes with the fewest and the most migrants
const PACE = 60; // [ms] between points during playback
const SPARK = [46, 18];

const connection = new Connection();
/** @type {Islands | null} */
let shown = null;
let at = 0; // the point shown
let newest = true; // whether the map follows the run
let playing = 0; // id of a timer
let opening = "";
let maps = 0;
let letters = 1; // font size, relative to a map with enough space
/** @type {string[]} */
let colours = [];

connection.on("islands", (islands) => {
  maps++;
  connection.greeted = true;
  const first = !shown;
  shown = islands;
  if (newest) at = Math.max(0, islands.points.length - 1);
  if (first) begin(islands);
  $("time").max = String(Math.max(0, islands.points.length - 1));
  paint();
});
connection.on("opened", ({ address }) => {
  opening = "";
  const to = new URL(address);
  if (to.hostname !== location.hostname && to.hostname !== "127.0.0.1") return;
  to.hash += `&map=${location.port}`;
  location.assign(to);
});
connection.on("said", ({ text }) => {
  opening = "";
  notice(text);
  announce(text);
  draw();
});
connection.onlink = (link) => {
  const words = { connecting: "connecting", open: "connected", lost: "reconnecting", ended: "ended", refused: "no access" };
  $("link").dataset.link = link;
  $("link").textContent = words[link];
  if (link === "ended") notice("The server of this map has stopped.", { text: "Try again", does: () => connection.again() });
  else if (link === "refused") door(connection.greeted ? "The map has restarted; open its new address." : "No access: each address works only once and expires after 10 minutes.");
  else if (link === "lost") notice("Connection lost; trying again …");
  else notice(null);
};

/** @param {Islands} islands */
function begin(islands) {
  document.title = `${islands.title} · ecs-eco`;
  $("title").textContent = islands.title;
  const wanderers = islands.species.filter(({ wanders }) => wanders);
  $("who").replaceChildren(h("option", { value: "", text: "all species" }), ...wanderers.map(({ name }) => h("option", { value: name, text: name })));
}

function paint() {
  if (!shown) return;
  colours = safe(shown.species, isDark(), shown.palette);
  draw();
}

/** The population of a species on an island at the displayed point. @param {number} i @param {number} k */
const count = (i, k) => shown?.n[i]?.[k][at] ?? 0;

/** Migrants of the chosen species up to the displayed point, as [from][to]. @returns {number[][]} */
function moved() {
  const { islands, species, moves } = /** @type {Islands} */ (shown);
  const out = islands.map(() => islands.map(() => 0));
  const who = species.findIndex(({ name }) => name === $("who").value);
  const since = $("span").value === "last" ? moves.reduce((last, [point]) => (point <= at ? Math.max(last, point) : last), 0) : 0;
  for (const [point, kind, from, to, n] of moves) if (point <= at && point >= since && (who < 0 || kind === who)) out[from][to] += n;
  return out;
}

new ResizeObserver(draw).observe($("map"));

function draw() {
  if (!shown) return;
  const { islands, species, points, every } = shown;
  const wander = species.map((_, k) => k).filter((k) => species[k].wanders);
  const pie = wander.length ? species.map((_, k) => k).filter((k) => species[k].moves || species[k].wanders) : species.map((_, k) => k);
  const totals = islands.map((_, i) => pie.reduce((sum, k) => sum + count(i, k), 0));
  const most = Math.max(1, ...islands.flatMap((_, i) => points.map((_, p) => pie.reduce((sum, k) => sum + (shown?.n[i]?.[k][p] ?? 0), 0))));
  const between = moved();
  const places = islands.map(({ at: [x, y] }) => [x * SIZE, (1 - y) * SIZE]);
  const radii = totals.map((total) => RADII[0] + (RADII[1] - RADII[0]) * Math.sqrt(total / most));
  const { clientWidth: wide, clientHeight: high } = $("map");
  letters = Math.max(1, LEGIBLE / (Math.min(wide / (SIZE + 60), high / (SIZE + 70)) || 1));
  $("map").replaceChildren(s("svg", { viewBox: `-30 -10 ${SIZE + 60} ${SIZE + 70}`, style: `--letters:${letters.toFixed(3)}`, role: "group", "aria-label": "Islands and the migrants between them" },
    ...ways(places, radii, between), ...islands.map((_, i) => disc(i, places[i], radii[i], pie))));
  $("tick").textContent = points.length ? number(points[at]) : "–";
  $("time").value = String(at);
  $("time").setAttribute("aria-valuetext", points.length ? `tick ${points[at]}` : "no tick yet");
  $("state").textContent = shown.finished ? `of ${number(shown.ticks)}, done` : `of ${number(shown.ticks)}, running`;
  $("legend").replaceChildren(h("ul", { class: "kinds" }, ...species.map(({ name, wanders }, k) => h("li", {},
    h("i", { style: `background:${colours[k]}` }), name, h("small", { text: wanders ? "migrates" : "" }), h("b", { text: number(islands.reduce((sum, _, i) => sum + count(i, k), 0)) })))));
  $("table").replaceChildren(...table(between), h("p", { class: "about", text: `Islands exchange migrants at barriers, every ${every === 1 ? "tick" : `${number(every)} ticks`}. Click an island to open it.` }));
}

/** @param {number[][]} places @param {number[]} radii @param {number[][]} between */
function ways(places, radii, between) {
  const most = Math.max(1, ...between.flat());
  return /** @type {Islands} */ (shown).ways.flatMap(([i, j]) => {
    const [a, b] = [places[i], places[j]];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length], aside = [-along[1], along[0]];
    const point = (/** @type {number} */ d, /** @type {number} */ bend) => [a[0] + along[0] * d + aside[0] * bend, a[1] + along[1] * d + aside[1] * bend];
    const n = between[i][j];
    const [from, to] = [point(radii[i] + 8, 9), point(length - radii[j] - 16, 9)];
    const middle = point(length / 2, 2 * BEND * length);
    const wide = n ? WIDTHS[0] + (WIDTHS[1] - WIDTHS[0]) * (n / most) : 1;
    const turn = Math.atan2(to[1] - middle[1], to[0] - middle[0]);
    const size = 8 + wide;
    const head = [[size, 0], [-size * 0.5, size * 0.62], [-size * 0.5, -size * 0.62]].map(([x, y]) => [to[0] + x * Math.cos(turn) - y * Math.sin(turn), to[1] + x * Math.sin(turn) + y * Math.cos(turn)].join());
    const label = point(length / 2, BEND * length + 4);
    return [
      s("path", { class: n ? "way" : "way idle", d: `M${from}Q${middle} ${to}`, "stroke-width": wide.toFixed(1), "data-way": `${i}-${j}` }),
      s("polygon", { class: "way-head", points: head.join(" ") }),
      ...(n ? [s("text", { class: "way-count", x: label[0], y: label[1] }, number(n))] : []),
    ];
  });
}

/** @param {number} i @param {number[]} place @param {number} radius @param {number[]} pie indices of the species shown as sectors */
function disc(i, [x, y], radius, pie) {
  const { islands, species } = /** @type {Islands} */ (shown);
  const { name } = islands[i];
  const total = pie.reduce((sum, k) => sum + count(i, k), 0);
  const words = species.map(({ name: kind }, k) => `${number(count(i, k))} ${kind}`);
  const root = s("g", { class: opening === name ? "island busy" : "island", role: "button", tabindex: 0, "aria-label": `Open ${name}: ${words.join(", ")}`, "data-island": name },
    s("circle", { class: "shore", cx: x, cy: y, r: radius + 5 }));
  let turned = -Math.PI / 2;
  for (const k of pie) {
    const part = total ? count(i, k) / total : 0;
    if (part === 1) root.append(s("circle", { cx: x, cy: y, r: radius, fill: colours[k] }));
    if (part === 0 || part === 1) continue;
    const end = turned + 2 * Math.PI * part;
    const corner = (/** @type {number} */ angle) => `${(x + radius * Math.cos(angle)).toFixed(1)},${(y + radius * Math.sin(angle)).toFixed(1)}`;
    root.append(s("path", { d: `M${x},${y}L${corner(turned)}A${radius},${radius} 0 ${part > 0.5 ? 1 : 0} 1 ${corner(end)}Z`, fill: colours[k] }));
    turned = end;
  }
  const lines = letters > 1 ? words : [words.join(" · ")];
  root.append(s("text", { class: "name", x, y: y + radius + 6 + 18 * letters }, name),
    ...lines.map((line, row) => s("text", { x, y: y + radius + 6 + 18 * letters * (row + 2) }, line)), s("title", {}, `Open ${name}`));
  root.addEventListener("click", () => open(name));
  root.addEventListener("keydown", (event) => {
    if (/** @type {KeyboardEvent} */ (event).key !== "Enter" && /** @type {KeyboardEvent} */ (event).key !== " ") return;
    event.preventDefault();
    event.stopPropagation();
    open(name);
  });
  return root;
}

/** Tables of the islands' populations over time and of the migrants between islands. @param {number[][]} between */
function table(between) {
  const { islands, species, n } = /** @type {Islands} */ (shown);
  const sum = (/** @type {number[]} */ values) => values.reduce((a, b) => a + b, 0);
  const rows = islands.map(({ name, own }, i) => h("tr", {},
    h("td", {}, h("button", { class: "plain", type: "button", text: name, title: `Open ${name}`, onclick: () => open(name) }), own && h("small", { text: own.replaceAll("species.", "") })),
    ...species.map((_, k) => h("td", {}, number(count(i, k)), spark(n[i]?.[k] ?? [], colours[k]))),
    h("td", { text: number(sum(between.map((row) => row[i]))) }), h("td", { text: number(sum(between[i])) })));
  const head = ["island", ...species.map(({ name }) => name), "immigrants", "emigrants"];
  const cross = islands.map(({ name }, i) => h("tr", {}, h("td", { text: name }), ...islands.map((_, j) => h("td", { text: between[i][j] ? number(between[i][j]) : "–" }))));
  const grid = (/** @type {string[]} */ heads, /** @type {HTMLElement[]} */ body) => h("div", { class: "scrolls", tabindex: 0, role: "region", "aria-label": heads[0] === "island" ? "Islands" : "Migrants" },
    h("table", { class: "numbers" }, h("thead", {}, h("tr", {}, ...heads.map((text) => h("th", { scope: "col", text })))), h("tbody", {}, ...body)));
  return [h("h2", { text: "Islands" }), grid(head, rows), h("h2", { text: "Migrants, from row to column" }), grid(["from", ...islands.map(({ name }) => name)], cross)];
}

/** @param {number[]} values @param {string} colour */
function spark(values, colour) {
  const [wide, high] = SPARK;
  const every = Math.max(1, Math.floor(values.length / wide));
  const line = values.filter((_, p) => p % every === 0);
  const most = Math.max(1, ...line);
  const x = (/** @type {number} */ share) => 1 + share * (wide - 2);
  const points = line.map((value, p) => `${x(p / Math.max(1, line.length - 1)).toFixed(1)},${(high - 2 - ((high - 4) * value) / most).toFixed(1)}`).join(" ");
  const now = x(at / Math.max(1, values.length - 1));
  return s("svg", { width: wide, height: high, viewBox: `0 0 ${wide} ${high}`, "aria-hidden": "true" },
    s("line", { x1: now, x2: now, y1: 0, y2: high, stroke: "var(--chart)" }), s("polyline", { points, fill: "none", stroke: colour, "stroke-width": 1.6 }));
}

/** @param {string} name */
function open(name) {
  if (opening) return;
  opening = name;
  notice(`Opening ${name} …`);
  announce(`Opening ${name}`);
  connection.send({ kind: "open", island: name });
  draw();
}

/** @param {number} point */
function go(point) {
  if (!shown) return;
  at = Math.max(0, Math.min(shown.points.length - 1, point));
  newest = at === shown.points.length - 1;
  draw();
}

/** Starts or stops playback, which starts over if the last point is shown. @param {boolean} on */
function play(on) {
  clearInterval(playing);
  playing = 0;
  if (on && shown && at >= shown.points.length - 1) go(0);
  if (on) playing = setInterval(() => (at >= (shown?.points.length ?? 1) - 1 ? play(false) : go(at + 1)), PACE);
  $("play").innerHTML = on ? PAUSE : PLAY;
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
}

window.addEventListener("pageshow", () => { // after returning from an island
  opening = "";
  draw();
});
window.addEventListener("hashchange", () => (connection.socket === null ? connection.again() : taken()));
document.addEventListener("keydown", (event) => {
  const { key, target } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || /** @type {HTMLElement} */ (target).closest("input, select, button, [role=button]")) return;
  if (key === " ") play(!playing);
  else if (key === "t") switchTheme();
  else return;
  event.preventDefault();
});
recallTheme();
splitter();
onTheme(() => paint());
play(false);
$("play").addEventListener("click", () => play(!playing));
$("time").addEventListener("input", () => go(Number($("time").value)));
$("who").addEventListener("change", draw);
$("span").addEventListener("change", draw);
$("theme").addEventListener("click", switchTheme);
Object.assign(window, { ecs: {
  get tick() { return shown?.points[at] ?? 0; },
  get maps() { return maps; },
  get connected() { return $("link").dataset.link === "open"; },
} });
connection.open();
