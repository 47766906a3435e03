// The shapes of bodies. A species looks like the animal or plant that it is named after; otherwise its diet, habitat and size choose a shape.
// Lengths are in body radii: forward is +x, and on land the ground is at z = −1. Capsules and boxes start as cubes from −1 to 1 along each
// axis; the shader moves their corners outward along `facing` by the rounding.

/** @typedef {number[]} Corner x, y (left) and z (up) */
/**
 * @typedef {{spine?: number[][], wide?: number, fin?: Corner[], tone?: number, pair?: boolean}} Part
 * A tube around a line of points x, y, z and radius, `wide` times as wide as high, or a triangle; its brightness; and whether the other side has a copy.
 */

/** @param {number} x @param {number} y @param {number} hip @param {number} thick @returns {Part} */
const leg = (x, y, hip, thick, tone = 0.8) => ({ spine: [[x, y, hip, thick], [x, y, -0.4, 0.62 * thick], [x, y, -1, 0.55 * thick]], tone, pair: true });

/** @param {Corner} a @param {Corner} b @param {Corner} c @returns {Part} */
const fin = (a, b, c, tone = 0.9, pair = true) => ({ fin: [a, b, c], tone, pair });

/** A clump of leaves. @param {number} x @param {number} y @param {number} z @param {number} r @returns {Part} */
const clump = (x, y, z, r, tone = 1) => ({ spine: [[x, y, z - r, 0.25 * r], [x, y, z - 0.5 * r, 0.9 * r], [x, y, z + 0.35 * r, 0.9 * r], [x, y, z + 0.85 * r, 0.4 * r], [x, y, z + r, 0.05 * r]], tone });

/** A leaf of three leaflets on a stalk. @param {number} x @param {number} y @param {number} z @param {number} r @param {number} turn @returns {Part[]} */
const trefoil = (x, y, z, r, turn) => [
  ...[0, 1, 2].flatMap((k) => {
    /** @type {(a: number, far: number, up: number) => Corner} */
    const at = (a, far, up) => [x + far * r * Math.cos(turn + a), y + far * r * Math.sin(turn + a), z + up * r];
    const [a, base] = [(2 * Math.PI * k) / 3, /** @type {Corner} */ ([x, y, z])];
    return [1, -1].flatMap((side) => [
      fin(base, at(a + 0.7 * side, 0.75, 0.12), at(a, 0.8, 0.05), 0.85 + 0.1 * side, false),
      fin(at(a, 0.8, 0.05), at(a + 0.7 * side, 0.75, 0.12), at(a + 0.32 * side, 1.05, 0.1), 1.1 + 0.1 * side, false),
    ]);
  }),
  fin([0.3 * x, 0.3 * y, -1], [0.3 * x + 0.06, 0.3 * y + 0.06, -1], [x, y, z], 0.6, false),
];

