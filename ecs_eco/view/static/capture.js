// Saves pictures and videos of the scene, as shown on the screen, to files.

import { $, h } from "./dom.js";
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
  const still = h("button", { type: "button", text: "Picture", title: "Save a picture of the scene", onclick: () => {
    stage.renderer.render(stage.scene, stage.eye.camera); // the previous drawing has already been discarded
    paint(stage, sheet);
    sheet.toBlob((blob) => blob && save(`${name()}.png`, blob));
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
