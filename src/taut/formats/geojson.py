"""Scenes as GeoJSON: features with the role boundary, obstacle or robot; coordinates are metres."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from taut.formats._document import Document, Place, shown
from taut.formats._outline import Area, Unsplittable, outline_and_obstacles
from taut.formats._rings import Ring
from taut.formats._wording import shorten
from taut.formats.convert import obstacle_to_dict, robot_to_dict, scene_of, scene_to_dict, tidy
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Scene

_PROPERTIES = {
    "boundary": ("role", "name"),
    "obstacle": ("role", "name", "radius", "width", "rectangle", "angle"),
    "robot": ("role", "name", "goal", "radius", "speed", "clearance", "start_time", "at_goal"),
}
_WIDE = ("name", "clearance", "gap", "headway", "at_goal")


def scene_to_geojson(scene: Scene) -> dict[str, Any]:
    """Return a scene as a GeoJSON FeatureCollection; what GeoJSON has no word for stands in properties.

    Circles are Points with `radius`, lines LineStrings with `width`, rectangles Polygons with `rectangle` and `angle`,
    robots Points with `goal`; the scene-wide fields are under the collection's key `taut`.
    """
    wide = {key: value for key, value in scene_to_dict(scene).items() if key in _WIDE}
    boundary = _feature({"role": "boundary"}, "Polygon", [_closed(scene.workspace)])
    obstacles = [_obstacle_feature(obstacle) for obstacle in scene.obstacles]
    robots = []
    for robot in scene.robots:
        entry = robot_to_dict(robot)
        start = entry.pop("start")
        robots.append(_feature({"role": "robot", **entry}, "Point", start))
    features = [boundary, *obstacles, *robots]
    return {"type": "FeatureCollection", "taut": {"version": 1, **wide}, "features": features}


def scene_of_geojson(document: Document) -> Scene:
    """Return the scene of a GeoJSON document.

    Rings that touch themselves are split, holes of obstacles are cut open, holes of the boundary become obstacles; no
    corner moves. Several boundaries that do not overlap are one map: the workspace is then the rectangle round them
    all, and what lies between them is obstacles. A boundary inside an obstacle inside another boundary is a courtyard
    of that obstacle. Rings that cross themselves are taken as they are; `validate` says where they cross.

    Raises
    ------
    SceneError
        Not a FeatureCollection, a feature without role, a geometry its role cannot have, no boundary, or anything
        that is wrong in a scene file too.
    """
    found = _Found(document)
    wide = found.read()
    if not found.boundaries:
        raise document.error('no boundary: add one Polygon feature with the property "role": "boundary"')
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # numbers beyond computing are for validation to refuse
            outline, entries = outline_and_obstacles(found.boundaries, found.obstacles)
    except Unsplittable as error:
        raise document.error(str(error), error.place) from None
    places: dict[Place, Place] = {("workspace",): found.boundaries[0].place}
    places |= {("obstacles", k): place for k, (_, place) in enumerate(entries)}
    for k, (_, place) in enumerate(found.robots):
        places[("robots", k)] = (*place, "properties")
        places[("robots", k, "start")] = (*place, "geometry", "coordinates")
    data = {
        "taut": 1,
        **wide,
        "workspace": _lists(outline),
        "obstacles": [entry for entry, _ in entries],
        "robots": [entry for entry, _ in found.robots],
    }

    def line_of(place: Place) -> int | None:
        for length in range(len(place), 0, -1):
            if there := places.get(place[:length]):
                return document.line_of((*there, *place[length:]))
        return document.line_of(("taut", *place))

    return scene_of(Document(data, line_of, document.file))


@dataclass
class _Found:
    """What the features of a collection say, gathered in the order of the file."""

    document: Document
    boundaries: list[Area] = field(default_factory=list)
    obstacles: list[Area | tuple[dict[str, Any], Place]] = field(default_factory=list)
    robots: list[tuple[dict[str, Any], Place]] = field(default_factory=list)

    def read(self) -> dict[str, Any]:
        """Read every feature and return the scene-wide fields."""
        data = self.document.data
        if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
            raise self.document.error("not a GeoJSON FeatureCollection: its `type` must be FeatureCollection")
        wide = data.get("taut", {"version": 1})
        if not isinstance(wide, dict) or type(wide.get("version")) is not int or wide["version"] != 1:
            raise self.document.error("`taut` must be a mapping with `version` 1", ("taut",))
        wide = {key: value for key, value in wide.items() if key != "version"}
        for key in wide:
            if key not in _WIDE:
                message = f"unknown key `{shown(key)[1:-1]}` under `taut`; known are version, {', '.join(_WIDE)}"
                raise self.document.error(message, ("taut", key))
        features = data.get("features")
        if not isinstance(features, list):
            raise self.document.error("`features` must be a list", ("features",))
        for k, feature in enumerate(features):
            self._feature(feature, ("features", k))
        return wide

    def _feature(self, feature: Any, place: Place) -> None:
        who = f"feature {place[-1] + 1}" if isinstance(place[-1], int) else ""
        if not isinstance(feature, dict) or not isinstance(feature.get("properties"), dict):
            raise self.document.error(f'{who}: needs properties with a "role": boundary, obstacle or robot', place)
        properties = {key: value for key, value in feature["properties"].items() if value is not None}
        role, name = properties.get("role"), properties.get("name")
        if isinstance(name, str):
            who += f" ({shorten(name)})"
        if not isinstance(role, str) or role not in _PROPERTIES:
            raise self.document.error(f"{who}: `role` must be boundary, obstacle or robot, got {shown(role)}", place)
        for key in properties:
            # other properties are the map maker's own, but one that is nearly a word of ours is a typing error
            close = difflib.get_close_matches(key[:50].lower(), _PROPERTIES[role], 1, 0.8)
            if close and key not in _PROPERTIES[role]:
                message = f"{who}: unknown property `{shown(key)[1:-1]}`; did you mean `{close[0]}`?"
                raise self.document.error(message, (*place, "properties", key))
        geometry = feature.get("geometry")
        if not isinstance(geometry, dict):
            raise self.document.error(f"{who}: `geometry` must be a mapping of type and coordinates", place)
        kept = {key: properties[key] for key in _PROPERTIES[role] if key in properties and key != "role"}
        reader = {"boundary": self._boundary, "obstacle": self._obstacle, "robot": self._robot}[role]
        reader(f"{who}: {role}", geometry.get("type"), geometry.get("coordinates"), kept, place)

    def _boundary(self, who: str, kind: Any, coordinates: Any, properties: dict[str, Any], place: Place) -> None:
        if kind not in ("Polygon", "MultiPolygon"):
            raise self.document.error(f"{who} must be a Polygon, got {shown(kind)}", place)
        if polygons := self._polygons(who, kind, coordinates, place):
            self.boundaries.append(Area("", polygons, place))

    def _obstacle(self, who: str, kind: Any, coordinates: Any, properties: dict[str, Any], place: Place) -> None:
        inside = (*place, "properties")
        name = {"name": properties["name"]} if "name" in properties else {}
        if kind == "Point" and "radius" in properties:
            circle = self._position(who, coordinates, place)
            self.obstacles.append(({**name, "circle": circle, "radius": properties["radius"]}, inside))
        elif kind == "LineString" and "width" in properties:
            line = self._positions(who, coordinates, place)
            self.obstacles.append(({**name, "line": line, "width": properties["width"]}, inside))
        elif kind == "Polygon" and "rectangle" in properties:
            entry: dict[str, Any] = {k: properties[k] for k in ("name", "rectangle", "angle") if k in properties}
            self._same_corners(who, entry, self._polygons(who, kind, coordinates, place), place)
            self.obstacles.append((entry, inside))
        elif kind in ("Polygon", "MultiPolygon"):
            text = properties.get("name", "")
            if not isinstance(text, str):
                raise self.document.error(f"{who}: name must be text, got {shown(text)}", (*inside, "name"))
            self.obstacles.append(Area(text, self._polygons(who, kind, coordinates, place), place))
        else:
            allowed = "a Polygon, a MultiPolygon, a Point with `radius` or a LineString with `width`"
            raise self.document.error(f"{who} must be {allowed}, got {shown(kind)}", place)

    def _robot(self, who: str, kind: Any, coordinates: Any, properties: dict[str, Any], place: Place) -> None:
        if kind == "Point":
            start = self._position(who, coordinates, place)
        elif kind == "LineString":
            points = self._positions(who, coordinates, place)
            if len(points) != 2 or "goal" in properties:
                raise self.document.error(f"{who} must be a LineString of start and goal, without `goal`", place)
            start, properties = points[0], {**properties, "goal": points[1]}
        else:
            allowed = "a Point (the start) with `goal`, or a LineString from start to goal"
            raise self.document.error(f"{who} must be {allowed}, got {shown(kind)}", place)
        self.robots.append(({**properties, "start": start}, place))

    def _same_corners(self, who: str, entry: dict[str, Any], polygons: Sequence[list[Ring]], place: Place) -> None:
        """Refuse a rectangle whose drawn corners were moved: which of the two is meant, nobody can know."""
        box, angle = entry["rectangle"], entry.get("angle", 0.0)
        if not isinstance(box, list) or len(box) != 4 or not all(map(_is_finite, [*box, angle])) or min(box[2:]) <= 0:
            return  # the schema says what is wrong with it
        corners = Rectangle(box[0], box[1], box[2], box[3], angle).core
        drawn = polygons[0][0] if polygons and polygons[0] else []
        size = max(1.0, float(abs(corners).max()))
        same = len(drawn) == 4 and abs(corners / size - [[x / size, y / size] for x, y in drawn]).max() < 1e-9
        if not same:
            message = f"{who}: its corners are not those of its `rectangle`; remove the property `rectangle`"
            raise self.document.error(message, place)

    def _polygons(self, who: str, kind: Any, coordinates: Any, place: Place) -> list[list[Ring]]:
        parts = [coordinates] if kind == "Polygon" else coordinates
        out = []
        for part in self._list(who, parts, place):
            rings = [_opened(self._positions(who, ring, place)) for ring in self._list(who, part, place)]
            if not rings:
                raise self.document.error(f"{who}: a polygon without a ring; remove it or give its corners", place)
            if any(len(ring) < 3 for ring in rings):
                raise self.document.error(f"{who}: a ring needs at least 3 corners", place)
            out.append(rings)
        return out

    def _positions(self, who: str, value: Any, place: Place) -> list[Any]:
        return [self._position(who, item, place) for item in self._list(who, value, place)]

    def _position(self, who: str, value: Any, place: Place) -> list[float]:
        if not isinstance(value, list) or len(value) < 2 or not all(map(_is_finite, value[:2])):
            message = f"{who}: a position must be [x, y] of finite numbers, got {shown(value)}"
            raise self.document.error(message, (*place, "geometry", "coordinates"))
        return [float(value[0]), float(value[1])]

    def _list(self, who: str, value: Any, place: Place) -> list[Any]:
        if not isinstance(value, list):
            message = f"{who}: `coordinates` must be nested lists, got {shown(value)}"
            raise self.document.error(message, (*place, "geometry", "coordinates"))
        return value


def _is_finite(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # an int beyond every float
        return False


def _opened(positions: list[Any]) -> Ring:
    corners = [(x, y) for x, y in positions]
    return corners[:-1] if len(corners) > 1 and corners[0] == corners[-1] else corners


def _closed(corners: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[tidy(x), tidy(y)] for x, y in (*corners, corners[0])]


def _lists(ring: Ring) -> list[list[float]]:
    return [list(corner) for corner in ring]


def _feature(properties: dict[str, Any], kind: str, coordinates: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def _obstacle_feature(obstacle: Obstacle) -> dict[str, Any]:
    entry = {"role": "obstacle", **obstacle_to_dict(obstacle)}
    match obstacle:
        case Polygon():
            del entry["polygon"]
            return _feature(entry, "Polygon", [_closed(obstacle.points)])
        case Rectangle():
            return _feature(entry, "Polygon", [_closed(obstacle.core.tolist())])
        case Circle():
            return _feature(entry, "Point", entry.pop("circle"))
        case Line():
            return _feature(entry, "LineString", entry.pop("line"))
