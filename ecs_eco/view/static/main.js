// The page: ties the connection to scene, charts, timeline and panels.

import { Act } from "./act.js";
import { All } from "./all.js";
import { Charts } from "./charts.js";
import { Connection } from "./connection.js";
import { count } from "./counters.js";
import { cameFrom, taken } from "./credential.js";
import { $, announce, h, number } from "./dom.js";
import { BACK, PAUSE, PLAY, STEP } from "./icons.js";
import { help, listen } from "./keys.js";
import { keymap } from "./keymap.js";
import { legend } from "./legend.js";
import { copy, lookFrom, read, shown, written } from "./link.js";
import * as overlay from "./overlay.js";
import { fields } from "./fields.js";
import { Panel } from "./panel.js";
import { anyOf, beside } from "./next.js";
import { point } from "./pointer.js";
import { showSpeed, speedAt } from "./speed.js";
import { Stage } from "./stage.js";
import { Story } from "./story.js";
import { splitter } from "./splitter.js";
import { PANELS, listenTabs, openPanel, opened } from "./tabs.js";
import { onTheme, recallTheme, switchTheme } from "./theme.js";
import { Timeline } from "./timeline.js";
import { hints, world } from "./world.js";

/** @typedef {import("./protocol.js").Hello} Hello @typedef {import("./protocol.js").State} State */

const connection = new Connection();
/** @type {{stage: Stage, charts: Charts, panel: Panel, timeline: Timeline, story: Story, all: All, act: Act | null, hello: Hello} | null} */
let page = null;
/** @type {State | null} */
let state = null;
let own = false; // whether kinds have the colours of the world file
let by = "species";
/** @type {ReturnType<typeof legend> | null} */
let kinds = null;
/** @type {ReturnType<typeof fields> | null} */
let field = null;
let wanted = read(location.hash); // what the address asks for, until the world has said where it is

// ---- what the server says

connection.on("hello", (hello) => {
  if (page) { // after a reconnection the world may be another one: begin anew
    if (JSON.stringify([page.hello.world, page.hello.size, page.hello.species]) !== JSON.stringify([hello.world, hello.size, hello.species])) return location.reload();
    page.stage.jump = true;
    field?.again();
    if (by !== "species") connection.send({ kind: "colour", by });
    if (page.stage.selected !== null) connection.send({ kind: "select", uid: page.stage.selected });
    return;
  }
  begin(hello);
});
connection.on("state", show);
connection.on("series", (series) => {
  page?.charts.add(series);
  page?.timeline.draw();
  kinds?.look();
});
connection.on("marks", (marks) => {
  page?.timeline.mark(marks);
  page?.story.mark(marks.interventions ?? []);
  page?.stage.ground.fence(marks.fences ?? []);
  page?.stage.ground.use(marks.roads ?? [], marks.areas ?? []);
});
connection.on("story", ({ entries }) => [page?.story.add(entries), page?.timeline.tell(entries)]);
connection.on("why", (why) => page?.story.show(why));
connection.on("fates", ({ list }) => page?.stage.over.fates(list));
connection.on("field", (message) => field?.take(message));
connection.on("scatter", (scatter) => page?.charts.figures.scatter.show(scatter));
connection.on("table", (table) => page?.all.show(table));
connection.on("params", ({ list }) => page?.act?.offer(list));
connection.on("organism", (organism) => {
  if (organism.uid !== page?.stage.selected) return;
  page.panel.show(organism);
  page.stage.over.organism = organism;
  page.stage.dirty = true;
  eyes();
});
connection.on("said", (said) => {
  page?.act?.note(said);
  if (said.field === "select") page?.panel.refuse(said.text);
  if (said.field === "why") page?.story.refuse();
  if (said.field === "table") page?.all.refuse(said.text);
  if (said.field === "scatter") return page?.charts.figures.scatter.refuse();
  announce(said.text);
  if (said.field !== "select" && $("act").hidden) flash(said.text);
});
connection.onframe = (buffer) => (page ? page.stage.take(buffer) : 0);
connection.onlink = (link) => overlay.linked(link, connection);

