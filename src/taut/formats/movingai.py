"""Grid maps and scenarios of the MovingAI collection as scenes: .map and .scen files.

A cell is a square of one metre. Row 0 of a map stands at the top, as the file is read and as maps are drawn: the
centre of the cell in row r and column c lies at x = c, y = rows − 1 − r. The workspace reaches half a metre further.
Format: Sturtevant, Benchmarks for grid-based pathfinding, IEEE TCIAIG 2012; https://movingai.com/benchmarks/formats.html
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.errors import SceneError
from taut.formats._document import read_text, shown
from taut.formats._outline import Area, outline_and_obstacles
from taut.scene import Polygon, Robot, Scene

_LIMIT = 16 << 20
_FREE, _BLOCKED = ".GS", "@OTW"
_COLUMNS = 9


def load_map(path: str | os.PathLike[str]) -> Scene:
    """Return the scene of a .map file, without robots; blocked cells become polygons.

    `.`, `G` and `S` (ground, swamp) are free, `@`, `O`, `T` and `W` (out of bounds, trees, water) are not. Cells that
    meet in a corner only leave no way between them.

    Raises
    ------
    SceneError
        No such file, or anything wrong in it: one line, with file and line number.
    """
    return map_of_text(read_text(path, _LIMIT), os.fspath(path))


def map_of_text(text: str, file: str) -> Scene:
    """Return the scene of the text of a .map file, see `load_map`."""
    free = _cells(text, file)
    rows, columns = free.shape
    obstacles = [Polygon(ring) for ring in _rings(~free)]
    return Scene((-0.5, -0.5, columns - 0.5, rows - 0.5), obstacles, name=Path(file).stem)


def free_cells(path: str | os.PathLike[str]) -> NDArray[np.bool_]:
    """Return which cells of a .map file are free, (rows, columns): row k has its centres at y = k, the lowest first.

    `taut.roadmap.grid_lanes` makes lanes of them.

    Raises
    ------
    SceneError
        As `load_map`.
    """
    return _cells(read_text(path, _LIMIT), os.fspath(path))


def _cells(text: str, file: str) -> NDArray[np.bool_]:
    lines = text.splitlines()
    size: dict[str, int] = {}
    for number, line in enumerate(lines, 1):
        words = line.split()
        if words == ["map"]:
            break
        if len(words) == 2 and words[0] in ("height", "width"):
            size[words[0]] = _whole(words[1], words[0], file, number, least=1)
        elif words and words[0] != "type":
            raise SceneError(f"expected type, height, width or map, got {shown(line)}", file, number)
    else:
        raise SceneError("has no line `map`: this is not a MovingAI map", file)
    if len(size) < 2:
        raise SceneError("must tell height and width before the line `map`", file, number)
    rows = [line.rstrip() for line in lines[number:]]
    while rows and not rows[-1]:
        rows.pop()
    if len(rows) != size["height"]:
        raise SceneError(f"has {len(rows)} rows after the line `map`, but says height {size['height']}", file)
    for k, row in enumerate(rows, number + 1):
        if len(row) != size["width"]:
            raise SceneError(f"this row has {len(row)} cells, but the file says width {size['width']}", file, k)
        if odd := row.strip(_FREE + _BLOCKED):
            raise SceneError(f"unknown cell {shown(odd[0])}; known are {' '.join(_FREE + _BLOCKED)}", file, k)
    cells = np.array([list(row) for row in rows])
    return np.ascontiguousarray(np.isin(cells, list(_FREE))[::-1])


def load_scen(
    path: str | os.PathLike[str],
    scene: Scene,
    robots: int | None = None,
    radius: float = math.sqrt(2) / 4,
    speed: float = 1.0,
) -> Scene:
    """Return a map's scene with the first robots of a .scen file, named R1, R2 and so on.

    Whether they have room, and whether some start or end too near to each other, `validate` tells.

    Parameters
    ----------
    scene : the map, from `load_map`.
    robots : how many; None for all.
    radius : of each, metres (= cells).
    speed : of each, metres a second.

    Raises
    ------
    SceneError
        No such file, fewer robots in it, made for a map of another size, or anything wrong in it: one line, with file
        and line number.
    """
    file = os.fspath(path)
    lines = [(k, line.split()) for k, line in enumerate(read_text(path, _LIMIT).splitlines(), 1) if line.strip()]
    if not lines or lines[0][1][0] != "version":
        raise SceneError(
            "does not begin with `version 1`: this is not a MovingAI scenario", file, lines[0][0] if lines else 1
        )
    entries = lines[1:]
    if robots is not None:
        if robots < 0:
            raise SceneError(f"robots must not be negative, got {robots}")
        if robots > len(entries):
            raise SceneError(f"has {len(entries)} robots, not {robots}; ask for fewer", file)
        entries = entries[:robots]
    width, height = (int(side) for side in np.ptp(np.array(scene.workspace), axis=0))
    team = []
    for k, (line, words) in enumerate(entries, 1):
        if len(words) != _COLUMNS:
            raise SceneError(
                f"expected {_COLUMNS} words (bucket, map, width, height, start x and y, goal x and y, length), got "
                f"{len(words)}",
                file,
                line,
            )
        names = ("width", "height", "start x", "start y", "goal x", "goal y")
        wide, high, *ends = (_whole(word, what, file, line) for word, what in zip(words[2:8], names, strict=True))
        if (wide, high) != (width, height):
            raise SceneError(f"is for a map of {wide} × {high} cells, this one has {width} × {height}", file, line)
        for at, most, what in zip(ends, (width, height, width, height), names[2:], strict=True):
            if at >= most:
                raise SceneError(f"{what} must be below {most}, got {at}", file, line)
        ax, ay, bx, by = ends
        team.append(Robot(f"R{k}", (ax, height - 1 - ay), (bx, height - 1 - by), radius, speed))
    return replace(scene, robots=tuple(team))


def _rings(blocked: NDArray[np.bool_]) -> list[list[tuple[float, float]]]:
    """Simple rings that hold the blocked cells, larger blocks with holes cut open."""
    y, x = np.nonzero(blocked)
    if not len(x):
        return []
    union = shapely.coverage_union_all(shapely.box(x - 0.5, y - 0.5, x + 0.5, y + 0.5))
    areas = [
        Area("", [[_bends(ring) for ring in (block.exterior, *block.interiors)]], ())
        for block in shapely.get_parts(union)
    ]
    box = [(-0.5, -0.5), (blocked.shape[1] - 0.5, -0.5), (blocked.shape[1] - 0.5, blocked.shape[0] - 0.5)]
    box.append((-0.5, blocked.shape[0] - 0.5))
    _, entries = outline_and_obstacles([Area("", [[box]], ())], areas)
    return [[(float(px), float(py)) for px, py in entry["polygon"]] for entry, _ in entries]


def _bends(ring: shapely.LinearRing) -> list[tuple[float, float]]:
    """Corners of a ring of cell sides, not closed, less those where it goes straight on."""
    at = shapely.get_coordinates(ring)[:-1]
    before, after = at - np.roll(at, 1, axis=0), np.roll(at, -1, axis=0) - at
    bent = before[:, 0] * after[:, 1] != before[:, 1] * after[:, 0]
    return [(float(px), float(py)) for px, py in at[bent]]


def _whole(word: str, what: str, file: str, line: int, least: int = 0) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 10 and int(word) >= least):
        raise SceneError(f"{what} must be a whole number, at least {least}, got {shown(word)}", file, line)
    return int(word)
