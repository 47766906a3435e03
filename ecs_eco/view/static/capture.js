// Saves pictures of the scene for print, and videos as shown on the screen. Two worlds side by side are one picture.

import { gradient, rampOf } from "./colours.js";
import { $, h, s } from "./dom.js";
import { sign } from "./marks.js";
import { ACROSS, DOTS, caption, print } from "./print.js";
import { save, slug } from "./save.js";
import { css } from "./theme.js";

/** @typedef {import("./stage.js").Stage} Stage */

const [RATE, KIND] = [30, "video/webm"]; // frames per second

/**
 * Adds the buttons; returns a function that is called when the page has arrived. The scene's `onrender` must already be set.
 * @param {Stage} stage
 * @param {import("./protocol.js").Hello} hello
 * @param {() => void} ask requests the run as a page in one file
 */
export function capture(stage, hello, ask) {
  const name = () => `${slug(hello.world)}-tick-${stage.tick}`;
  /** @type {MediaRecorder | null} */
  let film = null;
  const sheet = h("canvas"), frame = h("canvas");
  const told = stage.onrender;
  const shoot = () => {
    paint(stage, sheet);
    caption(sheet, frame, stage.renderer.getPixelRatio());
  };
  stage.onrender = () => {
    told();
    if (film) shoot();
  };
  const still = h("button", { type: "button", text: "Picture", title: "Save a picture of the scene, with a legend", onclick: () => {
    const ratio = stage.renderer.getPixelRatio(), all = panes(stage);
    for (const pane of all) pane.resize((DOTS * ACROSS) / $("stage").clientWidth);
    render(stage);
    paint(stage, sheet);
    for (const pane of all) pane.resize(ratio);
    print(name(), { title: hello.title || hello.world, ...pictured(stage, sheet) }, "png");
  } });
  /** @type {Blob[]} */
  let parts = [];
  let ending = false;
  const finish = () => {
    if (parts.length) return film?.stop();
    shoot(); // nothing is encoded yet, and stopping now would leave an empty file
    requestAnimationFrame(finish);
  };
  const moving = h("button", { type: "button", "aria-pressed": "false", text: "Video", title: "Record a video of the scene; click again to save it", onclick: () => {
    if (film) {
      if (!ending) finish();
      ending = true;
      return;
    }
    render(stage);
    shoot();
    film = new MediaRecorder(frame.captureStream(RATE), { mimeType: KIND });
    [parts, ending] = [[], false];
    film.ondataavailable = ({ data }) => data.size && parts.push(data);
    film.onstop = () => {
      film = null;
      moving.setAttribute("aria-pressed", "false");
      save(`${name()}.webm`, new Blob(parts, { type: KIND }));
    };
    film.start(200);
    moving.setAttribute("aria-pressed", "true");
  } });
  const films = typeof MediaRecorder !== "undefined" && MediaRecorder.isTypeSupported(KIND);
  const page = h("button", { type: "button", text: "Page", title: "Save this run as a page: one file that opens without a server", onclick: () => {
    page.disabled = true;
    page.textContent = "Saving …";
    ask();
  } });
  $("cameras").append(h("div", { class: "segments small", role: "group", "aria-label": "Save the scene" }, still, films && moving, hello.saves ? page : null));
  return () => ((page.disabled = false), (page.textContent = "Page"));
}

/** The scene, and the scene of a second world next to it. @param {Stage} stage */
const panes = (stage) => (stage.peer ? [stage, stage.peer] : [stage]);

/** Draws a scene again, because its previous drawing has already been discarded. @param {Stage} stage */
const render = ({ renderer, scene, eye }) => renderer.render(scene, eye.camera);

