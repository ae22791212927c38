"""FreeSpace: where the centre of a disc of one size may be, triangulated."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from numbers import Real

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.geometry.growth import free_region
from taut.geometry.overlay import remainder
from taut.geometry.points import points_of
from taut.geometry.triangulation import Floats, Ints, Triangulation, meshed
from taut.scene import Robot, Scene
from taut.validation import check_numbers


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The workspace shrunk by ``growth`` metres, minus the obstacles grown by as much; closed.

    Corners are rounded by tangents outside the true arc, at most ``arc_error`` of its radius farther than required.

    Parameters
    ----------
    scene : the world.
    growth : metres, a robot's radius plus its clearance.
    arc_error : greatest excess at rounded corners, as a fraction of the arc's radius.

    Raises
    ------
    SceneError
        ``growth`` is negative, ``arc_error`` not between 0 and 1, or a number of the scene beyond 1e±70.

    >>> from taut.scene import Scene
    >>> FreeSpace(Scene((0, 0, 4, 3)), growth=0.5).area
    6.0
    """

    scene: Scene
    growth: float = 0.0
    arc_error: float = 1e-3
    region: shapely.Polygon | shapely.MultiPolygon = field(init=False)
    mesh: Triangulation = field(init=False)

    def __post_init__(self) -> None:
        if not isinstance(self.scene, Scene):
            raise SceneError(f"a free space is made from a Scene, got {self.scene!r}")
        check_numbers(self.scene)
        if not (isinstance(self.growth, Real) and (self.growth == 0 or 1e-70 < self.growth < 1e70)):
            raise SceneError(f"growth must be a number of metres, 0 or between 1e-70 and 1e70, got {self.growth!r}")
        if not (isinstance(self.arc_error, Real) and 0 < self.arc_error < 1):
            raise SceneError(f"arc_error must lie between 0 and 1, got {self.arc_error!r}")
        found = free_region(self.scene, self.growth, self.arc_error, keep=self.kept)
        region, mesh = meshed(found, self.scene.tol)
        vars(self).update(region=region, mesh=mesh)

    @classmethod
    def of(cls, scene: Scene, robot: Robot, arc_error: float = 1e-3) -> FreeSpace:
        """Return the free space of one robot of the scene."""
        return cls(scene, scene.growth(robot), arc_error)

    @classmethod
    def with_mesh(
        cls,
        scene: Scene,
        growth: float,
        arc_error: float,
        region: shapely.Polygon | shapely.MultiPolygon,
        mesh: Triangulation,
    ) -> FreeSpace:
        """Return a free space of which region and triangulation are known; that they fit is not checked."""
        out = cls.__new__(cls)
        vars(out).update(scene=scene, growth=growth, arc_error=arc_error, region=region, mesh=mesh)
        return out

    @property
    def kept(self) -> Floats:
        """Starts and goals that rounding of grown corners leaves free: (k, 2), of the robots that need this growth."""
        scene = self.scene
        ends = [p for r in scene.robots if scene.growth(r) == self.growth for p in (r.start, r.goal)]
        return np.array(ends, dtype=np.float64).reshape(-1, 2)

    @property
    def area(self) -> float:
        """Square metres."""
        return float(self.region.area)

    @property
    def parts(self) -> int:
        """How many parts do not hang together."""
        return self.mesh.part_count

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each of (k, 2) points lies in the free space, boundary included: (k,)."""
        return self.mesh.locate(points_of(points)) >= 0

    def anchor(self, points: ArrayLike) -> tuple[Floats, Ints]:
        """The points themselves, or the nearest of the free space where they miss it by at most tol; their triangles.

        Coordinates of grown obstacles are rounded, so a disc that touches one may stick out by an ulp. Triangle −1
        means that the point is not free.
        """
        xy = points_of(points).copy()
        triangle = self.mesh.locate(xy)
        for i in (triangle < 0).nonzero()[0]:
            moved = self._nearest_inside(xy[i])
            if moved is not None:
                xy[i], triangle[i] = moved
        return xy, triangle

    def part_of(self, points: ArrayLike) -> list[frozenset[int]]:
        """The parts to which each point belongs: none if it is not free, several on a place where parts touch."""
        xy, triangle = self.anchor(points)
        mesh = self.mesh
        out = []
        for point, t in zip(xy, triangle, strict=True):
            found = set() if t < 0 else {int(mesh.parts[t])}
            for k in range(3):
                v = mesh.triangles[t, k] if t >= 0 else -1
                if v >= 0 and (mesh.vertices[v] == point).all():
                    fans = mesh.vertex_wedges[mesh.vertex_start[v] : mesh.vertex_start[v + 1]]
                    found |= {int(mesh.parts[mesh.wedges[w, 3]]) for w in fans}
            out.append(frozenset(found))
        return out

    def require(self, robot: Robot) -> None:
        """Raise unless the robot's start and goal are free and lie in one part.

        Raises
        ------
        StartBlocked, GoalBlocked
            The place is not free.
        NoPath
            Both are free but nothing connects them.
        """
        start, goal = self.part_of([robot.start, robot.goal])
        for parts, (x, y), word, error in (
            (start, robot.start, "start", StartBlocked),
            (goal, robot.goal, "goal", GoalBlocked),
        ):
            if not parts:
                raise error(
                    f"robot {robot.name}: {word} ({x:g}, {y:g}) has no room for radius + clearance {self.growth:g} m, "
                    f"or only where rounded corners meet (they are drawn up to {100 * self.arc_error:g} % of their "
                    "radius outside the arc); move it away from them"
                )
        if not start & goal:
            raise NoPath(
                robot.name,
                f"no way from ({robot.start[0]:g}, {robot.start[1]:g}) to ({robot.goal[0]:g}, {robot.goal[1]:g}): "
                f"obstacles separate them for radius + clearance = {self.growth:g} m",
            )

    def _nearest_inside(self, point: Floats) -> tuple[Floats, int] | None:
        mesh = self.mesh
        here = shapely.Point(point)
        if len(mesh.triangles) == 0 or not here.dwithin(self.region, self.scene.tol):
            return None
        near = shapely.get_coordinates(shapely.shortest_line(self.region, here))[0]
        angle = math.pi / 8 * np.arange(16)
        around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        size = max(self.scene.tol, float(np.abs(near).max()) * 2.0**-52)
        for step in size * 2.0 ** np.arange(-13, 14):
            candidates = near + step * around
            found = mesh.locate(candidates)
            if (found >= 0).any():
                i = int(np.argmax(found >= 0))
                return candidates[i], int(found[i])
        return None


def without_discs(freespace: FreeSpace, centres: Floats, radii: Floats) -> FreeSpace:
    """Return the free space with open discs taken out: (k, 2) centres, (k,) radii in metres.

    The discs become regular polygons about them, so a little more is taken out (at most ``arc_error`` of the radius).
    """
    sides = math.ceil(math.pi / math.acos(1.0 / (1.0 + freespace.arc_error)))
    angle = 2 * math.pi * np.arange(sides) / sides
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1) / math.cos(math.pi / sides)
    discs = shapely.polygons(centres[radii > 0, None] + radii[radii > 0, None, None] * unit)
    region = remainder(freespace.region, discs, freespace.scene.tol) if len(discs) else freespace.region
    parts = shapely.get_parts(region)
    region = shapely.multipolygons(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    region, mesh = meshed(region, freespace.scene.tol)
    return FreeSpace.with_mesh(freespace.scene, freespace.growth, freespace.arc_error, region, mesh)
