// The nervous system of one organism, with sensors on the left, reflex network, policy and happiness in the middle, and actions on the right.
// Actions have y (reflex), p (policy), z (chosen) and the decision H(y + z), as in Figure 1 of the paper. Values are updated in place.

import { number, s } from "./dom.js";
import { rampColour } from "./colours.js";
import { css } from "./theme.js";

/** @typedef {import("./protocol.js").Nerves} Nerves */
/** @typedef {import("./protocol.js").Wiring} Wiring */

const STEP = 17;
const LETTERS = "650 10.5px "; // font of action names at their widest, when the action is carried out
const LABEL = 88, ACTION = 40; // space for sensor and action names; longer names enlarge it
const NODE = 142; // x of sensor nodes
const BOX = [166, 62]; // x and width of the networks
const Y = 272, P = 290, Z = 331, H = 348, NAME = 360;
const BOXES = /** @type {const} */ (["reflex", "policy", "happiness"]);
const WORDS = { y: "y: the reflex forces (+1), leaves unchanged (0) or blocks (−1) the action", p: "p: probability given by the policy", z: "z: chosen by the policy", H: "decision H(y + z): carried out or not" };

/**
 * Draws a nervous system; `update` shows new values in the same drawing.
 * @param {Nerves} nerves
 * @param {Wiring} [wiring] connections of readings; if absent, any reading can affect everything
 */
export function drawNerves(nerves, wiring) {
  const rows = Math.max(nerves.sensors.length, nerves.actions.length + 1, 9);
  const height = 26 + rows * STEP + 4;
  const left = Math.max(0, room(nerves.sensors) - LABEL);
  const names = NAME + Math.max(ACTION, room(nerves.actions));
  const right = names + room(nerves.actions.map(({ group }) => ({ name: group })));
  const root = s("svg", { class: "nerves", viewBox: `${-left} 0 ${left + right} ${height}`, role: "img", "aria-label": describe(nerves) });
  const spread = (/** @type {number} */ n, /** @type {number} */ i) => 26 + ((i + 0.5) * rows * STEP) / n;
  const wires = s("g", { fill: "none" });
  root.append(wires);
  head(root);
  const boxes = networks(root, rows, wiring);
  /** @type {((nerves: Nerves) => void)[]} */
  const parts = [];
  nerves.sensors.forEach((sensor, i) => parts.push(sense(root, wires, sensor, i, spread(nerves.sensors.length, i), boxes, leads(wiring, i))));
  nerves.actions.forEach((action, i) => parts.push(act(root, wires, action, i, spread(nerves.actions.length, i), boxes, groupStarts(nerves, i) ? right : 0, reflexive(wiring, i))));
  nerves.actions.forEach(({ group }, i) => {
    if (!i || groupStarts(nerves, i)) root.append(s("text", { x: right - 2, y: spread(nerves.actions.length, i) + 3.5, "font-size": 9.5, class: "muted", "text-anchor": "end" }, group));
  });
  parts.push(joy(root, boxes.happiness));
  const update = (/** @type {Nerves} */ values) => parts.forEach((part) => part(values));
  update(nerves);
  return { root, update, signature: signature(nerves) };
}

/** A key for the drawing's structure: values with the same key fit the same drawing. @param {Nerves} nerves */
export function signature(nerves) {
  return [...nerves.sensors.map(({ name }) => name), ...nerves.actions.map(({ group, name }) => `${group}/${name}`)].join();
}

/** @param {Nerves} nerves */
function describe(nerves) {
  return `Nervous system: ${nerves.sensors.length} sensors, ${nerves.actions.length} actions`;
}

/**
 * @param {Nerves} nerves
 * @param {number} i
 */
function groupStarts(nerves, i) {
  return i > 0 && nerves.actions[i].group !== nerves.actions[i - 1].group;
}

/** The boxes to which a reading leads. @param {Wiring | undefined} wiring @param {number} i its row */
function leads(wiring, i) {
  const to = { reflex: !wiring || wiring.all.reflex || wiring.reflexes.some(([rows]) => rows.includes(i)), policy: !wiring || wiring.all.policy, happiness: !wiring || wiring.all.happiness || wiring.felt.includes(i) };
  return BOXES.filter((name) => to[name]);
}

/** Whether a reflex leads to an action. @param {Wiring | undefined} wiring @param {number} i its row */
const reflexive = (wiring, i) => !wiring || wiring.all.reflex || wiring.reflexes.some(([, action]) => action === i);

/** Each reflex, the policy and the happiness formula as text. @param {Nerves} nerves @param {Wiring} wiring @returns {[string, string][]} */
export function wired(nerves, wiring) {
  const reflexes = wiring.reflexes.map(([, action, what]) => `${nerves.actions[action]?.name}: ${what}`);
  return [
    ["happiness =", wiring.happiness ?? "none"],
    ["reflexes", [...(wiring.function ? [wiring.function] : []), ...reflexes].join("; ") || "none"],
    ["policy", wiring.policy],
  ];
}

