// The shapes of bodies. Each kind of animal has a silhouette that depends on its diet, habitat and variant. Lengths are in body radii.
// Forward is +x. Capsules and boxes start as cubes from −1 to 1 along each axis; the shader moves their corners outward along `facing` by the rounding.

/** @typedef {number[]} Corner x, y (left) and z (up) */
/** @typedef {{girth: number[][], flat?: number, fins?: Corner[][]}} Build half width along the body from tail to nose; ratio of height to width; triangles */

const both = (/** @type {Corner[][]} */ fins) => fins.flatMap((fin) => [fin, fin.map(([x, y, z]) => [x, -y, z])]);

/** @type {Record<string, Build>} */
const BUILDS = {
  // on land: hunters are slender, with a wide chest, ears and a tail; grazers are plump, with antlers; scavengers have wings
  hunter: { girth: [[-1.3, 0.1], [-0.8, 0.34], [0.2, 0.5], [0.8, 0.3], [1.15, 0.36], [2.1, 0]],
    fins: [[[-1.2, 0.2, 0.1], [-1.2, -0.2, 0.1], [-2.3, 0, 0.5]], ...both([[[0.75, 0.15, 0.3], [0.95, 0.62, 0.7], [1.2, 0.2, 0.3]], [[0.75, 0.3, -0.1], [-0.1, 0.4, -0.1], [-0.35, 1.15, -0.4]], [[-0.4, 0.3, -0.1], [-1.0, 0.3, -0.1], [-1.5, 0.95, -0.4]]])] },
  grazer: { girth: [[-1.2, 0], [-0.95, 0.68], [-0.1, 0.92], [0.6, 0.62], [0.95, 0.3], [1.25, 0.34], [1.6, 0]], flat: 0.8,
    fins: both([[[1.0, 0.16, 0.35], [0.95, 0.4, 0.4], [1.55, 1.05, 0.95]], [[1.2, 0.5, 0.6], [1.3, 0.75, 0.75], [0.75, 1.15, 0.9]]]) },
  scavenger: { girth: [[-0.9, 0.1], [-0.3, 0.34], [0.4, 0.34], [0.9, 0.2], [1.4, 0]],
    fins: [...both([[[0.55, 0.2, 0.25], [-0.45, 0.2, 0.25], [-0.55, 1.95, 0.45]]]), [[-0.7, 0, 0.1], [-1.6, 0.5, 0.1], [-1.6, -0.5, 0.1]]] },
  // in water: fish with an upright tail; small grazers with long antennae
  "hunter water": { girth: [[-1.25, 0.1], [-0.6, 0.42], [0.35, 0.55], [1.1, 0.34], [1.8, 0]], flat: 1.25,
    fins: [[[-1.1, 0, 0], [-2.1, 0, 0.85], [-1.75, 0, 0]], [[-1.1, 0, 0], [-2.1, 0, -0.85], [-1.75, 0, 0]], [[0.4, 0, 0.6], [-0.5, 0, 1.15], [-0.5, 0, 0.5]], ...both([[[0.5, 0.4, -0.1], [-0.2, 1.0, -0.25], [-0.1, 0.4, -0.1]]])] },
  "grazer water": { girth: [[-1.15, 0.1], [-0.6, 0.34], [0.1, 0.74], [0.75, 0.6], [1.15, 0]], flat: 0.85,
    fins: both([[[0.95, 0.12, 0.1], [0.7, 0.3, 0.1], [-0.35, 1.75, 0.35]], [[-1.1, 0, 0], [-1.25, 0.06, 0], [-1.85, 0.5, 0]]]) },
  "scavenger water": { girth: [[-1.1, 0.3], [-0.5, 0.85], [0.3, 0.9], [0.9, 0.5], [1.2, 0]], flat: 0.5,
    fins: both([[[0.8, 0.5, 0.1], [1.1, 0.9, 0.1], [1.6, 0.55, 0.1]], [[0.0, 0.8, 0], [-0.4, 1.35, -0.3], [-0.3, 0.7, 0]]]) },
};

/** Corners and normals of facets, three each per facet. @param {number[][][]} facets */
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

const AROUND = 6;

/** Variants of a silhouette for kinds of the same type: the second is longer, the third broader, and so on. */
const VARIANTS = [[1, 1], [1.25, 0.78], [0.82, 1.18], [1.4, 0.62]];

/**
 * The silhouette of a kind.
 * @param {string} build
 * @param {number} variant index among kinds of the same type
 */
export function animal(build, variant = 0) {
  const { girth, flat = 0.75, fins = [] } = BUILDS[build] ?? BUILDS.grazer;
  const [long, wide] = VARIANTS[variant % VARIANTS.length];
  const at = (/** @type {number} */ i, /** @type {number} */ k) => {
    const angle = (2 * Math.PI * k) / AROUND;
    const [x, r] = girth[i];
    return [x, r * Math.cos(angle), flat * r * Math.sin(angle)];
  };
  const facets = [...fins];
  for (let i = 0; i + 1 < girth.length; i++)
    for (let k = 0; k < AROUND; k++) {
      if (girth[i][1]) facets.push([at(i, k), at(i + 1, k), at(i, k + 1)]);
      if (girth[i + 1][1]) facets.push([at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)]);
    }
  return faceted(facets.map((facet) => facet.map(([x, y, z]) => [long * x, wide * y, wide * z])));
}

/** The outline of a silhouette seen from above, as polygons of x and y, for icons. @param {string} build @param {number} variant */
export function outline(build, variant = 0) {
  const { girth, fins = [] } = BUILDS[build] ?? BUILDS.grazer;
  const [long, wide] = VARIANTS[variant % VARIANTS.length];
  const body = [...girth, ...girth.toReversed().map(([x, r]) => [x, -r])];
  const upright = (/** @type {Corner[]} */ fin) => fin.every(([, y]) => y === 0); // a line when seen from above, so drawn lying flat
  return [body, ...fins.map((fin) => fin.map(([x, y, z]) => [x, upright(fin) ? 0.8 * z : y]))].map((polygon) => polygon.map(([x, y]) => [long * x, wide * y]));
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
  return { corners: new Float32Array(corners), normals: new Float32Array(normals) };
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
  return { corners: new Float32Array(corners), normals: new Float32Array(normals) };
}
