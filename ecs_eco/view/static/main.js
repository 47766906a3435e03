// The page: connects the server to the scene, charts, timeline and panels.

import { Act } from "./act.js";
import { All } from "./all.js";
import { Charts } from "./charts.js";
import { cladeOf } from "./colours.js";
import { Connection } from "./connection.js";
import { count } from "./counters.js";
import { cameFrom, taken } from "./credential.js";
import { $, announce, h, number } from "./dom.js";
import { help, listen } from "./keys.js";
import { keymap } from "./keymap.js";
import { legend } from "./legend.js";
import { copy, keep, kept, lookFrom, read, shown, written } from "./link.js";
import { capture } from "./capture.js";
import { Chosen } from "./chosen.js";
import { classroom } from "./classroom.js";
import { Loop } from "./loop.js";
import * as overlay from "./overlay.js";
import { soon } from "./pace.js";
import { fields } from "./fields.js";
import { pair } from "./pair.js";
import { Panel } from "./panel.js";
import { anyOf, beside } from "./next.js";
import { originates } from "./print.js";
import { another, anew, identity, picker } from "./picker.js";
import { point } from "./pointer.js";
import { save } from "./save.js";
import { Stage } from "./stage.js";
import { Story } from "./story.js";
import { splitter } from "./splitter.js";
import { OwnPanels } from "./own.js";
import { PANELS, arrange, listenTabs, openPanel, opened } from "./tabs.js";
import { onTheme, recallTheme, switchTheme } from "./theme.js";
import { Timeline } from "./timeline.js";
import { Tour } from "./tour.js";
import { Transport } from "./transport.js";
import { WhatIf } from "./whatif.js";
import { hints, meals, world } from "./world.js";

/** @typedef {import("./protocol.js").Hello} Hello @typedef {import("./protocol.js").State} State */

const connection = new Connection();
/** @type {{stage: Stage, charts: Charts, panel: Panel, timeline: Timeline, loop: Loop, story: Story, all: All, act: Act | null, own: OwnPanels, hello: Hello} | null} */
let page = null;
/** @type {State | null} */
let state = null;
let own = false; // whether kinds are shown in the colors from the world file
let by = "species";
/** @type {ReturnType<typeof legend> | null} */
let kinds = null;
/** @type {ReturnType<typeof fields> | null} */
let field = null;
let saved = () => {}; // called when the run has arrived as a file
let wanted = read(location.hash); // the view requested by the address, until the world reports its tick

// ---- messages from the server

connection.on("hello", (hello) => {
  if (page) { // after a reconnection, the world may be a different one: reload
    if (another(page.hello, hello)) return anew();
    (page.stage.jump = true), field?.again(), page.own.look(true);
    if (by !== "species") connection.send({ kind: "colour", by });
    if (chosen.uid !== null) connection.send({ kind: "select", ...chosen.asked });
    return;
  }
  begin(hello);
});
connection.on("state", show);
connection.on("series", (series) => {
  const causes = page?.charts.causes().length;
  page?.charts.add(series);
  if (page && page.charts.causes().length !== causes) meals(page.hello, page.charts.colourOf, page.charts.causes());
  if (page) soon(page.timeline.redraw);
  if (kinds) soon(kinds.look);
});
connection.on("marks", (marks) => {
  page?.timeline.mark(marks);
  page?.story.mark(marks.interventions ?? []);
  page?.stage.ground.fence(marks.fences ?? []), page?.act?.mark(marks);
  page?.stage.ground.use(marks.roads ?? [], marks.areas ?? []);
});
connection.on("story", ({ entries }) => [page?.story.add(entries), page?.timeline.tell(entries)]);
connection.on("why", (why) => page?.story.show(why));
connection.on("file", ({ name, html }) => [saved(), save(name, new Blob([html], { type: "text/html" }))]);
connection.on("fates", ({ list }) => page?.stage.over.fates(list));
connection.on("field", (message) => field?.take(message));
connection.on("scatter", (scatter) => page?.charts.figures.scatter.show(scatter));
connection.on("tree", (tree) => page?.panel.tree.take(tree));
connection.on("table", (table) => page?.all.show(table));
connection.on("panel", (panel) => page?.own.show(panel));
connection.on("params", ({ list, knobs }) => page?.act?.offer(list, knobs));
connection.on("organism", (organism) => {
  if (!page || !chosen.told(organism)) return;
  page.panel.show(organism);
  eyes();
});
connection.on("log", (log) => page?.act?.record(log));
connection.on("said", (said) => {
  if (said.field === "select") page?.panel.refuse(said.text);
  if (said.field === "why") page?.story.refuse();
  if (said.field === "export") saved();
  if (said.field === "tree") return page?.panel.tree.refuse(said.text);
  if (said.field === "table") page?.all.refuse(said.text);
  if (said.field === "scatter") return page?.charts.figures.scatter.refuse();
  if (said.field === "seek" && page?.loop.ends) { // a loop goes back often, so no message is shown
    if (said.level === "info") return;
    page.loop.set(null);
  }
  announce(said.text);
  if (said.field !== "select" && ($("act").hidden || ["speed", "step", "colour", "field"].includes(said.field ?? ""))) overlay.flash(said.text);
});
const chosen = new Chosen({ first: () => page?.stage ?? null, second: () => two.stage });
const two = pair(connection, { page: () => page, chosen, select, own: () => own, by: () => by, count: () => kinds?.count() });
const time = new Transport({ page: () => page, send: (request) => connection.send(request), played: () => [did("pause"), tour.stop()] });
const tour = new Tour({ page: () => page, send: (request) => connection.send(request), speed: () => state?.speed ?? null, look: () => look("side") });
const whatif = new WhatIf(connection, () => page && { hello: page.hello, tick: state?.tick ?? page.stage.tick, counts: state?.n ?? {} });
connection.onframe = (buffer) => two.take(buffer);
connection.onlink = (link) => overlay.linked(link, connection);

