// The shapes of bodies. Who hunts what moves is a dart, other animals are eggs, their noses ahead (+x), in radii of the body; capsules and boxes are a box,
// −1 or 1 along each axis, whose corners the shader moves outwards along `facing` by the rounding.

const NOSE = [1.75, 0, 0];
const TAIL = [-0.65, 0, 0.05];
const LEFT = [-1.15, 0.95, -0.1];
const RIGHT = [-1.15, -0.95, -0.1];
const BACK = [-0.35, 0, 0.75];
const BELLY = [-0.35, 0, -0.55];

const FACETS = [
  [NOSE, LEFT, BACK], [NOSE, BACK, RIGHT], [BACK, LEFT, TAIL], [BACK, TAIL, RIGHT],
  [NOSE, BELLY, LEFT], [NOSE, RIGHT, BELLY], [BELLY, TAIL, LEFT], [BELLY, RIGHT, TAIL],
];

/** Corners and normals of some facets, three of each. @param {number[][][]} facets */
function faceted(facets) {
  const corners = new Float32Array(facets.length * 9);
  const normals = new Float32Array(facets.length * 9);
  facets.forEach(([a, b, c], i) => {
    const u = b.map((value, axis) => value - a[axis]);
    const v = c.map((value, axis) => value - a[axis]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...normal) || 1;
    for (const [k, corner] of [a, b, c].entries()) {
      corners.set(corner, 9 * i + 3 * k);
      normals.set(normal.map((value) => value / length), 9 * i + 3 * k);
    }
  });
  return { corners, normals };
}

/** A hunter: a dart with swept wings. */
export const dart = () => faceted(FACETS);

/** Half of the width of an egg along its length, from the tail to the nose. */
const GIRTH = [[-1.05, 0], [-0.8, 0.62], [-0.1, 0.82], [0.65, 0.5], [1.35, 0]];
const AROUND = 6;

/** Who hunts nobody: an egg, its thin end ahead. */
export function egg() {
  const at = (/** @type {number} */ i, /** @type {number} */ k) => {
    const angle = (2 * Math.PI * k) / AROUND;
    const [x, r] = GIRTH[i];
    return [x, r * Math.cos(angle), 0.75 * r * Math.sin(angle)];
  };
  const facets = [];
  for (let i = 0; i + 1 < GIRTH.length; i++)
    for (let k = 0; k < AROUND; k++) {
      if (GIRTH[i][1]) facets.push([at(i, k), at(i + 1, k), at(i, k + 1)]);
      if (GIRTH[i + 1][1]) facets.push([at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)]);
    }
  return faceted(facets);
}

/** Corners and normals of a box, three of each a facet. */
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
  return { corners: new Float32Array(corners), normals: new Float32Array(normals) };
}

/** The same of a capsule: a sphere, cut in two halves that lie at both ends. */
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
  return { corners: new Float32Array(corners), normals: new Float32Array(normals) };
}
