// Data about the page for tests, as window.ecs; see docs/reference/viewer_protocol.md.

import { $ } from "./dom.js";

/**
 * @param {{page: () => {stage: import("./stage.js").Stage, act: import("./act.js").Act | null, hello: import("./protocol.js").Hello} | null,
 *   state: () => import("./protocol.js").State | null, connection: import("./connection.js").Connection, two: {stage: import("./stage.js").Stage | null}, chosen: import("./chosen.js").Chosen}} of
 */
export function count(of) {
  const stage = () => of.page()?.stage;
  const layers = () => stage()?.layers ?? [];
  window.ecs = {
    get frames() { return stage()?.frames ?? 0; },
    get tick() { return stage()?.tick ?? 0; },
    get counts() { return Object.fromEntries(layers().map((layer) => [layer.kind.name, layer.block.n])); },
    get decodeMs() { return stage()?.decodeMs ?? 0; },
    get renderMs() { return stage()?.renderMs ?? 0; },
    get renders() { return stage()?.renders ?? 0; },
    get selected() { return of.chosen.uid; },
    get mode() { return of.page()?.hello.mode ?? ""; },
    get playing() { return of.state()?.playing ?? false; },
    get still() { return Boolean(stage()?.still && of.state()?.tick === stage()?.tick); },
    get connected() { return $("link").dataset.link === "open"; },
    get ended() { return $("link").dataset.link === "ended"; },
    get refused() { return $("link").dataset.link === "refused"; },
    get messages() { return of.connection.counts; },
    get acts() { return of.page()?.act?.sent ?? 0; },
    uids: (kind, most = 100) => uids(stage(), kind, most),
    place(uid) {
      return stage()?.place(uid)?.toArray() ?? null;
    },
    screen: (uid) => screen(stage(), uid),
    get over() {
      const over = stage()?.over;
      const marks = Object.fromEntries(["birth", "death", "kill"].map((kind) => [kind, over?.marks.filter((mark) => mark.kind === kind).length ?? 0]));
      return { ...(over?.drew ?? { seen: 0, rays: 0, drawn: 0 }), marks };
    },
    get second() {
      const { stage } = of.two;
      return stage && {
        tick: stage.tick, frames: stage.frames, still: stage.still, counts: Object.fromEntries(stage.layers.map((layer) => [layer.kind.name, layer.block.n])),
        camera: stage.eye.camera.position.toArray(), chosen: of.chosen.second, ring: stage.selected,
        uids: (/** @type {string} */ kind, /** @type {number} */ most = 100) => uids(stage, kind, most),
        screen: (/** @type {number} */ uid) => screen(stage, uid),
      };
    },
    get camera() { return stage()?.eye.camera.position.toArray() ?? []; },
    corners() {
      const box = $("canvas").getBoundingClientRect();
      return (stage()?.corners() ?? []).map(({ x, y }) => [x + box.left, y + box.top]);
    },
  };
}

/** @param {import("./stage.js").Stage | undefined} stage @param {string} kind @param {number} most */
function uids(stage, kind, most) {
  const layer = stage?.layers.find((one) => one.kind.name === kind);
  return layer ? Array.from({ length: Math.min(most, layer.block.n) }, (_, row) => layer.uid(row)) : [];
}

/** @param {import("./stage.js").Stage | undefined} stage @param {number} uid */
function screen(stage, uid) {
  const place = stage?.place(uid);
  const at = place && stage?.project(place);
  const box = stage?.canvas.getBoundingClientRect();
  return at && box ? { x: at.x + box.left, y: at.y + box.top } : null;
}