/** Space for the longest name [px]. @param {{name: string}[]} named */
function room(named) {
  const pen = document.createElement("canvas").getContext("2d");
  if (pen) pen.font = LETTERS + css("--font");
  return 8 + Math.max(0, ...named.map(({ name }) => pen?.measureText(name).width ?? 8 * name.length));
}

/** @param {SVGElement} root */
function head(root) {
  const label = (/** @type {number} */ x, /** @type {string} */ text, /** @type {string} */ title) =>
    root.append(s("text", { x, y: 14, "font-size": 10.5, class: "muted", "text-anchor": "middle" }, s("title", {}, title), text));
  label(62, "sensors x", "sensor readings");
  label(Y, "y", WORDS.y);
  label(P + 16, "p", WORDS.p);
  label(Z, "z", WORDS.z);
  label(H, "H", WORDS.H);
}

/**
 * @param {SVGElement} root
 * @param {number} rows
 * @param {Wiring} [wiring]
 */
function networks(root, rows, wiring) {
  const total = rows * STEP;
  const each = Math.min(52, total / 3 - 8);
  const place = (/** @type {number} */ k) => 26 + (total * (k + 0.5)) / 3;
  const boxes = { reflex: place(0), policy: place(1), happiness: place(2), half: each / 2 };
  const there = { reflex: !wiring || wiring.all.reflex || wiring.reflexes.length > 0, policy: !wiring || wiring.all.policy, happiness: !wiring || wiring.happiness !== null };
  for (const name of BOXES) {
    const middle = boxes[name];
    root.append(
      s("rect", { x: BOX[0], y: middle - each / 2, width: BOX[1], height: each, rx: 8, fill: "var(--hover)", stroke: "var(--chart)" }),
      s("text", { x: BOX[0] + BOX[1] / 2, y: middle + (name === "happiness" ? -11 : 3.5), "font-size": there[name] ? 10.5 : 9, "text-anchor": "middle", class: there[name] ? "" : "muted" }, there[name] ? name : `no ${name}`),
    );
  }
  return boxes;
}

/** @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
const curve = (x0, y0, x1, y1) => `M${x0} ${y0.toFixed(1)}C${(x0 + x1) / 2} ${y0.toFixed(1)} ${(x0 + x1) / 2} ${y1.toFixed(1)} ${x1} ${y1.toFixed(1)}`;

/**
 * A sensor: its name, a bar for its value, a node, and wires into the networks.
 * @param {SVGElement} root
 * @param {SVGElement} wires
 * @param {import("./protocol.js").Sensor} sensor
 * @param {number} i
 * @param {number} y
 * @param {ReturnType<typeof networks>} boxes
 * @param {readonly ("reflex" | "policy" | "happiness")[]} to boxes to which it leads
 * @returns {(nerves: Nerves) => void}
 */
function sense(root, wires, sensor, i, y, boxes, to) {
  const bar = s("rect", { y: y - 3, height: 6, rx: 1.5 });
  const node = s("circle", { cx: NODE, cy: y, r: 3.6, stroke: "var(--chart)" });
  const title = s("title", {});
  const lines = to.map((name) => s("path", { "data-wire": `${sensor.name} ${name}`, d: curve(NODE + 4, y, BOX[0], boxes[name] + ((i % 7) - 3) * boxes.half * 0.2) }));
  wires.append(...lines);
  root.append(s("g", {}, title, s("rect", { x: 0, y: y - 8, width: NODE + 4, height: 16, fill: "transparent" }),
    s("text", { x: 88, y: y + 3.5, "font-size": 10.5, "text-anchor": "end" }, sensor.name),
    s("rect", { x: 94, y: y - 3, width: 40, height: 6, rx: 1.5, fill: "var(--line)" }), bar, node));
  let most = 1;
  let signed = false; // whether the value has been below 0; if so, the bar starts in the middle
  return (nerves) => {
    const value = nerves.sensors[i]?.value ?? 0;
    most = Math.max(most, Math.abs(value));
    const share = Math.max(-1, Math.min(1, value / most));
    signed ||= share < 0;
    const width = Math.abs(share) * (signed ? 20 : 40);
    set(bar, { x: share < 0 ? 114 - width : signed ? 114 : 94, width: Math.max(0.5, width), fill: share < 0 ? "var(--minus)" : "var(--accent)" });
    const colour = `rgb(${rampColour("diverging", 0.5 + share / 2).map(Math.round).join(" ")})`;
    node.setAttribute("fill", colour);
    for (const line of lines) set(line, { stroke: "var(--soft)", "stroke-width": 0.5 + 0.9 * Math.abs(share), opacity: 0.12 + 0.5 * Math.abs(share) });
    title.textContent = `${sensor.name} = ${number(nerves.sensors[i]?.value)}`;
  };
}

/**
 * An action: the values of reflex and policy, and whether it is carried out.
 * @param {SVGElement} root
 * @param {SVGElement} wires
 * @param {import("./protocol.js").Action} action
 * @param {number} i
 * @param {number} y
 * @param {ReturnType<typeof networks>} boxes
 * @param {number} line length of the line above if the action starts a group, else 0
 * @param {boolean} reflexes whether a reflex leads to the action
 * @returns {(nerves: Nerves) => void}
 */
