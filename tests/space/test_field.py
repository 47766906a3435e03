import numpy as np
import pytest

from ecs_eco.space import Field, Space

SPACES = [
    ((12, 8), "torus"),
    ((12, 8), "walls"),
    ((12, 8, 6), "torus"),
    ((12, 8, 6), "walls"),
    ((12, 2), "torus"),
    ((3, 1), "torus"),
]


def _f(*values):
    return np.array(values, np.float32)


def _emit(field, place, amount):
    x, y, z = [*place, 0.0][:3]
    field.emit(_f(x), _f(y), _f(z), _f(amount))


def _slow_step(c, a, torus, keep):
    """One explicit step of Fick's second law, cell by cell, as flows between neighbours that cancel."""
    new = c.astype(float).copy()
    for index in np.ndindex(*c.shape):
        for axis in range(3):
            n = c.shape[axis]
            neighbour = list(index)
            neighbour[axis] += 1
            if neighbour[axis] == n:
                if not (torus and axis > 0):
                    continue
                neighbour[axis] = 0
            if tuple(neighbour) == index:
                continue
            flow = a[2 - axis] * (float(c[index]) - float(c[tuple(neighbour)]))
            new[index] -= flow
            new[tuple(neighbour)] += flow
    return new * keep


@pytest.mark.parametrize(("size", "edges"), SPACES)
def test_diffusion_is_that_of_the_slow_twin(size, edges):
    field = Field(Space(size, edges), 1.0, diffusion=0.2, decay=0.3)
    field.value[...] = np.random.default_rng(0).random(field.value.shape)
    expected = _slow_step(
        field.value, [0.2 * 1.0] * len(size) + [0.0] * (3 - len(size)), field.space.torus, np.exp(-0.3)
    )
    field.pass_time(1.0)  # one step: 0.2 * dims * 2 / 0.9 < 1.4, so two for a volume
    if len(size) == 3:
        field.value[...] = np.random.default_rng(0).random(field.value.shape)
        half = np.exp(-0.15)
        once = _slow_step(field.value, [0.1] * 3, field.space.torus, half)
        expected = _slow_step(once, [0.1] * 3, field.space.torus, half)
        field.pass_time(1.0)
    assert np.allclose(field.value, expected, atol=1e-6)


@pytest.mark.parametrize(("size", "edges"), SPACES)
@pytest.mark.parametrize("diffusion", [0.05, 3.0])
def test_mass_is_conserved_without_decay_and_fades_exponentially_with_it(size, edges, diffusion):
    for decay in (0.0, 0.25):
        field = Field(Space(size, edges), 1.0, diffusion, decay)
        _emit(field, [0.5 * s for s in size], 5.0)
        _emit(field, [0.01] * len(size), 2.0)
        for _ in range(8):
            field.pass_time(0.5)
        arrives = -np.expm1(-decay * 0.5) / (decay * 0.5) if decay else 1.0  # it flows in over the first tick
        assert field.value.sum(dtype=float) == pytest.approx(7.0 * arrives * np.exp(-decay * 3.5), rel=1e-5)
        assert field.value.min() >= 0


@pytest.mark.parametrize("dt", [0.1, 1.0, 5.0])
def test_a_steady_source_comes_to_what_it_gives_over_what_decays(dt):
    field = Field(Space((8, 6)), 1.0, diffusion=0.3, decay=0.5)
    for _ in range(round(40 / dt)):
        _emit(field, (2.5, 2.5), 1.0 * dt)
        field.pass_time(dt)
    assert field.value.sum(dtype=float) == pytest.approx(2.0, rel=1e-4)


