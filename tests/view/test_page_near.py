"""Animals near the camera are drawn as bodies, also if there are too many for all to be bodies."""

import numpy as np

from tests.view.pages import IN_A_BROWSER

pytestmark = IN_A_BROWSER
SIZE, RADIUS, LENS, MOST = 100.0, 0.3, 600.0, 3000
MADE = """async ({places, eyes}) => {
  const {Layer} = await import('/layer.js'), {PerspectiveCamera} = await import('/vendor.js');
  const kind = {name: 'deer', build: 'deer', moves: true, radius: 0.3}, group = {add() {}, remove() {}};
  const layer = new Layer(kind, group, {size: {value: {z: 0}}}), n = places.length;
  const words = new Uint16Array(6 * n), longs = new Uint32Array(words.buffer);
  places.forEach(([x, y], k) => (words.set([x, y], 6 * k), (longs[3 * k + 2] = k)));
  layer.own.least.value = 2;
  layer.take({n, words, longs, upper: null, genes: null}, 1, true);
  let chose = 0;
  const close = layer.close.bind(layer);
  layer.close = (...all) => (chose++, close(...all));
  const camera = new PerspectiveCamera(36, 1.5, 0.1, 2000);
  camera.up.set(0, 0, 1);
  const stage = {eye: {camera, levels: [0, 0]}, shared: {lens: {value: 600}}, relief: {nx: 0, at: () => 0},
    hello: {size: [100, 100]}, renderer: {getPixelRatio: () => 1}};
  return eyes.map(([from, to]) => {
    camera.position.set(...from);
    camera.lookAt(...to);
    layer.choose(stage);
    layer.choose(stage);
    const {near, form: {geometry}} = layer, count = geometry.drawRange.count;
    const rows = geometry.index ? [...geometry.index.array.slice(0, count)] : [...Array(count).keys()];
    const bodies = near ? Array.from({length: near.n}, (_, k) => near.arrays[0][6 * k + 4]) : [];
    const view = [...camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements];
    return [rows, bodies, near?.geometry.instanceCount ?? 0, view, chose];
  });
}"""


def test_those_in_view_that_are_large_enough_are_bodies_and_all_others_points(page):
    places = np.random.default_rng(5).integers(0, 65536, (20_000, 2))
    eyes = [
        [[50, -300, 250], [50, 50, 0]],  # the whole world
        [[50, 30, 4], [50, 60, 0]],  # a part
        [[50, 30, 4], [60, 60, 0]],  # turned
        [[50, 50, 44], [50, 51, 0]],  # from above: too many
        [[50, -300, 250], [50, 50, 0]],
    ]
    seen = page.evaluate(MADE, {"places": places.tolist(), "eyes": eyes})
    x, y = places.T / 65535 * SIZE
    counts = []
    for times, (points, bodies, drawn, view, chose) in enumerate(seen, 1):
        assert chose == times  # the second time, nothing has changed
        assert drawn == len(bodies) <= MOST
        assert sorted(points + bodies) == list(range(len(places)))
        across, up, _, depth = np.array(view).reshape(4, 4).T @ np.stack(
            [x, y, np.full_like(x, RADIUS), x * 0 + 1]
        )
        margin = 4 * RADIUS / np.tan(np.radians(18))
        large = (depth > 0) & (RADIUS * LENS / np.maximum(depth, 1e-9) >= 4)
        inside = large & (np.abs(across) < depth) & (np.abs(up) < depth)
        body = np.isin(np.arange(len(places)), bodies)
        assert not (body & (depth > 0) & ~large).any()
        assert not (body & (np.abs(across) > depth + margin + 1e-3)).any()
        missing = inside & ~body
        if missing.any():
            assert len(bodies) > 0.8 * MOST
            assert depth[missing].min() > depth[body].max() - 1e-3  # the nearest come first
        counts.append(len(bodies))
    assert counts[0] == counts[-1] == 0
    assert 100 < counts[1] < MOST
    assert counts[3] > 0.8 * MOST
