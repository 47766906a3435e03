// What server and page say to each other as JSON; binary frames are read in frame.js. The modules import these as types only.

export interface Kind {
  name: string;
  color: string;
  radius: number;
  moves?: boolean;
  sessile?: boolean;
  inanimate?: boolean;
  rests?: boolean; // an animal that stays where it is; worked out by the page
  hunts?: boolean; // eats what moves; worked out by the page
  build?: string; // its silhouette, as its diet and where it lives say; worked out by the page
  variant?: number; // among those of the same
  opaque?: boolean; // false: hides nothing that is behind it
  sees?: SeeingEye[]; // what reaches further than its body
  solid?: boolean;
  wiring?: Wiring;
  learns?: boolean;
  genes?: string[];
  shape?: "capsule" | "box"; // absent: a sphere
  size?: number[]; // of a capsule or box: length, width, height [m]
  sizes?: Record<string, number[]>; // of single objects, by uid, where they differ
}

/** How a nervous system is wired; rows are those of its readings and actions. */
export interface Wiring {
  reflexes: [number[], number, string][]; // readings, action, and what it does
  function: string; // that is the reflex network; "" without
  policy: string; // its layers, or "none"
  happiness: string | null; // its formula
  felt: number[]; // readings in the formula
  all: { reflex: boolean; policy: boolean; happiness: boolean }; // whether every reading may lead there
}

/** A sensor that reaches further than the body. */
export interface SeeingEye {
  number: number; // among the sensors of the species
  name: string;
  kind: "nearest" | "rays" | "approach" | "property";
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
  /** red, green and blue of each cell, of real land: bytes in base64 */
  colours?: string;
  rocks?: Landmark[];
  lakes?: Landmark[];
}

export interface Hello {
  kind: "hello";
  mode: "live" | "replay";
  world: string;
  title: string;
  about?: string; // its description, paragraphs parted by empty lines
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
  acts: boolean;
  rewinds?: boolean; // whether a living world can go back in time
  stays?: string; // why it cannot
  foods?: Record<string, string[]>; // what each species eats and gains by
  snapshot_every?: number | null;
  fields?: string[]; // that may be laid over the scene
  begins?: Begins;
  forks?: boolean; // whether there can be a second world beside it that parts from it
}

/** Which worlds may be begun in the place of the one that is shown, or why none. */
export interface Begins {
  why?: string;
  worlds?: { name: string; title: string }[];
  world?: string; // that is shown
  begun?: number; // how often this server has begun anew
}

/** Of a second world beside this one: what it is, its curves, what differs; or that it is closed. */
export interface Beside {
  kind: "beside";
  hello?: Hello;
  at?: number | null; // the tick at which it parted from this one; null: it is another world
  change?: string;
  names?: string[]; // of both
  recipe?: { toml: string; command: string } | null;
  series?: Series;
  marks?: Marks;
  fates?: number[][];
  state?: { tick: number; there: boolean; n: Record<string, number>; text: string; clauses: Record<string, string> };
  closed?: string; // why
}

/** Deaths of animals: tick, number of the species, uid, x, y, z [m], uid of the killer or 0. */
export interface Fates {
  kind: "fates";
  list: number[][];
}

/** Organisms of a species, sorted and filtered: at most a hundred rows from one on. */
export interface TableMessage {
  kind: "table";
  species: string;
  sort: string;
  down: boolean;
  where: string;
  from: number;
  n: number; // of the species
  found: number; // for which `where` holds
  columns: Record<string, (number | null)[]>;
}

/** One of a family tree; what is not known is null. */
export interface Relative {
  uid: number;
  species: string | null;
  born: number | null;
  died: { tick: number; cause: string; killer?: number | null } | null;
  age: number | null; // at death [s]
  parents: number[];
  young: number | null; // all its children
  clade: number | null; // its value, 0 to 255, where the colour is one by descent
}

/** The family tree of an organism, which is the first of `lives`; then its ancestors, the nearest first. */
export interface TreeMessage {
  kind: "tree";
  uid: number;
  siblings: number; // all, half-siblings too
  lives: Relative[];
  second?: boolean; // of the second world
  tick?: number; // when the page had it
}

/** Two values of organisms, by species. */
export interface ScatterMessage {
  kind: "scatter";
  x: string;
  y: string;
  names: string[]; // of values that there are
  points: Record<string, { x: number[]; y: number[]; uid: number[] }>;
}