/** @type {Record<string, Part[]>} */
const SHAPES = {
  deer: [
    { spine: [[-1.12, 0, 0.45, 0.06], [-1, 0, 0.3, 0.4], [-0.45, 0, 0.2, 0.5], [0.2, 0, 0.2, 0.5], [0.65, 0, 0.38, 0.44], [0.95, 0, 0.85, 0.25], [1.12, 0, 1.28, 0.22], [1.32, 0, 1.42, 0.25], [1.62, 0, 1.3, 0.15], [1.88, 0, 1.2, 0.09]], wide: 0.85 },
    { spine: [[-1.05, 0, 0.55, 0.12], [-1.32, 0, 0.4, 0.14], [-1.4, 0, 0.15, 0.03]], tone: 1.6 },
    leg(0.55, 0.24, 0.1, 0.17), leg(-0.85, 0.26, 0.2, 0.2),
    fin([1.2, 0.1, 1.6], [1.3, 0.16, 1.55], [1.0, 0.5, 1.75]),
    { spine: [[1.25, 0.1, 1.6, 0.06], [1.1, 0.3, 2.1, 0.05], [1.4, 0.5, 2.6, 0.02]], tone: 1.5, pair: true },
    { spine: [[1.12, 0.28, 2.05, 0.05], [0.75, 0.5, 2.5, 0.02]], tone: 1.5, pair: true },
  ],
  goat: [
    { spine: [[-1.1, 0, 0.4, 0.08], [-1, 0, 0.25, 0.42], [-0.4, 0, 0.15, 0.55], [0.25, 0, 0.15, 0.52], [0.65, 0, 0.35, 0.42], [0.92, 0, 0.75, 0.26], [1.1, 0, 0.98, 0.26], [1.4, 0, 0.86, 0.17], [1.65, 0, 0.72, 0.1]] },
    { spine: [[-1.05, 0, 0.55, 0.1], [-1.25, 0, 0.85, 0.04]] },
    leg(0.55, 0.27, 0, 0.18), leg(-0.82, 0.28, 0.05, 0.2),
    { spine: [[1.15, 0.12, 1.15, 0.1], [1, 0.2, 1.6, 0.08], [0.6, 0.32, 1.75, 0.02]], tone: 0.55, pair: true },
    fin([1.02, 0.16, 1.12], [1.12, 0.2, 1], [0.9, 0.55, 0.85]), fin([1.6, 0, 0.66], [1.4, 0, 0.7], [1.45, 0, 0.3], 1.3, false),
  ],
  sheep: [
    { spine: [[-1.12, 0, 0.2, 0.3], [-0.85, 0, 0.22, 0.64], [0, 0, 0.27, 0.74], [0.6, 0, 0.27, 0.64], [0.85, 0, 0.45, 0.35]] },
    { spine: [[0.75, 0, 0.58, 0.26], [1.1, 0, 0.72, 0.27], [1.5, 0, 0.45, 0.14]], tone: 0.62 },
    leg(0.5, 0.3, -0.2, 0.16, 0.62), leg(-0.7, 0.3, -0.2, 0.16, 0.62), fin([1, 0.2, 0.85], [1.12, 0.22, 0.75], [0.95, 0.62, 0.7], 0.62),
  ],
  rabbit: [
    { spine: [[-1, 0, -0.4, 0.25], [-0.62, 0, -0.25, 0.62], [0, 0, -0.35, 0.58], [0.5, 0, -0.28, 0.42], [0.78, 0, 0.05, 0.33], [1.05, 0, 0.22, 0.32], [1.4, 0, 0.1, 0.12]] },
    { spine: [[-1.05, 0, -0.3, 0.1], [-1.18, 0, -0.22, 0.2], [-1.35, 0, -0.15, 0.05]], tone: 1.6 },
    { spine: [[0.9, 0.12, 0.42, 0.09], [0.72, 0.2, 0.95, 0.15], [0.6, 0.24, 1.4, 0.03]], tone: 0.85, pair: true },
    leg(0.55, 0.22, -0.4, 0.15), { spine: [[-0.2, 0.38, -0.88, 0.1], [-0.85, 0.38, -0.85, 0.16]], tone: 0.8, pair: true },
  ],
  wolf: [ // with a dark saddle, pale legs and chin, and a hanging tail
    { spine: [[-1.2, 0, 0.4, 0.1], [-1.02, 0, 0.34, 0.36], [-0.45, 0, 0.24, 0.36], [0.2, 0, 0.18, 0.5], [0.68, 0, 0.26, 0.5], [1.02, 0, 0.5, 0.44], [1.28, 0, 0.72, 0.38], [1.5, 0, 0.74, 0.33], [1.68, 0, 0.66, 0.24], [2.05, 0, 0.56, 0.19], [2.14, 0, 0.54, 0.1]], wide: 0.78, tone: 1.3 },
    { spine: [[-1.17, 0, 0.48, 0.14], [-0.95, 0, 0.42, 0.36], [-0.4, 0, 0.34, 0.37], [0.2, 0, 0.34, 0.48], [0.7, 0, 0.44, 0.48], [1.05, 0, 0.7, 0.4], [1.28, 0, 0.86, 0.31], [1.5, 0, 0.86, 0.24], [1.72, 0, 0.78, 0.14]], wide: 0.5, tone: 0.5 },
    { spine: [[-1.12, 0, 0.42, 0.13], [-1.36, 0, 0.1, 0.17], [-1.5, 0, -0.3, 0.16], [-1.54, 0, -0.52, 0.03]], tone: 0.45 },
    leg(0.6, 0.22, 0.1, 0.17, 1.6), leg(-0.88, 0.22, 0.2, 0.2, 1.6),
    fin([1.36, 0.08, 1.02], [1.56, 0.24, 0.96], [1.44, 0.26, 1.28], 0.42),
    { spine: [[1.45, 0, 0.54, 0.26], [1.75, 0, 0.48, 0.19], [2.06, 0, 0.46, 0.12]], tone: 1.75 }, { spine: [[2.08, 0, 0.63, 0.1], [2.2, 0, 0.6, 0.06]], tone: 0.2 },
  ],
  bird: [
    { spine: [[-0.95, 0, 0.6, 0.08], [-0.4, 0, 0.6, 0.3], [0.3, 0, 0.62, 0.34], [0.75, 0, 0.72, 0.24], [1, 0, 0.78, 0.2], [1.14, 0, 0.74, 0.09]] },
    { spine: [[1.1, 0, 0.74, 0.09], [1.5, 0, 0.66, 0.02]], tone: 1.6 },
    fin([0.5, 0.2, 0.75], [-0.4, 0.2, 0.7], [0.2, 1.1, 0.95]), fin([-0.4, 0.2, 0.7], [0.2, 1.1, 0.95], [-0.35, 1.1, 0.9], 0.8),
    fin([0.2, 1.1, 0.95], [-0.35, 1.1, 0.9], [-0.4, 2, 0.85], 0.75), fin([-0.7, 0, 0.62], [-1.6, 0.5, 0.62], [-1.6, -0.5, 0.62], 0.75, false),
  ],
  fish: [
    { spine: [[-1.25, 0, 0, 0.12], [-0.6, 0, 0, 0.42], [0.35, 0, 0, 0.55], [1.1, 0, 0, 0.34], [1.8, 0, 0, 0.03]], wide: 0.6 },
    fin([-1.1, 0, 0], [-2.1, 0, 0.85], [-1.75, 0, 0], 0.8, false), fin([-1.1, 0, 0], [-2.1, 0, -0.85], [-1.75, 0, 0], 0.8, false),
    fin([0.4, 0, 0.5], [-0.5, 0, 1.05], [-0.5, 0, 0.4], 0.8, false), fin([0.5, 0.3, -0.1], [-0.2, 0.85, -0.3], [-0.1, 0.3, -0.1], 0.8),
  ],
  krill: [
    { spine: [[-1.75, 0, -0.6, 0.05], [-1.3, 0, -0.28, 0.2], [-0.6, 0, 0.05, 0.32], [0.2, 0, 0.15, 0.4], [0.9, 0, 0.08, 0.34], [1.35, 0, 0, 0.1]] },
    fin([-1.6, 0, -0.5], [-2.2, 0.4, -0.75], [-2.1, 0, -0.9], 0.8), fin([1.2, 0.08, 0.1], [1.1, 0.14, 0.05], [2.5, 0.7, 0.3], 0.8),
    ...[-0.9, -0.3, 0.3, 0.8].map((x) => fin([x, 0.1, -0.15], [x + 0.2, 0.14, -0.2], [x + 0.25, 0.2, -0.85], 0.7)), { spine: [[1.2, 0.16, 0.12, 0.02], [1.3, 0.26, 0.16, 0.13], [1.42, 0.28, 0.16, 0.02]], tone: 0.25, pair: true },
  ],
  copepod: [ // with one eye, two egg sacs and a forked tail
    { spine: [[-0.75, 0, 0, 0.2], [-0.3, 0, 0, 0.5], [0.35, 0, 0.05, 0.68], [0.9, 0, 0.05, 0.5], [1.3, 0, 0, 0.05]], wide: 1.15 },
    { spine: [[-0.7, 0, 0, 0.22], [-1.3, 0, 0, 0.15], [-1.75, 0, 0, 0.1]], tone: 1.25 },
    { spine: [[1.05, 0, 0.3, 0.03], [1.17, 0, 0.3, 0.16], [1.29, 0, 0.22, 0.03]], tone: 2.4 },
    { spine: [[-0.75, 0.3, -0.05, 0.04], [-1.15, 0.42, -0.05, 0.27], [-1.6, 0.4, -0.05, 0.05]], tone: 1.7, pair: true },
    { spine: [[1.1, 0.15, 0.05, 0.1], [1, 1.1, 0.2, 0.08], [0.5, 2, 0.3, 0.06], [-0.3, 2.7, 0.3, 0.02]], tone: 1.25, pair: true },
    ...[0.1, 0.4, 0.7].map((x) => fin([x, 0.2, -0.4], [x + 0.12, 0.3, -0.4], [x - 0.35, 0.3, -0.95], 1.25)), fin([-1.7, 0, 0], [-1.75, 0.12, 0], [-2.6, 0.55, 0], 1.25),
  ],
  insect: [
    { spine: [[-1.3, 0, -0.2, 0.05], [-1, 0, -0.2, 0.4], [-0.3, 0, -0.15, 0.5], [0.1, 0, -0.2, 0.15], [0.5, 0, -0.15, 0.34], [0.75, 0, -0.2, 0.14], [1.1, 0, -0.15, 0.3], [1.35, 0, -0.25, 0.05]] },
    ...[-0.2, 0.3, 0.7].map((x) => fin([x, 0.2, -0.2], [x + 0.15, 0.2, -0.2], [1.8 * x - 0.3, 1.1, -1], 0.6)), fin([1.2, 0.1, 0], [1.25, 0.16, 0], [1.9, 0.5, 0.5], 0.6),
  ],
  beetle: [ // with a seam between its wing cases
    { spine: [[-1.3, 0, -0.55, 0.1], [-0.95, 0, -0.4, 0.55], [-0.2, 0, -0.3, 0.72], [0.45, 0, -0.35, 0.62], [0.6, 0, -0.4, 0.45]], wide: 1.1 },
    { spine: [[0.5, 0, -0.45, 0.5], [0.85, 0, -0.5, 0.46], [1.05, 0, -0.52, 0.3], [1.35, 0, -0.55, 0.26], [1.5, 0, -0.58, 0.08]], tone: 0.5 },
    fin([-1.2, 0, -0.3], [-0.2, 0.035, 0.44], [-0.2, -0.035, 0.44], 0.3, false), fin([0.55, 0, 0.08], [-0.2, -0.035, 0.44], [-0.2, 0.035, 0.44], 0.3, false),
    ...[-0.7, 0, 0.6].map((x) => fin([x, 0.5, -0.5], [x + 0.2, 0.5, -0.5], [1.7 * x - 0.1, 1.25, -1], 0.4)), fin([1.35, 0.1, -0.4], [1.4, 0.18, -0.45], [1.95, 0.6, -0.2], 0.4),
  ],
  worm: [{ spine: [[-2, 0.3, -0.8, 0.04], [-1.3, -0.2, -0.75, 0.22], [-0.5, 0.2, -0.75, 0.26], [0.3, -0.2, -0.75, 0.26], [1.1, 0.15, -0.72, 0.24], [1.6, 0, -0.7, 0.06]] }],
  turtle: [
    { spine: [[-1.1, 0, -0.3, 0.3], [-0.5, 0, -0.1, 0.75], [0.3, 0, -0.1, 0.8], [0.9, 0, -0.3, 0.4]], wide: 1.3 }, { spine: [[0.8, 0, -0.3, 0.2], [1.2, 0, -0.1, 0.24], [1.5, 0, -0.15, 0.1]], tone: 1.3 },
    { spine: [[0.55, 0.6, -0.5, 0.2], [0.75, 0.85, -1, 0.2]], tone: 1.3, pair: true }, { spine: [[-0.65, 0.6, -0.5, 0.2], [-0.85, 0.8, -1, 0.2]], tone: 1.3, pair: true },
  ],
  tree: [{ spine: [[0, 0, -1, 0.26], [0, 0, 1.2, 0.18]], tone: 0.5 }, { spine: [[0, 0, 0.7, 0.5], [0, 0, 1.4, 1.25], [0, 0, 2.4, 1.2], [0, 0, 3.3, 0.75], [0, 0, 3.8, 0.1]] }],
  conifer: [{ spine: [[0, 0, -1, 0.22], [0, 0, 0.4, 0.18]], tone: 0.5 }, { spine: [[0, 0, 0, 1.1], [0, 0, 1.4, 0.5], [0, 0, 1.4, 0.9], [0, 0, 2.7, 0.35], [0, 0, 2.7, 0.6], [0, 0, 4.2, 0.02]] }],
  clover: [ // with two round heads of flowers
    ...trefoil(0.1, 0.1, 0.1, 0.62, 0.3), ...trefoil(0.75, -0.35, -0.25, 0.55, 1.2), ...trefoil(-0.65, -0.5, -0.1, 0.58, 2.3), ...trefoil(-0.55, 0.7, -0.3, 0.55, 0.9), ...trefoil(0.6, 0.8, -0.15, 0.5, 2),
    clump(-0.15, -0.1, 0.75, 0.26, 2.3), clump(0.4, 0.3, 0.55, 0.22, 2.1), fin([0, 0, -1], [0.08, 0, -1], [-0.15, -0.1, 0.6], 0.6, false), fin([0.1, 0.1, -1], [0.18, 0.1, -1], [0.4, 0.3, 0.4], 0.6, false),
  ],
  shrub: [ // clumps of leaves on stems
    clump(0, 0, 0.55, 0.45), clump(0.55, 0, 0.2, 0.4, 0.85), clump(-0.55, 0.05, 0.3, 0.42, 1.15), { ...clump(0.1, 0.5, 0.15, 0.4, 1.08), pair: true }, { ...clump(-0.4, 0.6, -0.1, 0.32, 0.8), pair: true }, clump(0.75, 0.3, -0.15, 0.3, 1.2),
    ...[[0.55, 0], [-0.5, 0.05], [0.1, 0.5], [-0.4, 0.55]].map(([x, y]) => ({ spine: [[0.2 * x, 0.2 * y, -1, 0.09], [x, y, 0.1, 0.05]], tone: 0.45, pair: y > 0.2 })),
  ],
  carcass: [ // on its side, with legs to the left, bare ribs and a skull
    { spine: [[-1.3, 0.1, -0.85, 0.1], [-1, 0.05, -0.7, 0.36], [-0.6, 0, -0.72, 0.3], [0, -0.1, -0.85, 0.18], [0.5, 0, -0.68, 0.34], [0.8, 0.05, -0.7, 0.26], [1.1, 0, -0.8, 0.15]], wide: 1.2 },
    { spine: [[1.05, 0, -0.8, 0.14], [1.3, 0.1, -0.74, 0.26], [1.55, 0.22, -0.8, 0.2], [1.95, 0.4, -0.88, 0.07]], tone: 1.85 },
    { spine: [[1.3, 0, -0.6, 0.07], [1.2, -0.3, -0.3, 0.05], [1, -0.5, -0.1, 0.02]], tone: 1.5 },
    ...[-0.62, -0.32, -0.02, 0.28].map((x) => ({ spine: [[x, -0.45, -0.8, 0.06], [x + 0.03, -0.42, -0.35, 0.07], [x + 0.05, -0.1, 0.02, 0.07], [x + 0.05, 0.3, -0.08, 0.06], [x + 0.03, 0.55, -0.45, 0.03]], tone: 1.8 })),
    ...[[0.62, 0.9, -0.9], [0.35, 0.25, -0.68], [-0.85, -0.6, -0.9], [-1.1, -1.35, -0.62]].map(([x, to, z]) => ({ spine: [[x, 0.2, -0.7, 0.2], [0.6 * x + 0.4 * to, 0.85, z, 0.11], [to, 1.5, z - 0.02, 0.07]], tone: 0.7 })),
  ],
};
SHAPES.doe = SHAPES.deer.slice(0, -2); // without antlers