/** @param {Hello} hello */
function begin(hello) {
  document.title = `${hello.title || hello.world} · ecs-eco`;
  $("title").textContent = hello.title || hello.world;
  $("mode").hidden = false;
  $("mode").textContent = hello.mode === "live" ? "simulation" : "recording"; // paused or not
  const map = cameFrom();
  if (map) $("mode").before(h("a", { class: "chip", href: map, text: "← map" }));
  const stage = new Stage($("canvas"), hello, $("over"));
  const colourOf = (/** @type {string} */ name) => stage.colours[stage.kinds.findIndex((kind) => kind.name === name)] ?? two.colourOf(name) ?? "#888888";
  const charts = new Charts(hello, colourOf, seek,
    { layers: () => stage.layers, scales: () => state?.scales ?? {}, by: () => by, colours: hello.colours.filter((name) => name !== "family"), colour, select, ask: (x, y) => connection.send({ kind: "scatter", x, y }) });
  const panel = new Panel(hello, { select: (uid) => select(uid, chosen.second), other: () => two.stage?.hello ?? null, fill: () => connection.send({ kind: "fill", ...chosen.asked }), follow: () => look("follow"), track: (uid) => colour(`kin:${uid}`), tree: () => connection.send({ kind: "tree", ...chosen.asked, by }), clade: (life) => cladeOf(by, life), colourOf });
  const timeline = new Timeline(hello, seek, charts.lanes());
  const loop = new Loop(hello, timeline, (request) => connection.send(request));
  const story = new Story(hello, { jump, without, colourOf, ask: () => connection.send({ kind: "why" }), play: () => tour.toggle(), tell: (entry) =>
    tour.tell(entry) || overlay.flash(`${entry.text}.`, { text: "Why?", does: () => open("why") }) });
  const act = hello.acts ? new Act(hello, {
    send: (what, as) => connection.send({ kind: "act", what, ...(as ? { as } : {}) }),
    ask: () => connection.send({ kind: "params" }),
    aim: (words) => [$("canvas").classList.toggle("aim", words !== null), overlay.notice(words)],
    now: () => stage.tick, back: (tick) => connection.send({ kind: "seek", tick, undo: true }),
    selected: () => (panel.organism?.alive && !panel.organism.second ? panel.organism : null),
  }) : null;
  $("tab-act").hidden = !act;
  $("tab-all").hidden = $("link").hidden = Boolean(hello.file);
  const all = new All(hello, { ask: (request) => connection.send({ kind: "table", ...request }), select });
  const panels = new OwnPanels(hello.panels ?? [], (shown) => connection.send({ kind: "panels", shown }));
  page = { stage, charts, panel, timeline, loop, story, all, act, own: panels, hello };
  arrange(), panels.look();
  stage.eye.cover = overlay.covered;
  stage.sized.observe($("knobs"));
  originates(() => `${hello.title || hello.world} · seed ${hello.seed ?? "–"} · tick ${number(stage.tick)} · ecs-eco`);
  stage.onrender = () => {
    overlay.follow(stage);
    two.follow();
    kinds?.count();
    if (hello.mode === "replay") kinds?.look();
    $("tick").textContent = number(stage.tick);
    timeline.at(stage.tick);
    loop.at(stage.tick);
    charts.at(stage.tick);
    story.at(stage.tick);
    all.time(stage.tick);
    act?.changes.time(stage.tick);
    panel.tree.time((chosen.stage ?? stage).tick);
    overlay.descendants(stage, by);
    if (followable() === followOff()) eyes(); // the organism's state may arrive before the frame that contains it
  };
  field = fields(stage, (name) => connection.send({ kind: "field", name }));
  saved = capture(stage, hello, () => connection.send({ kind: "export" }));
  stage.onlight = () => overlay.sky(stage);
  onTheme((dark) => paint(dark));
  $("colour").replaceChildren(...hello.colours.map((name) => h("option", { value: name, text: name.replace("gene:", "gene ") })));
  look("side", false);
  act?.calls.ask();
  wanted = kept(identity(hello)) ?? wanted;
  window.addEventListener("pagehide", () => // a server keeps its tick
    keep(identity(hello), { ...shown(stage, chosen, opened(), by), ...(hello.file ? {} : { tick: undefined }) }));
}

