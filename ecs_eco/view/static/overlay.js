// Elements over the scene: ring around the selected organism, tooltip, scale, position of the sun, notices.

import { $, h, number, s } from "./dom.js";
import { WIDE } from "./knobs.js";
import { gradient, rampOf } from "./colours.js";
import { WORDS } from "./frame.js";
import { round } from "./ground.js";

/** @typedef {import("./stage.js").Stage} Stage */

/**
 * The legend of value colors.
 * @param {string} by
 * @param {Record<string, [number, number]>} [scales] low and high, by kind
 */
export function ramp(by, scales) {
  const root = $("ramp");
  root.hidden = by === "species";
  if (root.hidden) return;
  const found = Object.entries(scales ?? {});
  const key = JSON.stringify([by, found]);
  if (root.dataset.key === key) return;
  root.dataset.key = key;
  const words = by === "family" ? "family: the twelve largest of each species, each descended from one founder" : by.replace("gene:", "gene ").replace("kin:", "descendants of #");
  root.replaceChildren(words, h("i", { style: `background:${gradient(rampOf(by))}` }), ...found.map(([name, [low, high]]) =>
    h("div", {}, h("span", { text: number(low) }), h("em", { text: name }), h("span", { text: number(high) }))));
  if (!found.length && rampOf(by) === "sequential") root.append(h("div", {}, h("span", { text: "low" }), h("span", { text: "high" })));
}

/** Shows the number of descendants, if organisms are colored by descent. @param {Stage} stage @param {string} by */
export function descendants(stage, by) {
  if (!by.startsWith("kin:")) return;
  const alive = stage.layers.reduce((sum, { block, kind }) => {
    if (!kind.inanimate) for (let row = 0; row < block.n; row++) sum += Number(block.words[WORDS * row + 3] >> 8 === 255);
    return sum;
  }, 0);
  const words = `descendants of #${by.slice(4)}: ${number(alive)} alive`;
  const first = $("ramp").firstChild;
  if (first && first.textContent !== words) first.textContent = words;
}

/**
 * Updates the ring and name of the selected organism, and the scale; called after each drawing.
 * @param {Stage} stage
 */
export function follow(stage) {
  circle(stage, $("ring"), $("trailLabel"));
  const perMetre = stage.scale();
  const metres = round(110 / perMetre);
  const [bar, text] = $("scale").children;
  bar.style.width = `${(metres * perMetre).toFixed(0)}px`;
  const shown = metres >= 1000 ? `${metres / 1000} km` : metres >= 1 ? `${metres} m` : `${Number((metres * 100).toPrecision(2))} cm`;
  if (text.textContent !== shown) text.textContent = shown;
}

/** Updates the ring and name of a scene's selected organism. @param {Stage} stage @param {HTMLElement} ring @param {HTMLElement} tag */
export function circle(stage, ring, tag) {
  const place = stage.selected === null ? null : stage.place(stage.selected);
  const at = place && stage.project(place);
  ring.hidden = tag.hidden = !at;
  if (!at) return;
  const [x, y] = [at.x + stage.canvas.offsetLeft, at.y + stage.canvas.offsetTop];
  ring.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  tag.style.transform = `translate(${(x + 17).toFixed(1)}px, ${(y - 11).toFixed(1)}px)`;
  const text = `${stage.find(/** @type {number} */ (stage.selected))?.layer.kind.name ?? ""} #${stage.selected}`;
  if (tag.textContent !== text) tag.textContent = text;
}

/**
 * @param {{x: number, y: number} | null} at [px]
 * @param {string} [text]
 */
export function tip(at, text = "") {
  const root = $("tip");
  root.hidden = !at;
  $("canvas").classList.toggle("over", Boolean(at));
  if (!at) return;
  root.textContent = text;
  root.style.transform = `translate(${(at.x + 14).toFixed(0)}px, ${(at.y + 14).toFixed(0)}px)`;
}

/**
 * Shows the current light: sky and position of the sun.
 * @param {Stage} stage
 */