/** A picture of the scene as a drawing with a scale and a legend. @param {Stage} stage @param {HTMLCanvasElement} sheet */
function pictured(stage, sheet) {
  const high = (ACROSS * sheet.height) / sheet.width, [bar, text] = $("scale").children, colour = $("colour");
  const wide = (bar.clientWidth * ACROSS) / $("stage").clientWidth;
  const body = s("svg", { viewBox: `0 0 ${ACROSS} ${high}` }, s("image", { width: ACROSS, height: high, href: sheet.toDataURL() }),
    s("rect", { x: 8, y: high - 26, width: wide + 8, height: 20, rx: 3, fill: css("--card"), opacity: 0.8 }),
    s("path", { d: `M12 ${high - 14}v4h${wide}v-4`, fill: "none", stroke: css("--ink") }), s("text", { x: 12 + wide / 2, y: high - 14, "text-anchor": "middle", fill: css("--ink") }, text.textContent));
  const rows = [...$("legend").querySelectorAll(".legend-row")], ranges = [...$("ramp").querySelectorAll("div")];
  const legend = stage.layers.map((layer, k) => ({ layer, k })).filter(({ layer }) => layer.shown && (layer.block.n || stage.peer)).map(({ layer: { kind }, k }) => {
    const [low, , high] = ranges.find(({ children }) => children[1].textContent === kind.name)?.children ?? [];
    const counts = [...rows[k].querySelectorAll("b")].map((count) => count.textContent).filter(Boolean).join(" and ");
    return { name: `${counts} ${kind.name}${low ? `: ${low.textContent} to ${high.textContent}` : ""}`, mark: sign(kind, stage.colours[k]) };
  });
  const change = stage.peer ? $("pairWhat").textContent ?? "" : "";
  if (colour.value === "species") return { body, legend, unit: change };
  const stops = gradient(rampOf(colour.value)).slice(21, -1).split(", ").map((stop) => stop.split(" ")[0]);
  const mark = s("svg", { viewBox: `0 0 ${stops.length} 8`, preserveAspectRatio: "none" }, ...stops.map((fill, x) => s("rect", { x, width: 1, height: 8, fill })));
  return { body, unit: [change, `colored by ${colour.selectedOptions[0].text}`].filter(Boolean).join(", "), legend: [...legend, { name: "low to high", mark }] };
}

/**
 * Copies the sky, the scenes and their overlays. Called right after the first scene is drawn.
 * @param {Stage} stage
 * @param {HTMLCanvasElement} sheet
 */
function paint(stage, sheet) {
  const whole = $("stage"), ratio = stage.renderer.getPixelRatio(), [width, height] = [whole.clientWidth, whole.clientHeight].map((side) => Math.round(side * ratio));
  if (sheet.width !== width || sheet.height !== height) [sheet.width, sheet.height] = [width, height];
  const pen = sheet.getContext("2d", { alpha: false });
  if (!pen) return;
  const sky = pen.createLinearGradient(0, 0, 0, height), root = getComputedStyle(whole);
  ["high", "low"].forEach((end, i) => sky.addColorStop(i, root.getPropertyValue(`--sky-${end}`).trim() || css(`--sky-day-${end}`)));
  pen.fillStyle = sky;
  pen.fillRect(0, 0, width, height);
  for (const pane of panes(stage)) {
    const { canvas, over } = pane, [x, y, wide, high] = [canvas.offsetLeft, canvas.offsetTop, canvas.clientWidth, canvas.clientHeight].map((side) => side * ratio);
    if (pane !== stage) render(pane);
    pen.globalAlpha = Number(getComputedStyle(canvas).opacity);
    for (const layer of [canvas, over.canvas]) if (layer.width) pen.drawImage(layer, x, y, wide, high);
  }
  pen.globalAlpha = 1;
  for (const name of whole.querySelectorAll(".pane-name")) sticker(pen, name, whole.getBoundingClientRect(), ratio);
}

/** Copies the name of a pane. @param {CanvasRenderingContext2D} pen @param {Element} name @param {DOMRect} from @param {number} ratio */
function sticker(pen, name, from, ratio) {
  const { left, top, width, height } = name.getBoundingClientRect(), { backgroundColor, color, fontSize } = getComputedStyle(name);
  const [x, y, wide, high] = [left - from.left, top - from.top, width, height].map((side) => side * ratio);
  pen.fillStyle = backgroundColor;
  pen.beginPath();
  pen.roundRect(x, y, wide, high, high / 2);
  pen.fill();
  pen.fillStyle = color;
  Object.assign(pen, { font: `600 ${ratio * parseFloat(fontSize)}px sans-serif`, textAlign: "center", textBaseline: "middle" });
  pen.fillText(name.textContent ?? "", x + wide / 2, y + high / 2, wide);
}
