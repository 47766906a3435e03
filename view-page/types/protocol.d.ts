// JSON messages between server and page; frame.js reads binary frames. Modules import only types from here.

export interface Kind {
  name: string;
  color: string;
  radius: number;
  moves?: boolean;
  sessile?: boolean;
  inanimate?: boolean;
  rests?: boolean; // an animal that does not move; computed by the page
  hunts?: boolean; // eats animals; computed by the page
  build?: string; // its shape, from `look`, its name, or its diet and habitat; computed by the page
  variant?: number; // index among kinds with the same silhouette
  look?: string; // its shape in the world file
  opaque?: boolean; // false: does not hide objects behind it
  sees?: SeeingEye[]; // sensors that reach beyond its body
  solid?: boolean;
  remains?: boolean; // of an object type: dead animals become it
  wiring?: Wiring;
  learns?: boolean;
  genes?: string[];
  units?: Record<string, string>; // of these genes; "1" if a gene has none
  shows?: { grows?: ["age" | "radius", number, number]; size?: [string, number, number]; stripes?: [string, number, number] }; // what shows in bodies: the variable that sizes the young, its value at full size and the relative size at 0; genes: the radii at the lowest and highest value, relative to `radius`; the values without and with full stripes
  every?: number; // in a file: of how many organisms one is included
  shape?: "capsule" | "box"; // absent: a sphere
  size?: number[]; // length, width and height of a capsule or box [m]
  sizes?: Record<string, number[]>; // of individual objects, by uid, if they differ
}

/** The connections of a nervous system. Readings and actions are given by their row numbers. */
export interface Wiring {
  reflexes: [number[], number, string][]; // readings, action, label
  function: string; // name of the reflex function, or "" if there is none
  policy: string; // its layers, or "none"
  happiness: string | null; // its formula
  felt: number[]; // readings in the formula
  all: { reflex: boolean; policy: boolean; happiness: boolean }; // whether every reading can affect it
}

/** A sensor that reaches beyond the body. */
export interface SeeingEye {
  number: number; // among the sensors of the species
  name: string;
  kind: "nearest" | "rays" | "approach" | "alignment" | "property";
  targets: string[];
  reach: number; // [m]
  fov: number; // [rad]
  count?: number; // of rays
  angle?: number; // of the middle ray, from the heading [rad]
  each?: boolean; // whether each ray reports
  kin?: string;
}

export interface Landmark {
  at: number[];
  radius: number;
  height?: number;
}

export interface Terrain {
  cell: number;
  nx: number;
  ny: number;
  heights: string;
  /** for real land: red, green and blue of each cell, as bytes in base64 */
  colours?: string;
  /** land cover of each cell, as bytes in base64: 1 woods, 2 crops, 3 rock, 4 water; 0 other */
  cover?: string;
  rocks?: Landmark[];
  lakes?: Landmark[];
}

/** A color on light and on dark backgrounds, and the hue [degrees] that it represents. */
export type Swatch = [string, string, number];

export interface Hello {
  kind: "hello";
  mode: "live" | "replay";
  world: string;
  title: string;
  panels?: string[]; // names of the user's own panels
  about?: string; // its description, paragraphs separated by empty lines
  seed?: number;
  dt: number;
  tick: number;
  first: number;
  last: number | null;
  size: number[];
  edges: string;
  day: { length?: number } | null;
  species: Kind[];
  objects?: Kind[];
  terrain: Terrain | null;
  colours: string[];
  palette: Swatch[]; // colors of kinds that color-blind people can distinguish
  acts: boolean;
  rewinds?: boolean; // whether a live world can go back in time
  stays?: string; // why it cannot
  foods?: Record<string, string[]>; // foods from which each species gains energy
  eats?: Record<string, string[]>; // all foods in the diet of each species, also those that harm it
  snapshot_every?: number | null;
  fields?: string[]; // maps that can be laid over the scene
  begins?: Begins;
  forks?: boolean; // whether the world can be branched
  saves?: boolean; // whether the run can be saved as a file
  file?: string[]; // in a page that is a file: what it contains
}