/** A field as a map: bytes in base64, 0 to 255 from low to high, row by row from the south (of water, from the bottom). */
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
  /** By reporter, then by species, or "" for a number of the world. */
  reports?: Record<string, Record<string, (number | null)[]>>;
  light?: (number | null)[];
  energy?: Record<string, Record<string, (number | null)[]>>; // taken in and burnt in a tick, by species
  flows?: Record<string, Record<string, (number | null)[]>>; // energy a tick since the point before, by species: taken in, burnt, given, lost, and "eaten: FOOD"
  shared?: boolean; // whether what was eaten of each food is not known, but shared by numbers
  births?: Record<string, (number | null)[]>; // a tick
  deaths?: Record<string, (number | null)[]>;
  causes?: Record<string, Record<string, (number | null)[]>>; // deaths a tick, by species and cause
}

export interface Mark {
  tick: number;
  text: string;
}

export interface Marks {
  kind: "marks";
  switches?: Record<string, { reproduction: boolean; learning: boolean | null }>; // of a living world, by species
  births?: number[] | null;
  deaths?: number[] | null;
  interventions?: Mark[];
  fences?: number[][][];
  roads?: Strip[];
  areas?: Area[];
  stretches?: Detailed[]; // of a recorded run
}

/** Ticks of which details of organisms were recorded, of all or of a focal sample, or which were run again. */
export interface Detailed {
  kind: "full" | "focal" | "filled";
  first: number;
  last: number;
  species: string[];
  n: number | null; // organisms of each species in a focal sample
  wrong: number | null; // the first tick at which a filled one differs from the record
}

/** A road: its middle line and its width [m]. */
export interface Strip {
  line: number[][];
  width: number;
}

/** An area in which land or sea is used, and its border [m]. */
export interface Area {
  kind: "harvest" | "plant";
  border: number[][];
}

/** What happened to a species, or what people did. */
export interface Entry {
  tick: number;
  kind: "birth" | "boom" | "crash" | "extinct" | "return" | "act";
  species: string;
  n: number;
  text: string;
  cause: string;
  before?: number; // the number that it boomed, crashed or died out from
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

/** The account that `ecs-eco why` gives, of the ticks from first to tick. */
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
  as_of?: number; // of a dead one: the tick whose state this is, the last one that is known of its life
  reach?: Record<string, number>; // how far its sensors reach [m], by number, where that is not the species'
  note?: string | null;
  sentence?: string;
  world?: string; // the name of its world, where there are two
  second?: boolean; // whether that is the second one
  both?: boolean; // whether it was born before they parted, so that both have it; absent where they never were one
}

export interface Said {
  kind: "said";
  level: "info" | "warning" | "error";
  text: string;
  field?: string | null;
  at?: string; // the part of a change that does not fit
}

/** What a page did, or the world told all pages. */
export interface LogEntry {
  tick: number;
  page: number | null; // who did it; null: what all pages were told
  level: "info" | "warning" | "error"; // error: refused
  text: string; // what was answered
  asked?: "act" | "seek" | "whatif" | "begin";
  what?: string; // the intervention that was asked for, in words
  as?: "undo" | "reset"; // it takes something back
}

/** New entries of the log that all pages share; with `page`, the number of this one, all that there are. */
export interface LogMessage {
  kind: "log";
  page?: number;
  entries: LogEntry[];
}

export interface Parameter {
  key: string;
  value: unknown;
  whole?: boolean; // whether it is a whole number
  unit?: string | null;
  low?: number | null;
  high?: number | null;
  about?: string | null;
}

/** A parameter that the world names as a knob: ends of its slider, which the present value may lie beyond. */
export interface Knob {
  key: string;
  label: string;
  unit: string;
  low: number;
  high: number;
}

export interface Params {
  kind: "params";
  list: Parameter[];
  knobs: Knob[];
  forks?: number[]; // first and last tick from which there can be a second world
}

/** The map of an archipelago: numbers n[island][species][point], moves [point, species, from, to, number]. */
export interface Islands {
  kind: "islands";
  title: string;
  seed: number;
  tick: number;
  ticks: number;
  finished: boolean;
  every: number;
  graph: string;
  species: (Kind & { wanders: boolean })[];
  islands: { name: string; at: [number, number]; own: string }[];
  ways: [number, number][];
  points: number[];
  n: number[][][];
  moves: [number, number, number, number, number][];
}

/** An island that was asked for is open at this address. */
export interface OpenedIsland {
  kind: "opened";
  island: string;
  address: string;
}

export type Message = Islands | OpenedIsland | Hello | State | Series | Marks | Organism | Said | LogMessage | Params | StoryMessage | Why | Fates | FieldMessage | TableMessage | TreeMessage | ScatterMessage | Beside;

/** What tests may read of the page, as `window.ecs`; see docs/how-to/watching.md. */
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
  camera: number[]; // where it is [m]
  uids(kind: string, most?: number): number[];
  place(uid: number): number[] | null;
  screen(uid: number): { x: number; y: number } | null;
  corners(): [number, number][];
  over: { seen: number; rays: number; drawn: number; marks: Record<string, number> };
}

declare global {
  interface Window {
    ecs: Counters;
  }
}
