// When to draw: scenes at each browser frame, charts a few times per second. If drawing is slow, scenes are drawn at most half of the time,
// because otherwise the browser would have no time left for clicks and messages.

const SLOW = 80; // [ms] if a frame takes longer, a pause of the same length follows
const LONGEST = 1000; // [ms] maximum pause
const CHARTS = 100; // [ms] between drawings of charts

/** @type {Set<(now: number) => boolean>} */
const scenes = new Set();
/** @type {Set<() => void>} functions to call once */
const waiting = new Set();
let asked = 0;
let drawn = 0;
let running = false;

/**
 * Calls `draw`, which returns whether it has drawn, at each frame until the returned function is called.
 * @param {(now: number) => boolean} draw [ms]
 */
export function onFrames(draw) {
  scenes.add(draw);
  start();
  return () => scenes.delete(draw);
}

/** Calls a function once at an upcoming frame, however often it was requested. @param {() => void} draw */
export function soon(draw) {
  waiting.add(draw);
  start();
}

function start() {
  if (running) return;
  running = true;
  ask();
}

function ask() {
  asked = performance.now();
  requestAnimationFrame(frame);
}

/** @param {number} now [ms] */
function frame(now) {
  const late = performance.now() - asked;
  let busy = false;
  for (const draw of scenes) busy = draw(now) || busy;
  if (waiting.size && now - drawn >= CHARTS) {
    const works = [...waiting];
    waiting.clear();
    drawn = now;
    busy = true;
    for (const draw of works) draw();
  }
  if (!scenes.size && !waiting.size) running = false;
  else if (busy && late > SLOW) setTimeout(ask, Math.min(late, LONGEST));
  else ask();
}
