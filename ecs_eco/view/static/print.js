// Saves charts as files: the numbers as CSV, the drawing as SVG or PNG, with title, axes, legend, and the world, seed and tick that they show.

import { uPlot } from "./vendor.js";
import { roundValues } from "./axes.js";
import { h, s } from "./dom.js";
import { save, slug } from "./save.js";
import { css } from "./theme.js";

/** @typedef {{name: string, mark: SVGElement}} Item an entry of a legend */
/** @typedef {{title: string, unit?: string, body: SVGElement, legend?: Item[]}} Drawn a drawing with its own size as viewBox */

const MARGIN = 14, ROW = 16; // in units of a drawing, like all sizes below
const [WIDE, LEFT, RIGHT, TOP, BOTTOM] = [612, 62, 10, 8, 34]; // a chart and its margins
export const ACROSS = WIDE; // width of a scene
const MM = 170 / (WIDE + 2 * MARGIN); // a chart is 170 mm wide, as in journals with two columns
export const DOTS = (300 / 25.4) * MM; // [px] of a picture, for 300 dots per inch

/**
 * Buttons that save a chart, in one line.
 * @param {string} title
 * @param {(() => string) | null} table the numbers
 * @param {() => Omit<Drawn, "title" | "body"> & {body: SVGElement | null | undefined}} drawn
 * @param {() => string} ending of the name of the file of numbers
 */
export function saves(title, table, drawn, ending = () => "") {
  const button = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ does) =>
    h("button", { class: "mini", type: "button", text, title: label, "aria-label": label, onclick: does });
  const printed = (/** @type {"svg" | "png"} */ kind) => () => {
    const { body, legend, ...more } = drawn();
    if (body) print(slug(title), { title, body, legend: legend ?? kindsIn(body), ...more }, kind);
  };
  return h("span", { class: "saves" },
    ...(table ? [button("csv", `Save the numbers: ${title}`, () => save(`${slug(title)}${ending()}.csv`, new Blob([table()], { type: "text/csv" })))] : []),
    button("png", `Save the picture: ${title}`, printed("png")),
    button("svg", `Save the drawing: ${title}`, printed("svg")),
  );
}

/** The kinds in a drawing, with their colors. @param {SVGElement} body */
const kindsIn = (body) => /** @type {SVGElement[]} */ ([...body.querySelectorAll("[data-kind]")]).map((one) =>
  ({ name: one.dataset.kind ?? "", mark: s("svg", { viewBox: "0 0 18 12" }, s("rect", { x: 3, width: 12, height: 12, rx: 2, fill: one.getAttribute("fill") })) }));

let origin = () => ""; // the world, seed and tick
const CAPTION = { high: 22, up: 8, size: 10 }; // the last line of drawings: space for it, its distance from the edge, size of its letters

/** Sets the last line of drawings. @param {() => string} from */
export const originates = (from) => (origin = from);

/** The width of a text in 11-unit letters. @param {string} text */
function lengthOf(text) {
  const pen = h("canvas").getContext("2d");
  if (pen) pen.font = "11px sans-serif";
  return pen?.measureText(text).width ?? 6 * text.length;
}

/** A drawing with its title, legend and origin. @param {Drawn} drawn */
export function sheet({ title, unit, body, legend = [] }) {
  const [, , wide, high] = (body.getAttribute("viewBox") ?? "").split(" ").map(Number);
  const [ink, soft] = [css("--ink"), css("--soft")], inner = body.cloneNode(true);
  const marks = [];
  let [x, y] = [MARGIN, 40];
  for (const { name, mark } of legend) {
    const length = lengthOf(name) + 38;
    if (x > MARGIN && x + length > wide + MARGIN) [x, y] = [MARGIN, y + ROW];
    for (const [key, value] of Object.entries({ x, y: y - 8, width: 18, height: 12 })) mark.setAttribute(key, String(value));
    marks.push(mark, s("text", { x: x + 23, y: y + 2, fill: ink }, name));
    x += length;
  }
  const top = marks.length ? y + 12 : 34, across = wide + 2 * MARGIN, down = top + high + CAPTION.high;
  for (const [key, value] of Object.entries({ x: MARGIN, y: top, width: wide, height: high })) /** @type {SVGElement} */ (inner).setAttribute(key, String(value));
  return s("svg", { viewBox: `0 0 ${across} ${down}`, width: `${MM * across}mm`, height: `${MM * down}mm`, "font-family": "sans-serif", "font-size": 11 },
    s("rect", { width: across, height: down, fill: css("--card") }),
    s("text", { x: MARGIN, y: 22, fill: ink, "font-size": 15, "font-weight": 600 }, title, ...(unit ? [s("tspan", { dx: 8, fill: soft, "font-size": 11, "font-weight": 400 }, unit)] : [])),
    ...marks, inner, s("text", { x: MARGIN, y: down - CAPTION.up, fill: soft, "font-size": CAPTION.size }, origin()));
}