/** Shapes of names that are not themselves shapes. */
const NAMED = {
  deer: "stag elk moose reindeer caribou", doe: "fawn horse antelope gazelle impala zebra donkey giraffe", goat: "ibex chamois kid cow cattle bison wildebeest", sheep: "ewe lamb ram pig boar",
  rabbit: "hare vole mouse rat lemming squirrel marmot", wolf: "fox dog coyote hyena lion lioness lynx cat tiger leopard cheetah jackal weasel stoat bear predator",
  bird: "raven crow gull kite hawk eagle owl vulture finch sparrow tit robin penguin duck goose swallow", fish: "eel cod herring trout salmon perch pike sardine anchovy shark tuna minnow guppy stickleback",
  krill: "shrimp prawn", copepod: "daphnia zooplankton rotifer", insect: "ant bee aphid fly moth butterfly grasshopper locust wasp mosquito cricket", beetle: "bug ladybird", worm: "earthworm nematode",
  tree: "oak beech birch maple ash acacia", conifer: "pine spruce fir", carcass: "corpse carrion", shrub: "bush heather", clover: "trefoil",
};

/** @type {Record<string, string>} */
const LOOKS = Object.fromEntries([["turtle", ""], ...Object.entries(NAMED)].flatMap(([shape, names]) => [shape, ...names.split(" ").filter(Boolean)].map((name) => [name, shape])));