/** The worlds that can replace the displayed world, or the reason why there are none. */
export interface Begins {
  why?: string;
  worlds?: { name: string; title: string }[];
  world?: string; // the displayed world
  begun?: number; // number of worlds started by this server so far
}

/** Data about a second world: its description, curves and differences, or the message that it is closed. */
export interface Beside {
  kind: "beside";
  hello?: Hello;
  at?: number | null; // the tick at which it branched from this one; null: an unrelated world
  change?: string;
  names?: string[]; // of both worlds
  recipe?: { toml: string; command: string } | null;
  series?: Series;
  marks?: Marks;
  fates?: number[][];
  state?: { tick: number; there: boolean; n: Record<string, number>; text: string; clauses: Record<string, string> };
  closed?: string; // the reason
}

/** Pairs of worlds with and without a change: their progress; once they have ended, their outcome or a problem. */
export interface Pairs {
  kind: "pairs";
  done?: number;
  of?: number; // number of runs, two per seed
  command?: string;
  stopped?: true;
  problem?: string;
  lines?: string[];
  figure?: string; // SVG
  html?: string; // the report
}

/** A recorded run as a page in one file: its name and its HTML text. */
export interface FileMessage {
  kind: "file";
  name: string;
  html: string;
}

type Column = [name: string, type: "u1" | "u2" | "u4" | "i4" | "f4" | "f8", length: number];

/** The lives of a species in a page that is a file. */
export interface StoredKind {
  name: string;
  scales: Record<string, [number, number]>; // of stored values
  every: number; // of how many organisms one is included
  oldest: number; // the longest life [ticks]
  columns: Column[];
}

/** The run in a page that is a file, besides its columns. */
export interface Stored {
  hello: Hello;
  story: StoryMessage;
  marks: [since: number, marks: Marks][];
  series: Series;
  why: Why;
  causes: string[];
  step: number; // ticks between stored states
  clock: { columns: Column[] };
  kinds: StoredKind[];
}

/** Deaths of animals: tick, number of the species, uid, x, y, z [m], uid of the killer or 0. */
export interface Fates {
  kind: "fates";
  list: number[][];
}

/** Organisms of a species, sorted and filtered: at most a hundred rows. */
export interface TableMessage {
  kind: "table";
  species: string;
  sort: string;
  down: boolean;
  where: string;
  from: number;
  n: number; // number of organisms of the species
  found: number; // rows that satisfy `where`
  columns: Record<string, (number | null)[]>;
}

/** An organism of a family tree; unknown values are null. */
export interface Relative {
  uid: number;
  species: string | null;
  born: number | null;
  died: { tick: number; cause: string; killer?: number | null } | null;
  age: number | null; // at death [s]
  parents: number[];
  young: number | null; // total number of children
  clade: number | null; // its value, 0 to 255, if the color shows descent
}

/** The family tree of an organism, which comes first in `lives`, followed by its ancestors, nearest first. */
export interface TreeMessage {
  kind: "tree";
  uid: number;
  siblings: number; // including half-siblings
  lives: Relative[];
  second?: boolean; // of the second world
  tick?: number; // when the page received it
}

/** Two values of organisms, by species. */
export interface ScatterMessage {
  kind: "scatter";
  x: string;
  y: string;
  names: string[]; // names of the available values
  points: Record<string, { x: number[]; y: number[]; uid: number[] }>;
}

/** A field as a map: bytes in base64, 0 to 255 from low to high, row by row from the south (in water, from the bottom). */
export interface FieldMessage {
  kind: "field";
  name: string;
  tick: number;
  unit: string;
  nx: number;
  ny: number;
  low: number;
  high: number;
  values: string;
}

export interface State {
  kind: "state";
  playing: boolean;
  speed: number | null;
  tick: number;
  rate: number;
  done: boolean;
  n: Record<string, number>;
  scales?: Record<string, [number, number]>;
  pages?: number;
}

