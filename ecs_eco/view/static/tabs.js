// The panel tabs: opened by a click or arrow keys, moved by dragging or with shift and arrow keys. A pinned panel stays next to the open one.
// The browser stores the order and the pinned panel.

import { $, announce, h } from "./dom.js";

/** @typedef {string} PanelName */

const KEPT = "ecs-eco-panels";
const MOVED = 6; // [px] after which a press is a drag
const ALWAYS = "always"; // in data-pinned; charts are otherwise pinned only if the panels are wide

/** @type {PanelName[]} */
export const PANELS = ["charts", "world", "why", "organism", "all", "act"];

/** Adds a tab with an empty panel, which is returned. @param {PanelName} name @param {string} title */
export function addPanel(name, title) {
  PANELS.push(name);
  list().append(h("button", { role: "tab", id: `tab-${name}`, "aria-controls": name, "aria-selected": "false", tabindex: -1, type: "button", text: title }));
  return $("side").appendChild(h("div", { id: name, class: "panel own", role: "tabpanel", "aria-labelledby": `tab-${name}`, tabindex: 0, hidden: true }));
}

/** Shows one panel. @param {PanelName} name */
export function openPanel(name) {
  for (const other of PANELS) {
    $(other).hidden = other !== name;
    $(`tab-${other}`).setAttribute("aria-selected", String(other === name));
    $(`tab-${other}`).tabIndex = other === name ? 0 : -1;
  }
  $("pin").setAttribute("aria-pressed", String($(name).dataset.pinned === ALWAYS));
}

/** The open panel. */
export const opened = () => PANELS.find((name) => !$(name).hidden) ?? "charts";

/** Whether a panel is displayed: open or pinned. @param {PanelName} name */
export const displayed = (name) => $(name).checkVisibility();

const list = () => /** @type {HTMLElement} */ ($("side").querySelector("[role=tablist]"));
const tabs = () => /** @type {HTMLElement[]} */ ([...list().querySelectorAll("[role=tab]:not([hidden])")]);

/** Pins one panel, or none. @param {PanelName | null} name */
function pin(name) {
  for (const other of PANELS) delete $(other).dataset.pinned;
  if (name !== null && PANELS.includes(name) && !$(`tab-${name}`).hidden) $(name).dataset.pinned = ALWAYS;
}

/** Restores the stored order and pinned panel. */
export function arrange() {
  try {
    const { order = [], pinned } = JSON.parse(localStorage.getItem(KEPT) ?? "{}");
    for (const name of order) if (PANELS.includes(name)) list().append($(`tab-${name}`));
    for (const name of PANELS) if (!order.includes(name)) list().append($(`tab-${name}`));
    if (pinned !== undefined) pin(pinned);
  } catch {} // storage may be unavailable in private windows
  openPanel(opened());
}

function keep() {
  const order = [...list().children].map(({ id }) => id.slice(4)), pinned = PANELS.find((name) => $(name).dataset.pinned === ALWAYS);
  try {
    localStorage.setItem(KEPT, JSON.stringify({ order, ...($("charts").dataset.pinned === "wide" ? {} : { pinned: pinned ?? null }) }));
  } catch {}
}

/** Puts a tab before or after another one. @param {HTMLElement} tab @param {HTMLElement | undefined} other */
function move(tab, other) {
  if (!other || other === tab) return;
  if (tab.compareDocumentPosition(other) & Node.DOCUMENT_POSITION_FOLLOWING) other.after(tab);
  else other.before(tab);
  tab.focus();
  keep();
  announce(`${tab.textContent}: tab ${tabs().indexOf(tab) + 1} of ${tabs().length}`);
}

/** Moves a tab while it is dragged. @param {PointerEvent} event @param {HTMLElement} tab */
function drag({ clientX: x, clientY: y }, tab) {
  const over = /** @type {HTMLElement | undefined} */ (document.elementFromPoint(x, y)?.closest(".tabs [role=tab]") ?? undefined);
  if (!over || over === tab) return;
  const { left, width } = over.getBoundingClientRect(), after = tab.compareDocumentPosition(over) & Node.DOCUMENT_POSITION_FOLLOWING;
  if (over.offsetTop !== tab.offsetTop || (after ? x > left + width / 2 : x < left + width / 2)) move(tab, over);
}

/** Handles clicks, arrow keys and drags. @param {(name: PanelName) => void} open */
export function listenTabs(open) {
  const strip = list();
  /** @type {{tab: HTMLElement, x: number, y: number, moves: boolean} | null} */
  let held = null;
  const tabOf = (/** @type {Event} */ { target }) => /** @type {HTMLElement | null} */ (/** @type {HTMLElement} */ (target).closest("[role=tab]"));
  strip.addEventListener("pointerdown", (event) => {
    const tab = tabOf(event);
    held = tab && event.button === 0 ? { tab, x: event.clientX, y: event.clientY, moves: false } : null;
  });
  strip.addEventListener("pointermove", (event) => {
    if (!held || !(event.buttons & 1)) return;
    held.moves ||= Math.hypot(event.clientX - held.x, event.clientY - held.y) > MOVED;
    if (held.moves) strip.setPointerCapture(event.pointerId), drag(event, held.tab);
  });
  strip.addEventListener("click", (event) => {
    const tab = tabOf(event);
    if (tab && !(held?.moves && event.detail)) open(tab.id.slice(4)); // not after a drag
    held = null;
  });
  strip.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    event.preventDefault();
    const all = tabs(), at = all.findIndex((tab) => tab.getAttribute("aria-selected") === "true"), by = event.key === "ArrowRight" ? 1 : -1;
    if (event.shiftKey) return move(all[at], all[at + by]);
    const tab = all[(at + by + all.length) % all.length];
    tab.click();
    tab.focus();
  });
  $("pin").addEventListener("click", () => {
    const name = opened(), on = $(name).dataset.pinned !== ALWAYS;
    pin(on ? name : null);
    keep();
    open(name);
    announce(on ? `${$(`tab-${name}`).textContent} stays visible next to other panels` : "No panel is pinned");
  });
}
