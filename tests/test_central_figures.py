"""Pictures of CA and OCA show what their routes were made of, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from taut.figures import draw, save_figure
from taut.figures.canvas import sheet
from taut.figures.central import CROSSING, HIT, STEPS, UNUSED, WAYPOINT, draw_steps
from taut.figures.central_steps import draw_central_steps, draw_rounds, save_central_steps, save_rounds
from taut.figures.maps import scene_view
from taut.figures.style import GOAL, OBSTACLE, START, robot_colours
from taut.formats import load_scene
from taut.route import CentralRoute, OcaRoute, Route, central_path, oca_path
from taut.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("thesis-2")


@pytest.fixture(scope="module")
def central(scene: Scene) -> dict[str, CentralRoute]:
    return {robot.name: central_path(scene, robot) for robot in scene.robots}


@pytest.fixture(scope="module")
def oca(scene: Scene) -> dict[str, OcaRoute]:
    return {name: oca_path(scene, name, clearance=distance) for name, distance in (("R1", 0.3), ("R3", 0.2))}


def dots(axes: Axes, face: str) -> set[tuple[float, float]]:
    """Return the places of round and other marks of that colour."""
    found: set[tuple[float, float]] = set()
    for marks in axes.collections:
        if isinstance(marks, PathCollection) and marks.get_zorder() >= 5 and faces(marks)[:1] == [face]:
            found |= rounded(np.asarray(marks.get_offsets()))
    return found


def faces(marks: PathCollection) -> list[str]:
    colours: Any = marks.get_facecolor()
    return [to_hex(colour) for colour in colours]


def lines(axes: Axes, colour: str, zorder: float) -> list[Any]:
    found = []
    for collection in axes.collections:
        if isinstance(collection, LineCollection) and collection.get_zorder() == zorder:
            shades: Any = collection.get_color()
            pieces = segments(collection)
            found += [p for k, p in enumerate(pieces) if to_hex(shades[k % len(shades)]) == colour]
    return found


def segments(collection: LineCollection) -> list[Any]:
    return [np.asarray(piece).tolist() for piece in collection.get_segments()]


def left_end(path: Any) -> float:
    return float(path.vertices[:, 0].min())


def legend(axes: Axes) -> list[str]:
    found = axes.get_legend()
    return [] if found is None else [text.get_text() for text in found.get_texts()]


def obstacle_colours(axes: Axes, scene: Scene) -> dict[str, str]:
    shapes = next(c for c in axes.collections if isinstance(c, PathCollection) and c.get_zorder() == 2)
    colours = faces(shapes)
    return {o.name: colours[k % len(colours)] for k, o in enumerate(scene.obstacles)}


def rounded(places: Any) -> set[tuple[float, float]]:
    return {(float(x), float(y)) for x, y in places}


def test_a_picture_of_ca_has_every_point_that_its_routes_were_made_of(
    scene: Scene, central: dict[str, CentralRoute]
) -> None:
    axes = draw(scene, routes=central)
    routes = central.values()
    assert dots(axes, WAYPOINT) == {w.place for route in routes for w in route.waypoints}
    assert {w.place for route in routes for w, _ in route.dropped} <= dots(axes, "#ffffff")
    assert dots(axes, CROSSING) == rounded(u for route in routes for c in route.crossed for u in c.crossings)
    assert dots(axes, HIT) == {hit.place for route in routes for hit in route.hits}
    baselines = lines(axes, START, 3.1)
    assert sorted(baselines) == sorted(route.baseline.tolist() for route in routes)


def test_a_picture_of_ca_tells_lengths_and_hits(scene: Scene, central: dict[str, CentralRoute]) -> None:
    axes = draw(scene, routes=central)
    told = axes.get_title("right")
    for name, route in central.items():
        assert f"{name} {route.length:.2f} m" in told
        assert (f"{name} {route.length:.2f} m, hits" in told) == (not route.free)
    assert "hits O1" in [text.get_text() for text in axes.texts]
    assert {"baseline", "waypoint", "dropped", "partial graph", "hits an obstacle"} <= set(legend(axes))


def test_the_partial_graph_is_drawn_edge_by_edge(scene: Scene, central: dict[str, CentralRoute]) -> None:
    axes = draw(scene, routes={"R2": central["R2"]})
    graphs = [c for c in axes.collections if isinstance(c, LineCollection) and c.get_zorder() == 2.8]
    drawn = [piece for graph in graphs for piece in segments(graph)]
    roadmap = central["R2"].roadmap
    assert np.array_equal(np.array(drawn), roadmap.positions[roadmap.edges])


def test_obstacles_that_no_route_used_are_pale(
    scene: Scene, central: dict[str, CentralRoute], oca: dict[str, OcaRoute]
) -> None:
    crossed = {c.name for route in central.values() for c in route.crossed}
    used = {name for route in oca.values() for name in route.used}
    assert crossed != used
    for names, axes in ((crossed, draw(scene, routes=central)), (used, draw(scene, routes=oca))):
        expected = {o.name: OBSTACLE if o.name in names else UNUSED for o in scene.obstacles}
        assert obstacle_colours(axes, scene) == expected


def test_a_plain_route_is_drawn_alone_and_pales_nothing(scene: Scene) -> None:
    route = Route(np.array([scene.robots[0].start, (1, 1), scene.robots[0].goal]))
    axes = draw(scene, routes={"R1": route})
    assert set(obstacle_colours(axes, scene).values()) == {OBSTACLE}
    assert legend(axes) == ["start", "goal"]
    assert lines(axes, robot_colours(1)[0], 4) == [route.points.tolist()]


def test_obstacles_are_grown_by_the_distance_of_each_route(scene: Scene, oca: dict[str, OcaRoute]) -> None:
    axes = draw(scene, routes=oca)
    bands = [c for c in axes.collections if isinstance(c, PathCollection) and 1.4 <= c.get_zorder() <= 1.5]
    first = {o.name: o for o in scene.obstacles}
    widths = set()
    for band, (route, filled) in zip(
        bands, ((r, filled) for r in oca.values() for filled in (False, True)), strict=True
    ):
        names = [o.name for o in scene.obstacles if (o.name in route.used) == filled]
        for path, name in zip(band.get_paths(), names, strict=True):
            widths.add(round(first[name].core[:, 0].min() - left_end(path), 3))
    assert widths == {0.3, 0.2}


def test_steps_build_on_each_other(scene: Scene, central: dict[str, CentralRoute]) -> None:
    counts = []
    for step in STEPS:
        axes = sheet(scene_view(scene))
        draw_steps(axes, scene, central, step)
        counts.append((len(dots(axes, WAYPOINT)), sum(c.get_zorder() == 2.8 for c in axes.collections)))
        assert bool(dots(axes, HIT)) == (step == "path")
    waypoints = sum(len(route.waypoints) for route in central.values())
    assert counts == [(0, 0), (waypoints, 0), (waypoints, 3), (waypoints, 3)]


def test_a_route_alone_is_drawn_on_what_it_knows_of_the_map(
    central: dict[str, CentralRoute], oca: dict[str, OcaRoute]
) -> None:
    one, other = draw(central["R2"]), draw(oca["R1"])
    assert "hits O1" in one.get_title("right")
    assert "3 of 6 obstacles" in other.get_title("right")
    for axes, route in ((one, central["R2"]), (other, oca["R1"])):
        assert dots(axes, START) == rounded(route.points[:1])
        assert dots(axes, GOAL) == rounded(route.points[-1:])
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        assert (low <= route.points).all()
        assert (route.points <= high).all()


def test_routes_need_a_scene_and_its_robots(scene: Scene, central: dict[str, CentralRoute]) -> None:
    with pytest.raises(TypeError, match="routes= needs a Scene"):
        draw(central["R1"], routes=central)
    with pytest.raises(TypeError, match="no graph="):
        draw(scene, routes=central, graph=central["R1"].roadmap)
    with pytest.raises(ValueError, match="R7, which the scene does not have"):
        draw(scene, routes={"R7": central["R1"]})


def panels(figure: Figure) -> list[tuple[str, str]]:
    return [(axes.get_title("left"), axes.get_title("right")) for axes in figure.axes]


def test_the_four_steps_of_ca_stand_side_by_side(scene: Scene, central: dict[str, CentralRoute]) -> None:
    found = panels(draw_central_steps(scene, central))
    assert [facts for _, facts in found] == [
        "4 of 6 obstacles crossed",
        "22 waypoints, 2 dropped",
        "56 edges",
        "R2 hits an obstacle",
    ]


def test_every_round_of_oca_has_a_panel_with_what_it_hits(scene: Scene) -> None:
    route = oca_path(scene, "R1", clearance=0.3)
    figure = draw_rounds(scene, route)
    assert len(figure.axes) == len(route.rounds)
    known: set[str] = set()
    for axes, step in zip(figure.axes, route.rounds, strict=True):
        known |= set(step.added)
        colours = obstacle_colours(axes, scene)
        assert {name for name, colour in colours.items() if colour == OBSTACLE} == known
        assert {name for name, colour in colours.items() if colour not in (OBSTACLE, UNUSED)} == set(step.hit)
    assert panels(figure)[-1][1] == f"{route.length:.2f} m, hits nothing"


def test_pictures_are_files_that_are_the_same_twice(
    scene: Scene, central: dict[str, CentralRoute], oca: dict[str, OcaRoute], tmp_path: Path
) -> None:
    for k in (1, 2):
        save_figure(scene, tmp_path / f"routes-{k}.png", routes=central)
        save_central_steps(scene, central, tmp_path / f"steps-{k}.png")
        save_rounds(scene, oca["R1"], tmp_path / f"rounds-{k}.png")
    for name in ("routes", "steps", "rounds"):
        assert (tmp_path / f"{name}-1.png").read_bytes() == (tmp_path / f"{name}-2.png").read_bytes()
        with Image.open(tmp_path / f"{name}-1.png") as picture:
            assert len(picture.convert("RGB").getcolors(1 << 24) or ()) > 50
