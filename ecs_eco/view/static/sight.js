// Draws the field of view of the selected organism, with range, directions and visible targets. Rays end at the first body that they hit.

import { Vector3 } from "./vendor.js";
import { WORDS } from "./frame.js";
import { covered } from "./overlay.js";
import { css } from "./theme.js";

/** @typedef {import("./over.js").Over} Over */
/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {import("./layer.js").Layer} Layer */
/** @typedef {{layer: Layer, row: number}} Found */

const PARTS = 64; // segments of a circle

/** The heading of an organism [rad]. @param {Stage} stage @param {Found} found */
export function heading(stage, { layer, row }) {
  const from = layer.before[4 * row + 3] & 255;
  const turn = (((layer.now[WORDS * row + 3] & 255) - from + 384) & 255) - 128;
  return ((from + turn * stage.shared.alpha.value) * 2 * Math.PI) / 256;
}

/** The vector [m] from one position to another, along the shorter path on a torus. @param {Stage} stage @param {Vector3} from @param {Vector3} to */
export function way(stage, from, to) {
  const d = to.clone().sub(from);
  if (stage.hello.edges === "torus") {
    const [x, y] = stage.hello.size;
    d.x -= x * Math.round(d.x / x);
    d.y -= y * Math.round(d.y / y);
  }
  if (stage.hello.size.length < 3) d.z = 0; // distances are measured on the map
  return d;
}

/**
 * The nearest organism of a kind within reach and in view.
 * @param {Stage} stage @param {Found} me @param {Layer} layer @param {{reach: number, fov: number}} eye @param {number} angle
 */
export function nearest(stage, me, layer, { reach, fov }, angle) {
  const at = stage.spot(me.layer, me.row, new Vector3());
  const place = new Vector3();
  let best = null, least = reach;
  for (let row = 0; row < layer.block.n; row++) {
    if (layer === me.layer && row === me.row) continue;
    const d = way(stage, at, stage.spot(layer, row, place));
    const far = d.length();
    if (far > least || (fov < 6.28 && Math.abs(bearing(d, angle)) > fov / 2)) continue;
    least = far;
    best = { row, d };
  }
  return best;
}

/** The angle of a direction from the heading, −π … π. @param {Vector3} d @param {number} angle */
const bearing = (d, angle) => {
  const turn = Math.atan2(d.y, d.x) - angle;
  return Math.atan2(Math.sin(turn), Math.cos(turn));
};

/** Whether an organism's readings show that it does not see a target, for example because something is in between. @param {import("./protocol.js").Organism | null} organism @param {string} name */
function denied(organism, name) {
  const known = organism?.nerves?.sensors.filter((sensor) => sensor.name === `${name}_near` || (sensor.name.startsWith(`${name}_`) && /_\d+$/.test(sensor.name))) ?? [];
  return known.length > 0 && known.every(({ value }) => !value);
}

/** An organism's eyes with their current reach. @param {import("./protocol.js").Kind} kind @param {import("./protocol.js").Organism | null} own */
const eyesOf = (kind, own) => (kind.sees ?? []).map((eye) => ({ ...eye, reach: own?.reach?.[String(eye.number)] ?? eye.reach }));

/** The targets that an organism can see, as text, grouped by reach. @param {import("./protocol.js").Kind} kind @param {import("./protocol.js").Organism} own */
export function seeing(kind, own) {
  /** @type {Map<number, Set<string>>} */
  const far = new Map();
  for (const { reach, targets, name } of eyesOf(kind, own)) far.set(reach, new Set([...(far.get(reach) ?? []), ...(targets.length ? targets : [name])]));
  return [...far].sort(([a], [b]) => a - b).map(([reach, names]) => `${[...names].join(", ")} up to ${Number(reach.toPrecision(2))} m`).join("; ");
}

/**
 * Draws the field of view; returns the numbers of visible targets and rays.
 * @param {Over} over
 * @param {Found} me
 * @param {import("./protocol.js").Organism | null} organism
 */
export function sight(over, me, organism) {
  const { stage } = over;
  const at = stage.spot(me.layer, me.row, new Vector3());
  const angle = heading(stage, me);
  const own = organism?.uid === stage.selected ? organism : null;
  const eyes = eyesOf(me.layer.kind, own);
  /** @type {Map<string, typeof eyes>} one circle for each reach */
  const rings = new Map();
  for (const eye of eyes) {
    const key = [eye.reach, eye.kind === "rays" ? "rays" : eye.fov].join();
    rings.set(key, [...(rings.get(key) ?? []), eye]);
  }
  over.pen.textAlign = "center";
  over.pen.textBaseline = "alphabetic";
  for (const same of rings.values()) if (same[0].kind !== "rays") ring(over, at, angle, same);
  let seen = 0, rays = 0;
  for (const eye of eyes) {
    if (eye.kind === "rays") {
      const [n, hits] = fan(over, me, at, angle, /** @type {any} */ (eye), own);
      rays += n;
      seen += hits;
    } else if (eye.kind === "nearest" && !eye.kin && !denied(own, eye.name)) {
      for (const target of eye.targets) seen += look(over, me, at, angle, eye, target);
    }
  }
  over.pen.textAlign = "left";
  return { seen, rays };
}

/** The screen position of a point; on land, at ground level. @param {Stage} stage @param {Vector3} place */
function seenAt(stage, place) {
  if (stage.hello.size.length < 3) place.z = stage.relief.at(place.x, place.y);
  return stage.project(place);
}