/** Adds the last line of drawings below a picture, at a number of pixels per unit; both are drawn into `canvas`. @param {HTMLCanvasElement} picture @param {HTMLCanvasElement} canvas @param {number} ratio */
export function caption(picture, canvas, ratio) {
  const { width, height } = picture, [high, up, size, left] = [CAPTION.high, CAPTION.up, CAPTION.size, MARGIN].map((units) => Math.round(units * ratio));
  if (canvas.width !== width || canvas.height !== height + high) [canvas.width, canvas.height] = [width, height + high];
  const pen = canvas.getContext("2d", { alpha: false });
  if (!pen) return;
  pen.fillStyle = css("--card");
  pen.fillRect(0, height, width, high);
  pen.drawImage(picture, 0, 0);
  pen.fillStyle = css("--soft");
  pen.font = `${size}px sans-serif`;
  pen.fillText(origin(), left, height + high - up);
}

/** Saves a drawing as SVG or as PNG. @param {string} name @param {Drawn} drawn @param {"svg" | "png"} kind */
export function print(name, drawn, kind) {
  const root = sheet(drawn), file = new Blob([new XMLSerializer().serializeToString(root)], { type: "image/svg+xml" });
  if (kind === "svg") return save(`${name}.svg`, file);
  const [, , wide, high] = (root.getAttribute("viewBox") ?? "").split(" ").map(Number), image = new Image();
  image.onload = () => {
    const canvas = h("canvas", { width: Math.round(DOTS * wide), height: Math.round(DOTS * high) });
    canvas.getContext("2d", { alpha: false })?.drawImage(image, 0, 0, canvas.width, canvas.height);
    URL.revokeObjectURL(image.src);
    canvas.toBlob((blob) => blob && save(`${name}.png`, blob));
  };
  image.src = URL.createObjectURL(file);
}

/**
 * The curves and axes of a chart.
 * @param {uPlot} plot
 * @param {string} unit of the vertical axis
 * @param {string[]} colours of the lines; a second world has the same
 * @param {((u: any) => void)[]} paints functions that fill rectangles of the chart
 */
export function plotted(plot, unit, colours, paints) {
  const { data, series, scales } = plot, high = plot.height + 60, low = high - BOTTOM;
  const along = (/** @type {string} */ scale, /** @type {number} */ from, /** @type {number} */ to) => {
    const { min = 0, max = 1, distr } = scales[scale], f = distr === 3 ? Math.log10 : Number;
    return (/** @type {number} */ value) => from + ((to - from) * (f(value) - f(min))) / (f(max) - f(min));
  };
  const x = along("x", LEFT, WIDE - RIGHT), [first, last] = [scales.x.min ?? 0, scales.x.max ?? 1];
  const root = s("svg", { viewBox: `0 0 ${WIDE} ${high}` }), [line, fill] = [css("--line"), css("--soft")];
  const ctx = { fillStyle: "", globalAlpha: 1, save: () => {}, restore: () => (ctx.globalAlpha = 1), fillRect: (/** @type {number[]} */ ...[at, y, width, height]) =>
    width > 0 && root.append(s("rect", { x: at, y, width, height, fill: ctx.fillStyle, opacity: ctx.globalAlpha })) };
  for (const paint of paints) paint({ ctx, bbox: { left: LEFT, top: TOP, width: WIDE - LEFT - RIGHT, height: low - TOP }, valToPos: x });
  for (const [value, text] of roundValues([first, last])) {
    root.append(s("line", { x1: x(value), x2: x(value), y1: TOP, y2: low, stroke: line }), s("text", { x: x(value), y: low + 13, fill, "text-anchor": "middle" }, text));
  }
  for (const axis of /** @type {any[]} */ (plot.axes.slice(1))) {
    const y = along(axis.scale, low, TOP);
    for (const [i, value] of (axis._splits ?? []).entries()) {
      if (!axis._values?.[i]) continue;
      root.append(s("line", { x1: LEFT, x2: WIDE - RIGHT, y1: y(value), y2: y(value), stroke: line }), s("text", { x: LEFT - 5, y: y(value) + 4, fill, "text-anchor": "end" }, axis._values[i]));
    }
  }
  series.slice(1).forEach(({ scale = "y", dash, width, alpha }, k) => {
    const y = along(scale, low, TOP), points = [];
    for (const [i, value] of (data[k + 1] ?? []).entries()) if (value != null && data[0][i] >= first && data[0][i] <= last) points.push(`${x(data[0][i]).toFixed(1)},${y(value).toFixed(1)}`);
    root.append(s("polyline", { points: points.join(" "), fill: "none", stroke: colours[k % colours.length], "stroke-width": width, "stroke-dasharray": dash?.join(" ") || null, opacity: alpha ?? 1, "data-line": k }));
  });
  root.append(s("text", { x: (LEFT + WIDE - RIGHT) / 2, y: high - 4, fill, "text-anchor": "middle" }, "tick"),
    s("text", { x: 12, y: (TOP + low) / 2, fill, "text-anchor": "middle", transform: `rotate(-90 12 ${(TOP + low) / 2})` }, unit));
  return root;
}