/** @param {Hello} hello */
function begin(hello) {
  document.title = `${hello.title || hello.world} · ecs-eco`;
  $("title").textContent = hello.title || hello.world;
  $("mode").hidden = false;
  $("mode").textContent = hello.mode;
  const map = cameFrom();
  if (map) $("mode").before(h("a", { class: "chip", href: map, text: "← map" }));
  const stage = new Stage($("canvas"), hello);
  const colourOf = (/** @type {string} */ name) => stage.colours[stage.kinds.findIndex((kind) => kind.name === name)] ?? "#888888";
  const charts = new Charts(hello, colourOf, (tick) => connection.send({ kind: "seek", tick }),
    { layers: () => stage.layers, scales: () => state?.scales ?? {}, by: () => by, colours: hello.colours.filter((name) => name !== "family"), colour, select, ask: (x, y) => connection.send({ kind: "scatter", x, y }) });
  const panel = new Panel(hello, { select, fill: (uid) => connection.send({ kind: "fill", uid }), follow: () => look("follow"), track: (uid) => colour(`kin:${uid}`), colourOf });
  const timeline = new Timeline(hello, (tick) => connection.send({ kind: "seek", tick }), charts.lanes());
  const story = new Story(hello, { jump, colourOf, ask: () => connection.send({ kind: "why" }), tell: (entry) =>
    flash(`${entry.text}.`, { text: "Why?", does: () => open("why") }) });
  const act = hello.acts ? new Act(hello, {
    send: (what) => connection.send({ kind: "act", what }),
    aim: (on) => $("canvas").classList.toggle("aim", on),
    now: () => stage.tick,
    selected: () => (panel.organism?.alive ? panel.organism : null),
  }) : null;
  $("tab-act").hidden = !act;
  const all = new All(hello, { ask: (request) => connection.send({ kind: "table", ...request }), select });
  page = { stage, charts, panel, timeline, story, all, act, hello };
  stage.eye.cover = overlay.covered;
  stage.onrender = () => {
    overlay.follow(stage);
    kinds?.count();
    if (hello.mode === "replay") kinds?.look();
    $("tick").textContent = number(stage.tick);
    timeline.at(stage.tick);
    charts.at(stage.tick);
    story.at(stage.tick);
    all.time(stage.tick);
    overlay.descendants(stage, by);
  };
  field = fields(stage, (name) => connection.send({ kind: "field", name }));
  stage.onlight = () => overlay.sky(stage);
  onTheme((dark) => paint(dark));
  $("colour").replaceChildren(...hello.colours.map((name) => h("option", { value: name, text: name.replace("gene:", "gene ") })));
  look("side", false);
  if (act) connection.send({ kind: "params" });
}

/** @param {boolean} dark */
function paint(dark) {
  if (!page) return;
  page.stage.theme(dark, own);
  const { stage, charts, story } = page;
  kinds = legend(stage, {
    own, find, onshow: (name, shown) => charts.show(name, shown),
    onown: (chosen) => {
      own = chosen;
      paint(stage.dark);
    },
    brief: (name) => ({ ...charts.brief(name), extinct: story.extinct(name) }),
  });
  page.charts.rebuild();
  page.panel.redraw();
  world(page.hello, charts.colourOf);
}

/** @param {State} now */
function show(now) {
  const changed = state?.playing !== now.playing;
  state = now;
  if (changed) {
    $("play").innerHTML = now.playing ? PAUSE : PLAY;
    $("play").setAttribute("aria-label", now.playing ? "Pause" : "Play");
  }
  const over = now.done && page?.hello.mode === "live";
  $("step").disabled = now.done;
  $("back").disabled = now.tick <= (page?.hello.first ?? 0) || (page?.hello.mode === "live" && !page.hello.rewinds);
  $("play").disabled = over;
  $("rate").textContent = over ? "done" : now.done ? "the end" : now.playing ? `${number(now.rate, 2)} ticks/s` : "paused";
  showSpeed(now.speed);
  if (page) overlay.ramp(by, now.scales);
  page?.charts.figures.at();
  if (over) overlay.notice("The run has ended.");
  if (wanted) apply(wanted);
  wanted = null;
}

// ---- what people do

/** @param {number} slot */
const speed = (slot) => connection.send({ kind: "speed", value: speedAt(slot) });

/** Plays or pauses; at the end of a recorded run plays it again from its beginning. */
function play() {
  if (state?.done && page?.hello.mode === "replay") connection.send({ kind: "seek", tick: page.hello.first });
  connection.send({ kind: state?.playing ? "pause" : "play" });
  did("pause");
}

/** @param {number} ticks */
function step(ticks) {
  connection.send({ kind: "step", ticks });
}

/** One tick back, where time can be chosen. */
function back() {
  if (!page || (page.hello.mode === "live" && !page.hello.rewinds)) return;
  if (state?.playing) connection.send({ kind: "pause" });
  connection.send({ kind: "seek", tick: Math.max(page.hello.first, (state?.tick ?? page.stage.tick) - 1) });
}

/** @param {number | null} uid */
function select(uid) {
  if (!page) return;
  page.stage.select(uid);
  page.panel.expect(uid);
  page.act?.selected(uid !== null);
  page.all.selected = uid;
  connection.send({ kind: "select", uid });
  eyes();
  if (uid !== null) {
    did("select");
    open("organism");
    announce(`Selected number ${uid}`);
  } else if (page.stage.eye.preset === "follow") look("side");
}

/** Selects the next or the one before, animals first. @param {number} by */
const next = (by) => selectFound(page && beside(page.stage, by));

/** Selects one of a kind, and goes there. @param {string} name */
function find(name) {
  if (selectFound(page && anyOf(page.stage, name))) look("follow");
}