/** Draws a circle or sector with the names of its targets. @param {Over} over @param {Vector3} at @param {number} angle @param {import("./protocol.js").SeeingEye[]} eyes */
function ring(over, at, angle, eyes) {
  const { stage } = over;
  const { reach, fov } = eyes[0];
  const whole = fov > 6.28;
  const points = Array.from({ length: PARTS + 1 }, (_, i) => {
    const a = angle - fov / 2 + (fov * i) / PARTS;
    return seenAt(stage, new Vector3(at.x + reach * Math.cos(a), at.y + reach * Math.sin(a), at.z));
  });
  const centre = stage.project(at);
  over.line(whole ? points : [centre, ...points, centre], css("--accent"), 1.4, [5, 4], 0.9);
  const names = [...new Set(eyes.flatMap(({ targets }) => targets))];
  const words = `sees ${names.join(", ")} up to ${Number(reach.toPrecision(2))} m`;
  const top = highest(points, over.pen.measureText(words).width, covered(), [stage.canvas.clientWidth, stage.canvas.clientHeight]);
  if (top && centre && Math.hypot(centre.x - top.x, centre.y - top.y) > 24) over.words(words, top.x, top.y - 5, css("--accent"));
}

/**
 * The highest point above which a label fits on the stage without being covered by cards; if there is none,
 * the highest point.
 * @param {({x: number, y: number} | null)[]} points @param {number} wide @param {number[][]} cards left, top, right and bottom of each
 * @param {number[]} size of the stage
 */
export function highest(points, wide, cards, [width, height]) {
  const there = points.filter((point) => point !== null).sort((a, b) => a.y - b.y);
  const clear = (/** @type {{x: number, y: number}} */ { x, y }) => x > wide / 2 && x < width - wide / 2 && y > 18 && y < height
    && !cards.some(([left, top, right, bottom]) => x + wide / 2 > left && x - wide / 2 < right && y > top && y - 18 < bottom);
  return there.find(clear) ?? there[0] ?? null;
}

/** Draws a line to the nearest organism of a kind. @param {Over} over @param {Found} me @param {Vector3} at @param {number} angle @param {import("./protocol.js").SeeingEye} eye @param {string} target */
function look(over, me, at, angle, eye, target) {
  const { stage } = over;
  const k = stage.kinds.findIndex(({ name }) => name === target);
  const found = k < 0 ? null : nearest(stage, me, stage.layers[k], eye, angle);
  if (!found) return 0;
  const there = at.clone().add(found.d);
  const [from, to] = [stage.project(at), seenAt(stage, there)];
  if (!from || !to) return 1;
  over.line([from, to], stage.colours[k], 2.2);
  over.line(Array.from({ length: 17 }, (_, i) => ({ x: to.x + 6 * Math.cos((i * Math.PI) / 8), y: to.y + 6 * Math.sin((i * Math.PI) / 8) })), stage.colours[k], 2);
  if (Math.hypot(from.x - to.x, from.y - to.y) > 34) over.words(target, to.x, to.y - 10);
  return 1;
}

/**
 * Draws each ray up to the first body that it hits; rays that hit a target have its color.
 * @param {Over} over @param {Found} me @param {Vector3} at @param {number} angle
 * @param {import("./protocol.js").SeeingEye & {count: number, angle: number}} eye @param {import("./protocol.js").Organism | null} organism
 */
function fan(over, me, at, angle, eye, organism) {
  const { stage } = over;
  const { count, fov, reach } = eye;
  const around = bodies(stage, me, at, reach, eye.targets);
  const step = (fov > 6.28 ? fov : (fov * count) / Math.max(count - 1, 1)) / count;
  const dark = denied(organism, eye.name) && !eye.targets.some((target) => !denied(organism, `${eye.name}_${target}`));
  let hits = 0;
  for (let i = 0; i < count; i++) {
    const a = angle + eye.angle + (i - (count - 1) / 2) * step;
    const [ux, uy] = [Math.cos(a), Math.sin(a)];
    let far = reach, hit = -1;
    for (const { d, radius, k } of around) {
      const along = d.x * ux + d.y * uy;
      const across2 = d.lengthSq() - along * along;
      if (along <= 0 || across2 > radius * radius) continue;
      const distance = Math.max(0, along - Math.sqrt(radius * radius - across2));
      if (distance < far) [far, hit] = [distance, k];
    }
    const target = hit >= 0 && eye.targets.includes(stage.kinds[hit].name) && !dark;
    hits += Number(target);
    const ends = [0, 0.25, 0.5, 0.75, 1].map((share) => seenAt(stage, new Vector3(at.x + share * far * ux, at.y + share * far * uy, at.z)));
    over.line(ends, target ? stage.colours[hit] : css("--accent"), target ? 2.2 : 1, [], target ? 1 : 0.45);
  }
  return [count, hits];
}

/** Bodies that can stop rays: targets and other opaque bodies. @param {Stage} stage @param {Found} me @param {Vector3} at @param {number} reach @param {string[]} targets */
function bodies(stage, me, at, reach, targets) {
  const place = new Vector3();
  /** @type {{d: Vector3, radius: number, k: number}[]} */
  const found = [];
  stage.layers.forEach((layer, k) => {
    if (layer.kind.opaque === false && !targets.includes(layer.kind.name)) return;
    const radius = layer.kind.radius;
    for (let row = 0; row < layer.block.n; row++) {
      if (layer === me.layer && row === me.row) continue;
      const d = way(stage, at, stage.spot(layer, row, place));
      if (Math.abs(d.x) <= reach + radius && Math.abs(d.y) <= reach + radius && d.length() <= reach + radius) found.push({ d, radius, k });
    }
  });
  return found;
}