export function sky(stage) {
  const day = Math.min(1, Math.max(0, stage.light));
  const mix = (/** @type {string} */ end) => `color-mix(in oklab, var(--sky-day-${end}) ${(100 * day).toFixed(0)}%, var(--sky-night-${end}))`;
  $("stage").style.setProperty("--sky-high", mix("high"));
  $("stage").style.setProperty("--sky-low", mix("low"));
  const dial = $("dial");
  dial.toggleAttribute("hidden", !stage.hello.day);
  if (!stage.hello.day) return;
  const e = stage.elevation;
  const rising = stage.shared.sun.value.x >= 0;
  const x = 32 + (rising ? -1 : 1) * 24 * Math.cos(e);
  const y = 27 - 22 * Math.sin(e);
  const up = e > 0;
  dial.replaceChildren(
    s("path", { d: "M6 27a26 22 0 0 1 52 0", fill: "none", stroke: "var(--soft)", "stroke-width": 0.8, "stroke-dasharray": "1.5 2" }),
    s("line", { x1: 2, x2: 62, y1: 27, y2: 27, stroke: "var(--soft)", "stroke-width": 0.8 }),
    s("circle", { cx: x, cy: Math.min(y, 33), r: 4.2, fill: up ? "#f0b429" : "var(--card)", stroke: up ? "#b87d00" : "var(--soft)", "stroke-width": 0.8 }),
    s("text", { x: 32, y: 21, "font-size": 6.5, "text-anchor": "middle", fill: "var(--soft)" }, `light ${number(Math.round(100 * stage.light))}%`),
  );
}

let flashing = 0;

/**
 * @param {string | null} text
 * @param {{text: string, does: () => void}} [button]
 */
export function notice(text, button) {
  const root = $("notice");
  clearTimeout(flashing);
  root.hidden = text === null;
  root.replaceChildren(text ?? "", ...(button ? [h("button", { type: "button", text: button.text, onclick: button.does })] : []));
}

/** A notice that disappears after a while. @param {string} text @param {{text: string, does: () => void}} [button] */
export function flash(text, button) {
  notice(text, button);
  flashing = setTimeout(() => notice(null), 6000);
}

/** Shows the state of the connection to the server. @param {"connecting" | "open" | "lost" | "ended" | "refused"} link @param {import("./connection.js").Connection} connection */
export function linked(link, connection) {
  const words = { connecting: "connecting", open: "connected", lost: "reconnecting", ended: "ended", refused: "no access" };
  $("link").dataset.link = link;
  $("link").textContent = words[link];
  $("link").title = words[link];
  if (link === "ended") notice(connection.done ? "The run has ended." : connection.greeted ? "The server has stopped or cannot be reached." : "There is no response from this address.", { text: "Try again", does: () => connection.again() });
  else if (link === "refused") door(connection.greeted ? "The run has restarted; open its new address." : "No access: each address works only once and expires after 10 minutes.");
  else if (link === "lost") notice("Connection lost; trying again …");
  else notice(null);
}

/**
 * Shows why this page has no access, and a field for another address.
 * @param {string} why
 */
export function door(why) {
  const field = h("input", { class: "input", type: "text", placeholder: "http://127.0.0.1:…/#code=…", "aria-label": "Address shown in the terminal", autocomplete: "off", spellcheck: "false" });
  const form = h("form", {}, field, h("button", { type: "submit", text: "Open" }));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const code = field.value.split("#")[1] ?? "";
    if (!code.startsWith("code=")) return field.focus();
    const address = new URL(field.value, location.href);
    if (address.origin === location.origin) location.hash = code; // main.js then connects
    else if (address.protocol === "http:" && address.hostname === location.hostname) location.assign(address);
  });
  const root = $("notice");
  root.hidden = false;
  root.replaceChildren(`${why} Enter the address that the terminal shows now:`, form);
}

/** The left, top, right and bottom [px] of each part of the stage that is covered by a card. @param {number[]} [from] a corner of the stage */
export function covered([x, y] = [0, 0]) {
  const stage = $("stage").getBoundingClientRect(), left = stage.left + x, top = stage.top + y;
  const boxes = ["legend", "cameras", ...(stage.width >= WIDE ? ["knobs"] : []), "scale", "dial"].map((id) => $(id)).filter((card) => !card.hasAttribute("hidden")).map((card) => card.getBoundingClientRect());
  return boxes.filter(({ width }) => width).map((box) => [box.left - left - 4, box.top - top - 4, box.right - left + 4, box.bottom - top + 4]);
}
