// What tests read of the page, as window.ecs; see docs/reference/watching_page.md.

import { $ } from "./dom.js";

/**
 * @param {{page: () => {stage: import("./stage.js").Stage, act: import("./act.js").Act | null, hello: import("./protocol.js").Hello} | null,
 *   state: () => import("./protocol.js").State | null, connection: import("./connection.js").Connection}} of
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
    get selected() { return stage()?.selected ?? null; },
    get mode() { return of.page()?.hello.mode ?? ""; },
    get playing() { return of.state()?.playing ?? false; },
    get still() { return Boolean(stage()?.still && of.state()?.tick === stage()?.tick); },
    get connected() { return $("link").dataset.link === "open"; },
    get ended() { return $("link").dataset.link === "ended"; },
    get refused() { return $("link").dataset.link === "refused"; },
    get messages() { return of.connection.counts; },
    get acts() { return of.page()?.act?.sent ?? 0; },
    uids(kind, most = 100) {
      const layer = layers().find((one) => one.kind.name === kind);
      return layer ? Array.from({ length: Math.min(most, layer.block.n) }, (_, row) => layer.uid(row)) : [];
    },
    place(uid) {
      return stage()?.place(uid)?.toArray() ?? null;
    },
    screen(uid) {
      const place = stage()?.place(uid);
      const at = place && stage()?.project(place);
      const box = $("canvas").getBoundingClientRect();
      return at ? { x: at.x + box.left, y: at.y + box.top } : null;
    },
    get over() {
      const over = stage()?.over;
      const marks = Object.fromEntries(["birth", "death", "kill"].map((kind) => [kind, over?.marks.filter((mark) => mark.kind === kind).length ?? 0]));
      return { ...(over?.drew ?? { seen: 0, rays: 0, drawn: 0 }), marks };
    },
    corners() {
      const box = $("canvas").getBoundingClientRect();
      return (stage()?.corners() ?? []).map(({ x, y }) => [x + box.left, y + box.top]);
    },
  };
}
