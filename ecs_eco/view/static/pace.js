// When things are drawn: scenes at each frame of the browser, charts a few times a second; and where drawing is slow (without a graphics card, or with
// two worlds in sight) only half of the time. A browser that is asked for the next picture while it still works on the last one has no time for clicks
// and messages.

const SLOW = 80; // [ms] from asking for a frame to having one, beyond which as long a pause follows
const LONGEST = 1000; // [ms] a pause
const CHARTS = 100; // [ms] from one drawing of charts to the next

/** @type {Set<(now: number) => boolean>} */
const scenes = new Set();
/** @type {Set<() => void>} what is to be drawn once */
const waiting = new Set();
let asked = 0;
let drawn = 0;
let running = false;

/**
 * Calls a function at each frame, until the function returned is called. It says whether it has drawn.
 * @param {(now: number) => boolean} draw [ms]
 */
export function onFrames(draw) {
  scenes.add(draw);
  start();
  return () => scenes.delete(draw);
}

/** Calls a function once at one of the next frames, however often it is asked for. @param {() => void} draw */
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