/** @param {number | null} uid */
function selectFound(uid) {
  if (uid !== null) select(uid);
  return uid !== null;
}

/** @param {"top" | "side" | "follow"} preset @param {boolean} [fly] */
function look(preset, fly = true) {
  if (!page || (preset === "follow" && !followable())) return;
  if (preset === "follow") page.stage.eye.followed = page.stage.place(/** @type {number} */ (page.stage.selected));
  page.stage.eye.look(preset, fly);
  page.stage.dirty = true;
  eyes();
}

/** Whether the selected one is there to be followed. */
const followable = () => page?.stage.selected != null && page.panel.organism?.alive !== false && page.stage.place(page.stage.selected) !== null;

function eyes() {
  for (const button of document.querySelectorAll("[data-eye]")) {
    const preset = /** @type {HTMLButtonElement} */ (button).dataset.eye;
    button.setAttribute("aria-pressed", String(preset === page?.stage.eye.preset));
    if (preset === "follow") /** @type {HTMLButtonElement} */ (button).disabled = !followable();
  }
}

/** @param {string} name of a colouring */
function colour(name) {
  by = name;
  const tracked = $("colour").querySelector("[value^='kin:']") ?? (name.startsWith("kin:") ? $("colour").appendChild(h("option")) : null);
  if (name.startsWith("kin:")) Object.assign(tracked, { value: name, textContent: `descendants of #${name.slice(4)}` });
  $("colour").value = name;
  page?.stage.colourBy(name);
  page?.charts.figures.draw();
  overlay.ramp(name);
  connection.send({ kind: "colour", by: name });
}

/** To where something happened: in time, where time can be chosen, else in the charts. @param {import("./protocol.js").Entry} entry */
function jump(entry) {
  if (page?.hello.mode === "replay") connection.send({ kind: "seek", tick: Math.min(entry.tick, page.hello.last ?? entry.tick) });
  else {
    open("charts");
    page?.charts.point(entry.tick);
  }
}

/** @param {import("./tabs.js").PanelName} name of a panel */
function open(name) {
  openPanel(name);
  if (name !== "act") page?.act?.aim(false);
  if (name === "why") did("why"), page?.story.open();
  if (name === "all") page?.all.again();
}

/** Shows what a link asks for. @param {import("./link.js").Sight} sight */
function apply({ tick, eye, uid, tab, colour: by, field: name }) {
  if (!page || !state) return;
  const { hello, stage } = page;
  if (tick !== undefined && (hello.mode === "replay" || (hello.rewinds && tick < state.tick))) {
    connection.send({ kind: "pause" });
    connection.send({ kind: "seek", tick });
  } else if (tick !== undefined && tick > state.tick) flash(`This world has not come to tick ${number(tick)} yet.`);
  if (by && (hello.colours.includes(by) || by.startsWith("kin:"))) colour(by);
  if (uid !== undefined) select(uid);
  const panel = PANELS.find((one) => one === tab && !$(`tab-${one}`).hidden);
  if (panel) open(panel);
  if (eye) lookFrom(stage, eye);
  if (name) field?.choose(name);
}

/** A link to what is shown now. */
const share = () => page && copy(written(shown(page.stage, opened(), by))).then((words) => flash(`${words}.`));

let flashing = 0;

/** @param {string} text @param {{text: string, does: () => void}} [button] */
function flash(text, button) {
  overlay.notice(text, button);
  clearTimeout(flashing);
  flashing = setTimeout(() => overlay.notice(null), 6000);
}

// ---- buttons and keys

const did = hints();
recallTheme();
splitter();
onTheme(() => {});
$("play").innerHTML = PLAY;
$("step").innerHTML = STEP;
$("back").innerHTML = BACK;
$("back").addEventListener("click", back);
$("play").addEventListener("click", play);
$("step").addEventListener("click", () => step(1));
$("speed").addEventListener("input", () => speed(Number($("speed").value)));
$("theme").addEventListener("click", switchTheme);
$("colour").addEventListener("change", () => colour($("colour").value));
for (const button of document.querySelectorAll("[data-eye]")) {
  button.addEventListener("click", () => look(/** @type {"top"} */ (/** @type {HTMLElement} */ (button).dataset.eye)));
}
listenTabs(open);
$("share").addEventListener("click", share);

const keys = keymap({
  page: () => page, play, step, back, speed, look, next, select, open, share,
  colour: () => {
    const all = page?.hello.colours ?? ["species"];
    colour(all[(all.indexOf(by) + 1) % all.length]);
  },
});
listen(keys);
help(keys.filter(({ about }) => about));
$("helpOpen").addEventListener("click", () => $("help").showModal());

point($("canvas"), { page: () => page, select });
count({ page: () => page, state: () => state, connection });
window.addEventListener("hashchange", () => { // somebody put another address into this tab
  if (connection.socket === null) connection.again();
  else taken(); // it is in already
  const asked = read(location.hash);
  if (asked && state) apply(asked);
});
connection.open();