function act(root, wires, action, i, y, boxes, line, reflexes) {
  const end = BOX[0] + BOX[1];
  const forced = s("path", { d: curve(end, boxes.reflex + ((i % 5) - 2) * boxes.half * 0.3, Y - 10, y) });
  const likely = s("path", { d: curve(end, boxes.policy + ((i % 5) - 2) * boxes.half * 0.3, Y - 10, y), stroke: "var(--accent)" });
  wires.append(...(reflexes ? [forced, likely] : [likely]));
  const cell = s("rect", { x: Y - 9, y: y - 6.5, width: 18, height: 13, rx: 3.5 });
  const sign = s("text", { x: Y, y: y + 3.6, "font-size": 10, "text-anchor": "middle", "font-weight": 600 });
  const bar = s("rect", { x: P, y: y - 3, height: 6, rx: 1.5, fill: "var(--accent)" });
  const dot = s("circle", { cx: Z, cy: y, r: 3.6, stroke: "var(--accent)", "stroke-width": 1.4 });
  const lamp = s("rect", { x: H - 5, y: y - 5, width: 10, height: 10, rx: 2.5, stroke: "var(--ink)", "stroke-width": 1.4 });
  const name = s("text", { x: NAME, y: y + 3.5, "font-size": 10.5 }, action.name);
  const amount = s("text", { x: H + 6, y: y + 3.5, "font-size": 10.5, "text-anchor": "end" }); // value of a continuous action
  const title = s("title", {});
  if (line) root.append(s("line", { x1: Y - 9, x2: line, y1: y - STEP * 0.5 - 1, y2: y - STEP * 0.5 - 1, stroke: "var(--line)" }));
  root.append(s("g", {}, title, s("rect", { x: Y - 10, y: y - 8, width: NAME + ACTION - Y + 10, height: 16, fill: "transparent" }), cell, sign,
    s("rect", { x: P, y: y - 3, width: 32, height: 6, rx: 1.5, fill: "var(--line)" }), bar, dot, lamp, amount, name));
  return (nerves) => {
    const { reflex, probability, chosen, decision, continuous } = nerves.actions[i];
    const hue = reflex > 0 ? "var(--plus)" : reflex < 0 ? "var(--minus)" : "var(--line)";
    set(cell, { fill: hue, opacity: reflex ? 1 : 0.7 });
    set(sign, { fill: reflex ? "var(--card)" : "var(--soft)" });
    sign.style.fill = reflex ? "var(--card)" : "var(--soft)";
    sign.textContent = continuous ? number(reflex, 1) : reflex > 0 ? "+1" : reflex < 0 ? "−1" : "0";
    set(forced, { stroke: reflex ? hue : "var(--chart)", "stroke-width": reflex ? 2 : 0.6, opacity: reflex ? 0.9 : 0.4, "stroke-dasharray": reflex < 0 ? "4 3" : "none" });
    const p = probability ?? 0;
    set(bar, { width: 32 * p });
    set(likely, { "stroke-width": 0.5 + 2 * p, opacity: probability === null ? 0 : 0.12 + 0.6 * p });
    set(dot, { fill: chosen && !continuous ? "var(--accent)" : "none", opacity: continuous ? 0 : 1 });
    set(lamp, { fill: decision ? "var(--ink)" : "none", opacity: continuous ? 0 : decision ? 1 : 0.45 });
    name.setAttribute("font-weight", decision && !continuous ? "650" : "400");
    if (continuous) {
      amount.textContent = number(Number(decision), 2);
      title.textContent = `${action.group}: the policy drew ${number(Number(chosen))}, the reflex added ${number(reflex)}, the result is ${number(Number(decision))}`;
      return;
    }
    title.textContent = `${action.group}: ${action.name}\ny = ${sign.textContent}, p = ${number(probability)}, z = ${Number(chosen)}, H = ${Number(decision)}`;
  };
}

/**
 * The values of happiness and reward.
 * @param {SVGElement} root
 * @param {number} y
 * @returns {(nerves: Nerves) => void}
 */
function joy(root, y) {
  const value = s("text", { x: BOX[0] + BOX[1] / 2, y: y + 5, "font-size": 13, "font-weight": 650, "text-anchor": "middle" });
  const reward = s("text", { x: BOX[0] + BOX[1] / 2, y: y + 18, "font-size": 10, "text-anchor": "middle" });
  root.append(value, reward);
  reward.append(s("title", {}, "reward: the change in happiness"));
  return (nerves) => {
    value.textContent = number(nerves.happiness);
    const change = nerves.reward ?? 0;
    reward.textContent = nerves.reward === null ? "" : `${change >= 0 ? "+" : "−"}${number(Math.abs(change), 2)}`;
    reward.style.fill = change < 0 ? "var(--minus)" : "var(--plus)";
  };
}

/** @param {SVGElement} element @param {Record<string, string | number>} attributes */
function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}
