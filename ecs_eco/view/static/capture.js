// Saves pictures of the scene for print, and videos as shown on the screen.

import { gradient, rampOf } from "./colours.js";
import { $, h, s } from "./dom.js";
import { sign } from "./marks.js";
import { ACROSS, DOTS, print } from "./print.js";
import { save, slug } from "./save.js";
import { css } from "./theme.js";

const [RATE, KIND] = [30, "video/webm"]; // frames per second

/**
 * Adds the buttons; returns a function that is called when the page has arrived. The scene's `onrender` must already be set.
 * @param {import("./stage.js").Stage} stage
 * @param {import("./protocol.js").Hello} hello
 * @param {() => void} ask requests the run as a page in one file
 */
export function capture(stage, hello, ask) {
  const name = () => `${slug(hello.world)}-tick-${stage.tick}`;
  /** @type {MediaRecorder | null} */
  let film = null;
  const sheet = h("canvas");
  const told = stage.onrender;
  stage.onrender = () => {
    told();
    if (film) paint(stage, sheet);
  };
  const still = h("button", { type: "button", text: "Picture", title: "Save a picture of the scene, with a legend", onclick: () => {
    const ratio = stage.renderer.getPixelRatio();
    stage.resize((DOTS * ACROSS) / stage.canvas.clientWidth);
    stage.renderer.render(stage.scene, stage.eye.camera); // the previous drawing has already been discarded
    paint(stage, sheet);
    stage.resize(ratio);
    print(name(), { title: hello.title || hello.world, ...pictured(stage, sheet) }, "png");
  } });
  /** @type {Blob[]} */
  let parts = [];
  let ending = false;
  const finish = () => {
    if (parts.length) return film?.stop();
    paint(stage, sheet); // nothing is encoded yet, and stopping now would leave an empty file
    requestAnimationFrame(finish);
  };
  const moving = h("button", { type: "button", "aria-pressed": "false", text: "Video", title: "Record a video of the scene; click again to save it", onclick: () => {
    if (film) {
      if (!ending) finish();
      ending = true;
      return;
    }
    stage.renderer.render(stage.scene, stage.eye.camera);
    paint(stage, sheet);
    film = new MediaRecorder(sheet.captureStream(RATE), { mimeType: KIND });
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

/** A picture of the scene as a drawing with a scale and a legend. @param {import("./stage.js").Stage} stage @param {HTMLCanvasElement} sheet */
function pictured(stage, sheet) {
  const high = (ACROSS * sheet.height) / sheet.width, [bar, text] = $("scale").children, colour = $("colour");
  const wide = (bar.clientWidth * ACROSS) / stage.canvas.clientWidth;
  const body = s("svg", { viewBox: `0 0 ${ACROSS} ${high}` }, s("image", { width: ACROSS, height: high, href: sheet.toDataURL() }),
    s("rect", { x: 8, y: high - 26, width: wide + 8, height: 20, rx: 3, fill: css("--card"), opacity: 0.8 }),
    s("path", { d: `M12 ${high - 14}v4h${wide}v-4`, fill: "none", stroke: css("--ink") }), s("text", { x: 12 + wide / 2, y: high - 14, "text-anchor": "middle", fill: css("--ink") }, text.textContent));
  const counts = $("legend").querySelectorAll(".legend-row b:not(.other)"), ranges = [...$("ramp").querySelectorAll("div")];
  const legend = stage.layers.map((layer, k) => ({ layer, k })).filter(({ layer }) => layer.shown && layer.block.n).map(({ layer: { kind }, k }) => {
    const [low, , high] = ranges.find(({ children }) => children[1].textContent === kind.name)?.children ?? [];
    return { name: `${counts[k].textContent} ${kind.name}${low ? `: ${low.textContent} to ${high.textContent}` : ""}`, mark: sign(kind, stage.colours[k]) };
  });
  if (colour.value === "species") return { body, legend };
  const stops = gradient(rampOf(colour.value)).slice(21, -1).split(", ").map((stop) => stop.split(" ")[0]);
  const mark = s("svg", { viewBox: `0 0 ${stops.length} 8`, preserveAspectRatio: "none" }, ...stops.map((fill, x) => s("rect", { x, width: 1, height: 8, fill })));
  return { body, unit: `colored by ${colour.selectedOptions[0].text}`, legend: [...legend, { name: "low to high", mark }] };
}

/**
 * Copies the sky, the scene and its overlay. Called right after the scene is drawn.
 * @param {import("./stage.js").Stage} stage
 * @param {HTMLCanvasElement} sheet
 */
function paint(stage, sheet) {
  const { width, height } = stage.canvas;
  if (sheet.width !== width || sheet.height !== height) [sheet.width, sheet.height] = [width, height];
  const pen = sheet.getContext("2d");
  if (!pen) return;
  const sky = pen.createLinearGradient(0, 0, 0, height), root = getComputedStyle($("stage"));
  ["high", "low"].forEach((end, i) => sky.addColorStop(i, root.getPropertyValue(`--sky-${end}`).trim() || css(`--sky-day-${end}`)));
  pen.fillStyle = sky;
  pen.fillRect(0, 0, width, height);
  for (const layer of [stage.canvas, /** @type {HTMLCanvasElement} */ ($("over"))]) if (layer.width) pen.drawImage(layer, 0, 0, width, height);
}