/** The shape that a species is named after (its last word, singular or plural), or undefined. @param {string} name @returns {string | undefined} */
export const lookOf = (name) => {
  const word = name.toLowerCase().split(/[^a-z]+/).filter(Boolean).at(-1) ?? "";
  return LOOKS[word] ?? LOOKS[word.replace(/s$/, "")] ?? LOOKS[word.replace(/es$/, "")] ?? LOOKS[{ wolves: "wolf", mice: "mouse" }[word] ?? ""];
};

/** How a shape moves: 1 with legs, 2 with wings, 3 with its tail, 0 rigidly. @param {string} shape */
export const gaitOf = (shape) => (shape === "bird" ? 2 : ["fish", "krill", "copepod", "worm"].includes(shape) ? 3 : ["tree", "conifer", "shrub", "clover", "carcass", "insect", "beetle"].includes(shape) ? 0 : 1);

/**
 * How a kind is drawn, in the scene and as an icon: "box", "capsule", a shape of this file or, for plants and objects, "disc" or (lying flat) "plate".
 * @param {import("./protocol.js").Kind} kind
 */
export const formOf = ({ shape, build, inanimate, solid }) => shape ?? build ?? (inanimate && !solid ? "plate" : "disc");

const AROUND = 7;

/** Variants of a shape for kinds that are not named after one: the second is longer, the third broader, and so on. */
const VARIANTS = [[1, 1], [1.25, 0.78], [0.82, 1.18], [1.4, 0.62]];