/** @param {boolean} dark */
function paint(dark) {
  if (!page) return;
  page.stage.theme(dark, own);
  field?.shade();
  const { stage, charts, story, timeline } = page;
  two.paint(dark);
  kinds = legend(stage, {
    own, find, onshow: (name, shown) => charts.show(name, shown),
    onown: (chosen) => {
      own = chosen;
      paint(stage.dark);
    },
    other: () => two.stage, all: (name) => state?.n[name],
    brief: (name) => ({
      ...charts.brief(name), extinct: story.extinct(name),
      learns: page?.act?.switchedAs?.[name]?.learning ?? Boolean(stage.kinds.find((kind) => kind.name === name)?.learns),
    }),
  });
  page.charts.rebuild();
  page.panel.redraw();
  story.draw();
  timeline.draw();
  world(page.hello, page.charts.colourOf, page.charts.causes()), picker(page.hello, connection);
}

/** @param {State} now */
function show(now) {
  state = now;
  time.show(now);
  if (page) overlay.ramp(by, now.scales);
  page?.charts.figures.at();
  if (now.done && page?.hello.mode === "live" && !page.loop.ends) overlay.notice("The run has ended.");
  if (wanted) apply(wanted);
  wanted = null;
}

// ---- user actions

/** Goes to a tick; a story that is playing stops. @param {number} tick */
function seek(tick) {
  tour.stop();
  connection.send({ kind: "seek", tick });
}

/** @param {number | null} uid @param {boolean} [second] whether it belongs to the second world */
function select(uid, second = false) {
  if (!page || (uid === null && chosen.uid === null)) return;
  const { followed, stage: led } = chosen;
  chosen.take(uid, second);
  page.panel.expect(uid, chosen.second);
  page.act?.selected(uid !== null && !chosen.second);
  page.all.selected = chosen.second ? null : uid;
  connection.send({ kind: "select", ...chosen.asked });
  if (followed && uid === null) look("side");
  else if (followed && chosen.stage !== led) chosen.follow();
  eyes();
  if (uid !== null) {
    did("select");
    open("organism");
    announce(`Selected organism ${uid}${chosen.second ? " of the second world" : ""}`);
  }
}

/** Selects the next or previous organism, animals first. @param {number} by */
const next = (by) => selectFound(chosen.stage && beside(chosen.stage, by), chosen.second);

/** Selects an organism of a kind and moves the camera to it. @param {string} name */
function find(name) {
  if (selectFound(page && anyOf(page.stage, name))) look("follow");
}

/** @param {number | null} uid @param {boolean} [second] */
function selectFound(uid, second = false) {
  if (uid !== null) select(uid, second);
  return uid !== null;
}

/** @param {"top" | "side" | "follow"} preset @param {boolean} [fly] */
function look(preset, fly = true) {
  if (!page || (preset === "follow" && !followable())) return;
  if (preset === "follow") chosen.follow();
  else {
    if (two.stage) chosen.stay(two.stage);
    page.stage.eye.look(preset, fly);
    page.stage.dirty = true;
  }
  eyes();
}

/** Whether the selected organism can be followed. */
const followable = () => page?.panel.organism?.alive !== false && chosen.place !== null;

const followOff = () => /** @type {HTMLButtonElement} */ (document.querySelector("[data-eye=follow]")).disabled;