export interface Series {
  kind: "series";
  tick: number[];
  n: Record<string, (number | null)[]>;
  happiness?: Record<string, (number | null)[]>;
  genes?: Record<string, (number | null)[]>;
  /** By reporter, then by species, or "" for a single number for the whole world. */
  reports?: Record<string, Record<string, (number | null)[]>>;
  light?: (number | null)[];
  energy?: Record<string, Record<string, (number | null)[]>>; // taken in and burned per tick, by species
  flows?: Record<string, Record<string, (number | null)[]>>; // energy per tick since the previous point, by species: taken in, burnt, given, lost, and "eaten: FOOD"
  shared?: boolean; // whether energy per food is estimated from numbers eaten
  births?: Record<string, (number | null)[]>; // per tick
  deaths?: Record<string, (number | null)[]>;
  causes?: Record<string, Record<string, (number | null)[]>>; // deaths per tick, by species and cause
}

export interface Mark {
  tick: number;
  text: string;
}

export interface Marks {
  kind: "marks";
  switches?: Record<string, { reproduction: boolean; learning: boolean | null }>; // of a live world, by species
  births?: number[] | null;
  deaths?: number[] | null;
  interventions?: Mark[];
  fences?: number[][][];
  roads?: Strip[];
  areas?: Area[];
  stretches?: Detailed[]; // of a recorded run
}

/** Ticks with recorded details of all organisms or of a focal sample, or ticks that were rerun. */
export interface Detailed {
  kind: "full" | "focal" | "filled";
  first: number;
  last: number;
  species: string[];
  n: number | null; // organisms of each species in a focal sample
  wrong: number | null; // the first tick at which a rerun stretch differs from the record
}

/** A road: its center line and its width [m]. */
export interface Strip {
  line: number[][];
  width: number;
}

/** An area of land or sea use, and its border [m]. */
export interface Area {
  kind: "harvest" | "plant";
  border: number[][];
}

/** An event in a species' history, or an intervention. */
export interface Entry {
  tick: number;
  kind: "birth" | "boom" | "crash" | "extinct" | "return" | "act" | "sweep";
  species: string;
  n: number;
  text: string;
  cause: string;
  before?: number; // population before the boom, crash or extinction
  colour?: string; // of a sweep: the quantity that shows its allele
  sweep?: number; // of a sweep whose allele can be taken out: its number in `whatif` requests
}

export interface StoryMessage {
  kind: "story";
  entries: Entry[];
}

export interface TurnTo {
  key: string;
  value: unknown;
  turn: string;
  effect: string;
}

/** The diagnosis of `ecs-eco why` for the ticks from `first` to `tick`. */
export interface Why {
  kind: "why";
  tick: number;
  first: number;
  sections: Record<string, string[]>;
  turns: TurnTo[];
}

export interface Gene {
  name: string;
  trait?: string | null;
  string?: number;
  from: number;
  to: number;
  value: number | (number | null)[] | null;
  text?: string;
  alleles?: (number | (number | null)[] | null)[];
}

export interface Genome {
  alphabet: string;
  string?: string;
  strings?: string[];
  genes: Gene[];
}

export interface Sensor {
  name: string;
  value: number | null;
}

export interface Action {
  group: string;
  name: string;
  reflex: number;
  probability: number | null;
  chosen: number | boolean;
  decision: number | boolean;
  continuous?: boolean; // reflex, chosen and decision are numbers in its unit
}

export interface Nerves {
  sensors: Sensor[];
  actions: Action[];
  happiness: number | null;
  reward: number | null;
}

export interface Organism {
  kind: "organism";
  uid: number;
  species: string;
  alive: boolean;
  age: number | null;
  sex: string | number | null;
  energy: number | null;
  energy_max: number | null;
  place: number[] | null;
  heading: number | null;
  size?: (number | null)[]; // of a capsule or box [m]
  parents: number[];
  children: number[];
  born: number | null;
  died: { tick: number; cause: string; killer?: number | string | null } | null;
  generation: number | null;
  genome: Genome | null;
  nerves: Nerves | null;
  trace: { tick: number[]; happiness?: (number | null)[]; energy?: (number | null)[] } | null;
  detail: "full" | "snapshot" | "record";
  as_of?: number; // of a dead organism: the tick of this last known state
  reach?: Record<string, number>; // current reach of its sensors [m], by number, where it differs from that of the species
  channels?: Record<string, { range?: number; target?: string }>; // range [m] and target of those that read 1 − distance/range
  note?: string | null;
  sentence?: string;
  world?: string; // the name of its world, if there are two
  second?: boolean; // whether it is in the second world
  both?: boolean; // whether both worlds have it, because it was born before they diverged; absent for unrelated worlds
}

