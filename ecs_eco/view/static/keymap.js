// Keys and their functions.

import { $ } from "./dom.js";
import { switchTheme } from "./theme.js";

/**
 * @param {{page: () => {stage: import("./stage.js").Stage, act: import("./act.js").Act | null} | null, time: import("./transport.js").Transport,
 *   look: (preset: "top" | "side" | "follow") => void, next: (by: number) => void, select: (uid: number | null) => void,
 *   open: (name: import("./tabs.js").PanelName) => void, share: () => void, colour: () => void, whatif: () => void, stop: () => void}} calls
 */
export function keymap(calls) {
  const { page, time } = calls;
  const slot = () => Number($("speed").value);
  const eye = () => page()?.stage.eye;
  /** @type {import("./keys.js").Key[]} */
  const keys = [
    { keys: [" "], shown: "space", about: "play or pause", does: () => time.play() },
    { keys: [".", ">"], shown: ".", about: "one tick; with shift, ten", does: (event) => time.step(event.shiftKey ? 10 : 1) },
    { keys: [","], shown: ",", about: "one tick back", does: () => time.back() },
    { keys: ["-", "_"], shown: "−", about: "slower", does: () => time.speed(slot() - 1) },
    { keys: ["+", "="], shown: "+", about: "faster", does: () => time.speed(slot() + 1) },
    { keys: ["z"], shown: "Z", about: "a shorter period; with shift, a longer one", does: () => time.zoom(1) },
    { keys: ["0"], shown: "0", about: "the whole period", does: () => time.whole() },
    { keys: ["r"], shown: "R", about: "repeat the displayed period", does: () => time.loop() },
    { keys: ["1"], shown: "1", about: "look from above", does: () => calls.look("top") },
    { keys: ["2"], shown: "2", about: "look from the side", does: () => calls.look("side") },
    { keys: ["3", "f"], shown: "3 F", about: "follow the selected organism", does: () => calls.look("follow") },
    { keys: ["n"], shown: "N", about: "select the next organism", does: () => calls.next(1) },
    { keys: ["N", "p"], shown: "P", about: "select the previous organism", does: () => calls.next(-1) },
    { keys: ["Escape"], shown: "Esc", about: "deselect; stop placing; stop the story", does: () => (calls.stop(), page()?.act?.aiming ? page()?.act?.aim(false) : calls.select(null)) },
    { keys: ["c"], shown: "C", about: "next color mode", does: calls.colour },
    { keys: ["g"], shown: "G", about: "charts", does: () => calls.open("charts") },
    { keys: ["b"], shown: "B", about: "about this world: its description and food web", does: () => calls.open("world") },
    { keys: ["w"], shown: "W", about: "what happened, and why", does: () => calls.open("why") },
    { keys: ["o"], shown: "O", about: "the organism", does: () => calls.open("organism") },
    { keys: ["l"], shown: "L", about: "table of all organisms", does: () => calls.open("all") },
    { keys: ["k"], shown: "K", about: "copy a link to this view", does: calls.share },
    { keys: ["y"], shown: "Y", about: "what if: compare with a changed copy of the world", does: calls.whatif },
    { keys: ["a"], shown: "A", about: "act", does: () => page()?.act && calls.open("act") },
    { keys: ["t"], shown: "T", about: "dark or light", does: switchTheme },
    { keys: ["ArrowLeft"], shown: "← → ↑ ↓", about: "move; with shift, turn and tilt", does: (event) => (event.shiftKey ? eye()?.nudge(0, 0, -0.12) : eye()?.nudge(-0.06, 0)) },
    { keys: ["PageUp", "i"], shown: "I PgUp", about: "zoom in", does: () => eye()?.nudge(0, 0, 0, 0.85) },
    { keys: ["PageDown", "u"], shown: "U PgDn", about: "zoom out", does: () => eye()?.nudge(0, 0, 0, 1.18) },
    { keys: ["Home"], shown: "Home", about: "the whole world", does: () => calls.look(eye()?.preset === "top" ? "top" : "side") },
    { keys: ["?"], shown: "?", about: "this help", does: () => $("help").showModal() },
  ];
  const moves = [
    { keys: ["Z"], shown: "", about: "", does: () => time.zoom(-1) },
    { keys: ["ArrowRight"], shown: "", about: "", does: (/** @type {KeyboardEvent} */ event) => (event.shiftKey ? eye()?.nudge(0, 0, 0.12) : eye()?.nudge(0.06, 0)) },
    { keys: ["ArrowUp"], shown: "", about: "", does: (/** @type {KeyboardEvent} */ event) => (event.shiftKey ? eye()?.nudge(0, 0, 0, 1, 0.1) : eye()?.nudge(0, 0.06)) },
    { keys: ["ArrowDown"], shown: "", about: "", does: (/** @type {KeyboardEvent} */ event) => (event.shiftKey ? eye()?.nudge(0, 0, 0, 1, -0.1) : eye()?.nudge(0, -0.06)) },
  ];
  return [...keys, ...moves];
}