function eyes() {
  for (const button of document.querySelectorAll("[data-eye]")) {
    const preset = /** @type {HTMLButtonElement} */ (button).dataset.eye;
    button.setAttribute("aria-pressed", String(preset === (chosen.followed ? "follow" : page?.stage.eye.preset)));
    if (preset === "follow") /** @type {HTMLButtonElement} */ (button).disabled = !followable();
  }
}

/** @param {string} name of a color mode */
function colour(name) {
  by = name;
  const tracked = $("colour").querySelector("[value^='kin:']") ?? (name.startsWith("kin:") ? $("colour").appendChild(h("option")) : null);
  if (name.startsWith("kin:")) Object.assign(tracked, { value: name, textContent: `descendants of #${name.slice(4)}` });
  $("colour").value = name;
  for (const stage of [page?.stage, two]) stage?.colourBy(name);
  page?.charts.figures.draw();
  overlay.ramp(name);
  connection.send({ kind: "colour", by: name });
  page?.panel.tree.again();
}

/** Shows an event: goes to its tick if that is possible, and otherwise points at it in the charts. @param {import("./protocol.js").Entry} entry */
function jump(entry) {
  if (page?.hello.mode === "replay") seek(Math.min(entry.tick, page.hello.last ?? entry.tick));
  else {
    open("charts");
    page?.charts.point(entry.tick);
  }
  if (entry.colour && page?.hello.colours.includes(entry.colour)) colour(entry.colour);
}

/** Opens a second world next to a recorded run, without the allele of a sweep. @param {import("./protocol.js").Entry} entry */
function without(entry) {
  connection.send({ kind: "pause" });
  jump({ ...entry, tick: entry.tick - 1 }); // forks begin with the end of the displayed tick
  connection.send({ kind: "whatif", tick: null, sweep: entry.sweep });
}

/** @param {import("./tabs.js").PanelName} name of a panel */
function open(name) {
  if ($(`tab-${name}`).hidden) return;
  openPanel(name);
  if (name !== "act") page?.act?.aim(false);
  if (name === "why") did("why"), page?.story.open();
  if (name === "all") page?.all.again();
  page?.own.look();
}

/** Applies the view requested by a link. @param {import("./link.js").Sight} sight */
function apply({ tick, eye, uid, of, tab, colour: by, field: name, follow }) {
  if (!page || !state) return;
  const { hello, stage } = page;
  if (tick !== undefined && (hello.mode === "replay" || (hello.rewinds && tick < state.tick))) {
    connection.send({ kind: "pause" });
    connection.send({ kind: "seek", tick });
  } else if (tick !== undefined && tick > state.tick) overlay.flash(`This world has not reached tick ${number(tick)} yet.`);
  if (by && (hello.colours.includes(by) || by.startsWith("kin:"))) colour(by);
  if (uid !== undefined && of === "second" && !two.stage) overlay.flash(`#${uid} belongs to a second world, but no second world is open.`);
  else if (uid !== undefined) select(uid, of === "second");
  const panel = PANELS.find((one) => one === tab && !$(`tab-${one}`).hidden);
  if (panel) open(panel);
  if (eye) lookFrom(stage, eye);
  if (follow) look("follow", false);
  if (name) field?.choose(name);
}

/** Copies a link to the current view. */
const share = () => page && copy(written(shown(page.stage, chosen, opened(), by))).then((words) => overlay.flash(`${words}.`));

// ---- buttons and keys

const did = hints();
recallTheme();
splitter();
classroom();
onTheme(() => {});
$("theme").addEventListener("click", switchTheme);
$("colour").addEventListener("change", () => colour($("colour").value));
for (const button of document.querySelectorAll("[data-eye]")) {
  button.addEventListener("click", () => look(/** @type {"top"} */ (/** @type {HTMLElement} */ (button).dataset.eye)));
}
listenTabs(open);
$("share").addEventListener("click", share);

const keys = keymap({
  page: () => page, time, look, next, select, open, share, whatif: () => whatif.open(), stop: () => tour.stop(),
  colour: () => {
    const all = page?.hello.colours ?? ["species"];
    colour(all[(all.indexOf(by) + 1) % all.length]);
  },
});
listen(keys);
help(keys.filter(({ about }) => about));
$("helpOpen").addEventListener("click", () => $("help").showModal());

point($("canvas"), { page: () => page, select });
count({ page: () => page, state: () => state, connection, two, chosen });
window.addEventListener("hashchange", () => { // the user has entered another address in this tab
  if (connection.socket === null) connection.again();
  else taken(); // the page is already connected
  const asked = read(location.hash);
  if (asked && state) apply(asked);
});
connection.open();