@pytest.mark.parametrize("dt", [0.1, 1.0, 5.0])
def test_decay_renewal_and_a_source_together_follow_the_exact_course(dt):
    field = Field(Space((4, 4)), 1.0, diffusion=0.3, decay=0.5)
    field.contain("sugar", 1.0, np.full((1, 4, 4), 3.0), 0.25)
    for _ in range(round(10 / dt)):
        field.emit(_f(0.5), _f(0.5), _f(0), np.array([16 * 0.75 * dt]))
        field.pass_time(dt)
    balance = (0.75 + 0.25 * 3.0) / 0.75  # source + renewal over all losses
    mean = field.held() / field.litres / 16
    assert mean == pytest.approx(balance + (3.0 - balance) * np.exp(-0.75 * 10), rel=1e-6)


def test_variance_grows_by_two_d_t_along_each_axis():
    field = Field(Space((60, 60, 60)), 1.0, diffusion=1.5)
    _emit(field, (30.5, 30.5, 30.5), 1.0)
    for _ in range(10):
        field.pass_time(1.0)
    c = field.value.astype(float)
    at = np.arange(60) - 30.0
    for axis in range(3):
        profile = c.sum(axis=tuple(a for a in range(3) if a != axis))
        assert (profile * at).sum() == pytest.approx(0, abs=1e-4)
        assert (profile * at**2).sum() == pytest.approx(2 * 1.5 * 10, rel=1e-3)


def test_a_point_in_time_spreads_evenly_in_the_end():
    field = Field(Space((4, 4), "walls"), 1.0, diffusion=2.0)
    _emit(field, (0.5, 0.5), 16.0)
    field.pass_time(200.0)
    assert np.allclose(field.value, 1.0, atol=1e-4)


def test_emitted_amounts_land_in_the_cell_of_the_place_with_the_next_tick():
    field = Field(Space((4, 3)), 1.0)
    field.emit(_f(0.5, 3.999, 0.5), _f(0.5, 2.999, 0.9), _f(0, 0, 0), _f(1, 2, 4))
    assert field.value.sum() == 0
    field.pass_time(1.0)
    assert field.value[0, 0, 0] == 5
    assert field.value[0, 2, 3] == 2
    field.pass_time(1.0)
    assert field.value.sum() == 7  # once only


@pytest.mark.parametrize(("size", "edges"), SPACES)
def test_samples_are_linear_between_the_centres_of_cells(size, edges):
    rng = np.random.default_rng(4)
    space = Space(size, edges)
    field = Field(space, 1.0)
    field.value[...] = rng.random(field.value.shape)
    p = np.array([rng.random(200) * s for s in (*size, 0.0)[:3]], np.float32)
    out = np.empty(200, np.float32)
    field.sample(*p, out)

    def corner(i, j, k):
        nz, ny, nx = field.value.shape
        i, j = (i % nx, j % ny) if space.torus else (np.clip(i, 0, nx - 1), np.clip(j, 0, ny - 1))
        return float(field.value[np.clip(k, 0, nz - 1), j, i])

    for n in range(200):
        g = p[:, n] * field.inverse - 0.5
        base = np.floor(g).astype(int)
        f = g - base
        expected = sum(
            np.prod([f[a] if d[a] else 1 - f[a] for a in range(3)]) * corner(*(base + d))
            for d in (np.array(b) for b in np.ndindex(2, 2, 2))
        )
        assert out[n] == pytest.approx(expected, abs=1e-5)


def test_at_a_centre_a_sample_is_the_cells_value():
    field = Field(Space((4, 3)), 1.0)
    field.value[...] = np.arange(12).reshape(1, 3, 4)
    out = np.empty(2, np.float32)
    field.sample(_f(2.5, 0.0), _f(1.5, 0.5), _f(0, 0), out)
    assert out.tolist() == [6, (0 + 3) / 2]  # on the seam: between the first cell and the last


def test_cells_fit_the_space():
    field = Field(Space((10, 7, 5)), 2.0)
    assert field.shape == (5, 4, 2)
    assert field.value.shape == (2, 4, 5)
    assert Field(Space((10, 7)), 100.0).value.shape == (1, 1, 1)
