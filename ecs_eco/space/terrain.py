"""A height map with slopes that cost energy and cells that block walkers: lakes, rocks, steep mountains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import arrays, power
from ecs_eco.compiled.jit import njit
from ecs_eco.engine import random
from ecs_eco.space.geometry import Space, cell_of, cells_of, floor_between, half_cells, into

if TYPE_CHECKING:
    from ecs_eco.space.land import LandMaps

OPEN, WATER, ROCK, FENCE = 0, 1, 2, 3


class Ground(NamedTuple):
    """Maps of the ground, for kernels; a map of one cell has no effect."""

    kind: np.ndarray  # u8[ny, nx]
    height: np.ndarray  # f32[ny, nx] [m]
    inverse: np.ndarray  # f32[2], cells per meter


OPEN_GROUND = Ground(np.zeros((1, 1), np.uint8), np.zeros((1, 1), np.float32), np.zeros(2, np.float32))


class Terrain:
    """Heights f32[ny, nx] [m] and ground u8[ny, nx] (0 open, 1 water, 2 rock, 3 fence) on cells of side
    `cell` [m].

    Water stops walkers, and rock stops walkers and sight; a fence stops walkers, but animals on its line when
    it is put up can walk off to either side. `slope_cost` is the extra cost of locomotion per unit of upward
    slope, as a share of the cost on flat ground. `hides` means that hills block sight.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.space import Space, Terrain
    >>> ground = Terrain(Space((20.0, 20.0)), lakes=[{"at": [5.0, 5.0], "radius": 2.0}])
    >>> places = np.array([5.0, 15.0], np.float32)
    >>> ground.free(places, places).tolist(), bool(ground.wet().any())
    ([False, True], True)
    >>> line = np.array([[12.0, 2.0], [12.0, 18.0]])
    >>> ground.fence(line)
    >>> ground.unfence(line)
    >>> ground.pave(line, width=2.0, pace=1.5, cost=0.8)
    >>> ground.unpave()
    """

    def __init__(
        self,
        space: Space,
        cell: float = 1.0,
        *,
        hills: Mapping[str, float] | None = None,
        mountains: Sequence[Mapping[str, Any]] = (),
        rocks: Sequence[Mapping[str, Any]] = (),
        lakes: Sequence[Mapping[str, Any]] = (),
        slope_cost: float = 1.0,
        roads: Sequence[Mapping[str, Any]] = (),
        hides: bool = False,
    ) -> None:
        nx, ny = max(1, round(space.size[0] / cell)), max(1, round(space.size[1] / cell))
        self.space, self.slope_cost, self.hides = space, float(slope_cost), hides
        self.shape = (ny, nx)
        self.height = np.zeros((ny, nx), np.float32)
        self.ground = np.zeros((ny, nx), np.uint8)
        self.inverse = np.array([nx / space.size[0], ny / space.size[1]], np.float32)
        self.declared = True  # in the world file; otherwise, an intervention created and stores the ground
        self.fences: list[np.ndarray] = []  # corners of each fence, f64[k, 2] [m]
        self.roads: list[Road] = []
        self.land: LandMaps | None = None  # set for real land; see ecs_eco.space.land
        self.pace: np.ndarray | None = None  # f32[ny, nx], factor for speeds; None if all factors are 1
        self.toll: np.ndarray | None = None  # f32[ny, nx], factor for costs
        if hills:
            self.height += _hills(space, nx, ny, **hills)
        for mountain in mountains:
            share = self._closeness(mountain)
            self.height += (
                np.float32(mountain.get("height", 10.0)) * share * share * (3 - 2 * share)
            ).astype(np.float32)
        for kind, places in ((ROCK, rocks), (WATER, lakes)):
            for place in places:
                self.ground[self._closeness(place) > 0] = kind
        for road in roads:
            self.pave(np.array(road["line"], float), road["width"], road["pace"], road["cost"])

    @property
    def maps(self) -> Ground:
        """Maps for kernels."""
        return Ground(self.ground, self.height, self.inverse)

    def _closeness(self, place: Mapping[str, Any]) -> np.ndarray:
        """Return a map f64[ny, nx] that falls from 1 at the center of a circle to 0 at its radius and beyond."""
        ny, nx = self.height.shape
        x = (np.arange(nx) + 0.5) / self.inverse[0] - place["at"][0]
        y = (np.arange(ny) + 0.5) / self.inverse[1] - place["at"][1]
        if self.space.torus:
            x -= self.space.size[0] * np.round(x / self.space.size[0])
            y -= self.space.size[1] * np.round(y / self.space.size[1])
        return np.clip(1 - arrays.hypot(x[None, :], y[:, None]) / place["radius"], 0, 1)

    def free(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return whether an animal can stand at each position.

        Parameters
        ----------
        x, y : array of float32, shape (n,)
            Coordinates [m].

        Returns
        -------
        array of bool, shape (n,)
        """
        ny, nx = self.ground.shape
        i, j = cells_of(x, self.inverse[0], nx), cells_of(y, self.inverse[1], ny)
        return (self.ground[j, i] == OPEN) | (self.ground[j, i] == FENCE)

    def wet(self) -> np.ndarray:
        """Return the cells with drinking water: lakes, sea and streams.

        Returns
        -------
        array of bool, shape (ny, nx)
        """
        water = self.ground == WATER
        return water if self.land is None or self.land.wet is None else water | self.land.wet

    def within_sites(
        self, x: np.ndarray, y: np.ndarray, centre_x: np.ndarray, centre_y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return positions f32[n] [m] within sites whose centers f32[n] [m] are open; a position blocked by
        the edge of a rock or lake is replaced with the center of its site."""
        free = self.free(x, y)
        return np.where(free, x, centre_x), np.where(free, y, centre_y)

    def fence(self, corners: np.ndarray) -> None:
        """Put up a fence on open ground.

        Parameters
        ----------
        corners : array of float, shape (k, 2)
            Line of the fence [m]; on a torus it may extend beyond the edge.
        """
        self.fences.append(np.asarray(corners, float))
        self.draw_fences()

    def unfence(self, corners: np.ndarray | None = None) -> None:
        """Remove one fence, or all of them.

        Parameters
        ----------
        corners : array of float, shape (k, 2), optional
            Line of the fence [m]; default: all fences.

        Raises
        ------
        ValueError
            If there is no fence along this line.
        """
        same = [
            i
            for i, f in enumerate(self.fences)
            if corners is None or (f.shape == np.shape(corners) and (f == corners).all())
        ]
        if corners is not None and not same:
            raise ValueError(
                f"there is no fence along {np.asarray(corners).tolist()}; other fences: {len(self.fences)}"
            )
        gone = same if corners is None else same[:1]
        self.fences = [f for i, f in enumerate(self.fences) if i not in gone]
        self.draw_fences()

    def draw_fences(self) -> None:
        """Redraw the fences on the map of the ground."""
        ny, nx = self.ground.shape
        self.ground[self.ground == FENCE] = OPEN
        for corners in self.fences:
            i, j = cells_along(corners * np.array([nx, ny]) / np.array(self.space.size[:2])).T
            if self.space.torus:
                i, j = i % nx, j % ny
            inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
            i, j = i[inside], j[inside]
            self.ground[j, i] = np.where(self.ground[j, i] == OPEN, FENCE, self.ground[j, i])

    def pave(self, corners: np.ndarray, width: float, pace: float, cost: float) -> None:
        """Lay a road.

        Parameters
        ----------
        corners : array of float, shape (k, 2)
            Center line of the road [m].
        width : float
            [m]
        pace, cost : float
            Factors by which the road multiplies walkers' speed and their costs per second.
        """
        self.roads.append(Road(np.asarray(corners, float), float(width), float(pace), float(cost)))
        self.draw_roads()

    def unpave(self, corners: np.ndarray | None = None) -> None:
        """Remove one road, or all of them.

        Parameters
        ----------
        corners : array of float, shape (k, 2), optional
            Center line of the road [m]; default: all roads.

        Raises
        ------
        ValueError
            If there is no road along this line.
        """
        same = [i for i, road in enumerate(self.roads) if corners is None or np.array_equal(road[0], corners)]
        if corners is not None and not same:
            raise ValueError(
                f"there is no road along {np.asarray(corners).tolist()}; other roads: {len(self.roads)}"
            )
        gone = same if corners is None else same[:1]
        self.roads = [road for i, road in enumerate(self.roads) if i not in gone]
        self.draw_roads()

    def draw_roads(self) -> None:
        """Recompute the maps of pace and toll from the land and the roads on it."""
        self.pace = self.toll = None
        land = self.land
        if land is not None and not (land.pace is None and land.cost is None):
            one = np.ones(self.shape, np.float32)
            self.pace = one if land.pace is None else land.pace.copy()
            self.toll = one.copy() if land.cost is None else land.cost.copy()
        for road in self.roads:
            if self.pace is None or self.toll is None:
                self.pace, self.toll = np.ones(self.shape, np.float32), np.ones(self.shape, np.float32)
            on = road.covers(self)
            self.pace[on], self.toll[on] = road.pace, road.cost

    def state(self) -> dict[str, np.ndarray]:
        """Return the state that a run can change: the ground, and the fences and roads on it; empty for
        ground that is stored elsewhere."""
        return self.fenced() if self.declared else {}

    def fenced(self) -> dict[str, np.ndarray]:
        """Return the ground, the corners of all fences, and the number of corners of each; roads follow, with
        negative numbers and two more rows (width and pace, cost and 0)."""
        lines = [
            *self.fences,
            *(np.array([*road.line, (road.width, road.pace), (road.cost, 0.0)]) for road in self.roads),
        ]
        lengths = [*map(len, self.fences), *(-len(road.line) - 2 for road in self.roads)]
        return {
            "ground": self.ground.copy(),
            "corners": np.concatenate([np.zeros((0, 2)), *lines]),
            "lengths": np.array(lengths, np.int64),
        }

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Load a `state()`. Raises a ValueError if the ground has a different size."""
        if state["ground"].shape != self.ground.shape:
            raise ValueError(
                f"terrain has {self.ground.shape} cells, but its state has {state['ground'].shape}"
            )
        corners, lengths, far = state["corners"], state["lengths"], 4 * max(self.space.size)
        rows = np.abs(lengths)
        lines = np.split(corners, np.cumsum(rows)[:-1]) if len(rows) else []
        near = [line if n > 0 else line[:-2] for line, n in zip(lines, lengths, strict=True)]
        if (
            corners.shape != (rows.sum(), 2)
            or (rows < 1).any()
            or ((lengths < 0) & (rows < 4)).any()
            or not np.isfinite(corners).all()
            or not all((np.abs(line) <= far).all() for line in near)
        ):
            raise ValueError(
                f"fences have corners {corners.tolist()[:4]} …, {lengths.tolist()[:4]} … per fence; "
                f"expected two finite numbers per corner, up to {far:g} m"
            )
        self.ground[...] = state["ground"]
        self.fences = [line.copy() for line, n in zip(lines, lengths, strict=True) if n > 0]
        self.roads = [
            Road(line[:-2].copy(), float(line[-2, 0]), float(line[-2, 1]), float(line[-1, 0]))
            for line, n in zip(lines, lengths, strict=True)
            if n < 0
        ]
        self.draw_roads()


class Road(NamedTuple):
    """A road: a strip of ground along a line."""

    line: np.ndarray  # f64[k, 2] [m]
    width: float  # [m]
    pace: float  # factor for speeds
    cost: float  # factor for costs

    def covers(self, terrain: Terrain) -> np.ndarray:
        """Return the cells whose centers are on the road or that its line crosses: bool[ny, nx]."""
        (ny, nx), space, out = terrain.shape, terrain.space, np.zeros(terrain.shape, np.bool_)
        i, j = cells_along(self.line * np.array([nx, ny]) / np.array(space.size[:2])).T
        if space.torus:
            i, j = i % nx, j % ny
        inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
        out[j[inside], i[inside]] = True
        x = (np.arange(nx)[None, :] + 0.5) / terrain.inverse[0]
        y = (np.arange(ny)[:, None] + 0.5) / terrain.inverse[1]
        for (ax, ay), (bx, by) in pairwise(self.line.tolist()):
            dx, dy = x - (ax + bx) / 2, y - (ay + by) / 2
            if space.torus:
                dx = dx - space.size[0] * np.round(dx / space.size[0])
                dy = dy - space.size[1] * np.round(dy / space.size[1])
            length2 = power(bx - ax, 2) + power(by - ay, 2)
            along = (dx * (bx - ax) + dy * (by - ay)) / max(length2, 1e-30)
            along = np.clip(along, -0.5, 0.5)
            out |= arrays.hypot(dx - along * (bx - ax), dy - along * (by - ay)) <= self.width / 2
        return out


def cells_along(corners: np.ndarray) -> np.ndarray:
    """Return the cells (i, j), i64[n, 2], crossed by a line through corners f64[k, 2] in units of cells.

    Each cell shares a side with the next, never only a corner, so there is no gap between them (Amanatides &
    Woo 1987).
    """
    x, y = (int(np.floor(v)) for v in corners[0])
    cells = [(x, y)]
    for (ax, ay), (bx, by) in pairwise(corners.tolist()):
        dx, dy, ends = bx - ax, by - ay, (int(np.floor(bx)), int(np.floor(by)))
        for _ in range(abs(ends[0] - x) + abs(ends[1] - y)):
            # the share of the segment at which the line leaves this cell
            at_x = ((x + (dx > 0)) - ax) / dx if x != ends[0] else np.inf
            at_y = ((y + (dy > 0)) - ay) / dy if y != ends[1] else np.inf
            if at_x <= at_y:
                x += 1 if dx > 0 else -1
            else:
                y += 1 if dy > 0 else -1
            cells.append((x, y))
    return np.array(cells, np.int64)


def _hills(
    space: Space, nx: int, ny: int, seed: float = 0, amplitude: float = 5.0, scale: float = 30.0
) -> np.ndarray:
    """Return smooth hills: a sum of 32 plane waves with random directions and phases that are periodic on the
    torus."""
    u = random.draw_many(random.tick_key(int(seed), 0), np.arange(96, dtype=np.uint64), random.PLACE).reshape(
        3, 32
    )
    x, y = (np.arange(nx) + 0.5) / nx, (np.arange(ny) + 0.5) / ny
    height = np.zeros((ny, nx))
    for angle, phase, stretch in u.T:
        waves = (0.5 + stretch) * np.array(space.size[:2]) / scale
        kx, ky = (
            np.round(waves[0] * arrays.cos(2 * np.pi * angle)),
            np.round(waves[1] * arrays.sin(2 * np.pi * angle)),
        )
        height += arrays.sin(2 * np.pi * (kx * x[None, :] + ky * y[:, None] + phase))
    return (amplitude * height / np.sqrt(16)).astype(np.float32)


@njit
def closed_between(x, y, dx, dy, ground, space):
    """Return whether a fence, rock or water other than one at the start begins along the displacement (dx,
    dy); checks every half cell."""
    on = ground_at(ground, x, y)
    steps = half_cells(np.sqrt(dx * dx + dy * dy), ground.inverse, space.lengths)
    for s in range(1, steps + 1):
        way = np.float32(s) / np.float32(steps)
        kind = ground_at(ground, *along(x, y, way * dx, way * dy, space))
        if kind != OPEN and kind != on:
            return True
        on = kind
    return False


@njit
def is_open(x, y, dx, dy, ground, space):
    """Return whether the whole displacement (dx, dy) is on open ground, for an animal that may be on a
    fence; checks every half cell."""
    on = ground_at(ground, x, y) == FENCE
    steps = half_cells(np.sqrt(dx * dx + dy * dy), ground.inverse, space.lengths)
    for s in range(1, steps + 1):
        way = np.float32(s) / np.float32(steps)
        kind = ground_at(ground, *along(x, y, way * dx, way * dy, space))
        if kind != OPEN and not (on and kind == FENCE):
            return False
        on = on and kind == FENCE
    return True


@njit
def along(x, y, dx, dy, space):
    """Return the position after a displacement (dx, dy)."""
    return into(x + dx, space.lengths[0], space.torus), into(y + dy, space.lengths[1], space.torus)


@njit
def ground_at(ground, x, y):
    """Return the kind of ground at a position."""
    (ny, nx), inverse = ground.kind.shape, ground.inverse
    return ground.kind[cell_of(y * inverse[1], ny), cell_of(x * inverse[0], nx)]


@njit
def height_at(ground, x, y, torus):
    """Return the height [m] at a position, interpolated linearly between cell centers."""
    height, inverse = ground.height, ground.inverse
    ny, nx = height.shape
    gx, gy = x * inverse[0] - np.float32(0.5), y * inverse[1] - np.float32(0.5)
    i0, j0 = floor_between(gx, -1, nx), floor_between(gy, -1, ny)
    fx, fy = gx - np.float32(i0), gy - np.float32(j0)
    i1, j1 = i0 + 1, j0 + 1
    if torus:
        i0, i1, j0, j1 = i0 % nx, i1 % nx, j0 % ny, j1 % ny
    else:
        i0, i1, j0, j1 = (
            min(max(i0, 0), nx - 1),
            min(max(i1, 0), nx - 1),
            min(max(j0, 0), ny - 1),
            min(max(j1, 0), ny - 1),
        )
    one = np.float32(1.0)
    west = (one - fy) * height[j0, i0] + fy * height[j1, i0]
    east = (one - fy) * height[j0, i1] + fy * height[j1, i1]
    return (one - fx) * west + fx * east


@njit
def hill_between(x, y, dx, dy, eye, top, ground, space):
    """Return whether the ground rises above the straight line from `eye` [m] above the ground at (x, y) to
    `top` [m] above the ground at the end of the displacement (dx, dy); checks every half cell."""
    if ground.height.size == 1:
        return False
    begin = height_at(ground, x, y, space.torus) + eye
    end = height_at(ground, *along(x, y, dx, dy, space), space.torus) + top
    steps = half_cells(np.sqrt(dx * dx + dy * dy), ground.inverse, space.lengths)
    for s in range(1, steps):
        t = np.float32(s) / np.float32(steps)
        if height_at(ground, *along(x, y, t * dx, t * dy, space), space.torus) > begin + t * (end - begin):
            return True
    return False