/** The corners of a ring of a tube. @param {number[][]} spine @param {number} i @param {number} wide @param {number[]} angles */
function ring(spine, i, wide, angles) {
  const [a, b] = [spine[Math.max(0, i - 1)], spine[Math.min(spine.length - 1, i + 1)]];
  const [dx, dy, dz] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], length = Math.hypot(dx, dy, dz) || 1, flat = Math.hypot(dx, dz);
  const up = flat ? [-dz / flat, 0, dx / flat] : [0, 0, 1], left = flat ? [(-dx * dy) / (flat * length), flat / length, (-dz * dy) / (flat * length)] : [1, 0, 0];
  const [x, y, z, r] = spine[i];
  return angles.map((angle) => [x, y, z].map((middle, axis) => middle + r * (Math.sin(angle) * up[axis] + wide * Math.cos(angle) * left[axis])));
}

/**
 * Corners, normals and brightness of a shape, and its facets as triples of corners. The facets of a part share corners, so that a shape of
 * 450 facets is computed from some 250 corners instead of 1350, and share normals at them.
 * @param {string} shape
 * @param {number} variant index among kinds of the same type
 */
export function animal(shape, variant = 0) {
  const [long, broad] = VARIANTS[variant % VARIANTS.length];
  const angles = Array.from({ length: AROUND }, (_, k) => (2 * Math.PI * k) / AROUND);
  /** @type {Corner[]} */
  const corners = [];
  /** @type {Corner[]} */
  const normals = [];
  /** @type {number[]} */
  const tones = [];
  /** @type {number[]} */
  const facets = [];
  /** @type {(part: Corner[], own: number[][], tone: number) => void} */
  const add = (part, own, tone) => {
    const first = corners.length;
    for (const [x, y, z] of part) corners.push([long * x, broad * y, z < 0 ? z : broad * z]), normals.push([0, 0, 0]), tones.push(tone);
    for (const facet of own.map((ends) => ends.map((k) => first + k))) {
      const [a, b, c] = facet.map((k) => corners[k]);
      const [u, v] = [b, c].map((end) => end.map((value, axis) => value - a[axis]));
      const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      for (const k of facet) normal.forEach((value, axis) => (normals[k][axis] += value));
      facets.push(...facet);
    }
  };
  for (const { spine, fin, wide = 1, tone = 1, pair } of SHAPES[shape]) {
    const part = fin ?? (spine ?? []).flatMap((_, i, line) => ring(line, i, wide, angles)), last = part.length - AROUND;
    /** @type {number[][]} */
    const own = fin ? [[0, 1, 2]] : [];
    for (let k = 2; spine && k < AROUND; k++) own.push([k, k - 1, 0], [last, last + k - 1, last + k]);
    for (let k = 0; spine && k < last; k++) {
      const next = k % AROUND === AROUND - 1 ? k + 1 - AROUND : k + 1;
      own.push([k, next, k + AROUND], [k + AROUND, next, next + AROUND]);
    }
    add(part, own, tone);
    if (pair) add(part.map(([x, y, z]) => [x, -y, z]), own.map((ends) => ends.toReversed()), tone);
  }
  const unit = normals.map((normal) => normal.map((value) => value / (Math.hypot(...normal) || 1)));
  return { corners: new Float32Array(corners.flat()), normals: new Float32Array(unit.flat()), tones: new Float32Array(tones), facets };
}