export interface Said {
  kind: "said";
  level: "info" | "warning" | "error";
  text: string;
  field?: string | null;
  at?: string; // the invalid part of a change
}

/** An action of a page, or a message from the world to all pages. */
export interface LogEntry {
  tick: number;
  page: number | null; // number of the page; null: a message to all pages
  level: "info" | "warning" | "error"; // error: refused
  text: string; // the answer
  asked?: "act" | "seek" | "whatif" | "begin";
  what?: string; // the requested intervention as text
  as?: "undo" | "reset"; // whether it undoes a change
}

/** New entries of the log shared by all pages; with `page`, this page's number, all entries so far. */
export interface LogMessage {
  kind: "log";
  page?: number;
  entries: LogEntry[];
}

export interface Parameter {
  key: string;
  value: unknown;
  whole?: boolean; // whether it is an integer
  unit?: string | null;
  low?: number | null;
  high?: number | null;
  about?: string | null;
}

/** A parameter that the world offers as a knob, with the ends of its slider. The current value may lie outside. */
export interface Knob {
  key: string;
  label: string;
  unit: string;
  low: number;
  high: number;
}

/** The result of a user's panel: a number (null: not finite), a picture or an error. */
export interface PanelMessage {
  kind: "panel";
  name: string;
  tick: number;
  number?: number | null;
  svg?: string;
  error?: string;
}

export interface Params {
  kind: "params";
  list: Parameter[];
  knobs: Knob[];
  forks?: number[]; // first and last tick at which a branch can start
}

/** The map of an archipelago: population sizes n[island][species][point], moves [point, species, from, to, number]. */
export interface Islands {
  kind: "islands";
  title: string;
  seed: number;
  tick: number;
  ticks: number;
  finished: boolean;
  every: number;
  graph: string;
  palette: Swatch[];
  species: (Kind & { wanders: boolean })[];
  islands: { name: string; at: [number, number]; own: string }[];
  ways: [number, number][];
  points: number[];
  n: number[][][];
  moves: [number, number, number, number, number][];
}

/** The address at which a requested island is open. */
export interface OpenedIsland {
  kind: "opened";
  island: string;
  address: string;
}

export type Message = Islands | OpenedIsland | Hello | State | Series | Marks | Organism | Said | LogMessage | Params | StoryMessage | Why | Fates | FieldMessage | TableMessage | TreeMessage | ScatterMessage | Beside | FileMessage | Pairs | PanelMessage;

/** Data about the page for tests, as `window.ecs`; see docs/reference/viewer_protocol.md. */
export interface Counters {
  frames: number;
  tick: number;
  counts: Record<string, number>;
  decodeMs: number;
  renderMs: number;
  renders: number;
  selected: number | null;
  mode: string;
  playing: boolean;
  still: boolean;
  connected: boolean;
  ended: boolean;
  refused: boolean;
  messages: Record<string, number>;
  acts: number;
  second: { tick: number; frames: number; still: boolean; counts: Record<string, number>; camera: number[]; chosen: boolean; ring: number | null;
    uids(kind: string, most?: number): number[]; screen(uid: number): { x: number; y: number } | null } | null; // of a second world
  camera: number[]; // position [m]
  uids(kind: string, most?: number): number[];
  place(uid: number): number[] | null;
  screen(uid: number): { x: number; y: number } | null;
  corners(): [number, number][];
  over: { seen: number; rays: number; drawn: number; marks: Record<string, number> };
}

declare global {
  interface Window {
    ecs: Counters;
    run: Promise<ArrayBuffer[]>; // in a page that is a file
  }
}
