// The shape of a moving animal: a dart, its nose ahead (+x), eight facets, in radii of the body.

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

/** Corners and normals, three of each a facet. */
export function dart() {
  const corners = new Float32Array(FACETS.length * 9);
  const normals = new Float32Array(FACETS.length * 9);
  FACETS.forEach(([a, b, c], i) => {
    const u = b.map((value, axis) => value - a[axis]);
    const v = c.map((value, axis) => value - a[axis]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...normal);
    for (const [k, corner] of [a, b, c].entries()) {
      corners.set(corner, 9 * i + 3 * k);
      normals.set(normal.map((value) => value / length), 9 * i + 3 * k);
    }
  });
  return { corners, normals };
}