/** The outline of a shape seen from the right, as polygons of x and z, for icons. @param {string} shape @param {number} variant */
export function outline(shape, variant = 0) {
  const [long, broad] = VARIANTS[variant % VARIANTS.length];
  return SHAPES[shape].map(({ spine, fin }) => {
    const corners = fin ?? (spine ?? []).map((_, i, line) => ring(line, i, 1, [Math.PI / 2])[0]).concat((spine ?? []).map((_, i, line) => ring(line, i, 1, [-Math.PI / 2])[0]).toReversed());
    return corners.map(([x, , z]) => [long * x, z < 0 ? z : broad * z]);
  });
}

/** Corners and normals of a soft shadow: two triangles on the ground. */
export function shadow() {
  const [a, b, c, d] = [[-1.9, -1.3, -1], [1.9, -1.3, -1], [-1.9, 1.3, -1], [1.9, 1.3, -1]];
  return new Float32Array([a, b, c, c, b, d].flat());
}

/** Corners and normals of a box, three each per facet. */
export function box() {
  /** @type {number[]} */
  const corners = [];
  /** @type {number[]} */
  const normals = [];
  for (let axis = 0; axis < 3; axis++)
    for (const end of [-1, 1])
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
        const corner = [0, 0, 0], normal = [0, 0, 0];
        corner[axis] = normal[axis] = end;
        corner[(axis + 1) % 3] = u;
        corner[(axis + 2) % 3] = v;
        corners.push(...corner);
        normals.push(...normal);
      }
  return { corners: new Float32Array(corners), normals: new Float32Array(normals), tones: new Float32Array(corners.length / 3).fill(1) };
}

/** Corners and normals of a capsule: a sphere cut in half, with one half at each end. */
export function capsule(around = 12, along = 8) {
  /** @type {number[]} */
  const corners = [];
  /** @type {number[]} */
  const normals = [];
  /** @param {number} i @param {number} j @param {number} end */
  const put = (i, j, end) => {
    const a = (Math.PI * i) / along, b = (2 * Math.PI * j) / around;
    corners.push(end, 0, 0);
    normals.push(-Math.cos(a), Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b));
  };
  for (let j = 0; j < around; j++) {
    const bands = [];
    for (let i = 0; i < along; i++) bands.push([i, i + 1, i < along / 2 ? -1 : 1, i < along / 2 ? -1 : 1]);
    bands.push([along / 2, along / 2, -1, 1]); // the straight part
    for (const [i, k, from, to] of bands) {
      put(i, j, from);
      put(k, j, to);
      put(k, j + 1, to);
      put(i, j, from);
      put(k, j + 1, to);
      put(i, j + 1, from);
    }
  }
  return { corners: new Float32Array(corners), normals: new Float32Array(normals), tones: new Float32Array(corners.length / 3).fill(1) };
}
