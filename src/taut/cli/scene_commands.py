"""The commands about scenes: check, random, random-warehouse, scenes, warmup."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from taut.cli.options import JsonOption, SceneArgument
from taut.cli.output import about, complain, progress, require_writable, say, say_facts, say_json
from taut.cli.reports import reach_report, say_scene, scene_report
from taut.cli.tables import say_table

if TYPE_CHECKING:
    from taut.scene import Scene

SCENES = (".yaml", ".yml", ".json", ".geojson")


OutputOption: TypeAlias = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="SCENE", help="Write the scene (.yaml, .json, .geojson).")
]
SeedOption: TypeAlias = Annotated[int, typer.Option(min=0, help="Same numbers and seed: same scene.")]
ClearanceOption: TypeAlias = Annotated[float, typer.Option(help="Kept free from obstacles and wall, m.")]
GapOption: TypeAlias = Annotated[float, typer.Option(help="Kept free between robots, m.")]


def check(scene: SceneArgument, as_json: JsonOption = False) -> None:
    """Check a scene: what is in it, what was united, and whether every robot can reach its goal."""
    from taut.formats import load_scene
    from taut.validation import validate

    world = load_scene(scene)
    with about(scene), progress("looking for paths"):
        notes = validate(world)
        robots = reach_report(world, world.robots)
    cut_off = [robot for robot in robots if robot["shortest"] is None]
    if as_json:
        say_json({"ok": not cut_off, **scene_report(world), "notes": list(notes), "reach": robots})
    else:
        say_scene(scene_report(world))
        for note in notes:
            say(f"note: {note}")
        if robots:
            say()
            rows = [[r["name"], "no" if r["shortest"] is None else f"{r['shortest']:.4f}", r["reason"]] for r in robots]
            heads = ["robot", "shortest (m)", "why not"]
            keep = 3 if cut_off else 2
            say_table(heads[:keep], [row[:keep] for row in rows], left=("robot", "why not"))
    if cut_off:
        first = cut_off[0]["name"]
        complain(f"{scene}: {len(cut_off)} of {len(robots)} robots cannot reach their goals, the first is {first}")


def random(
    output: OutputOption = None,
    robots: Annotated[int, typer.Option(min=0, help="How many robots.")] = 10,
    obstacles: Annotated[int, typer.Option(min=0, help="How many obstacles.")] = 20,
    seed: SeedOption = 0,
    size: Annotated[str | None, typer.Option(metavar="S|W,H", help="Side, or width and height of the hall, m.")] = None,
    density: Annotated[float | None, typer.Option(help="Share of the hall that obstacles cover.")] = None,
    obstacle_size: Annotated[
        str, typer.Option(metavar="D|D,D", help="Diameter of the obstacles or its range, m.")
    ] = "1,4",
    radius: Annotated[str, typer.Option(metavar="R|R,R", help="Radius of the robots or its range, m.")] = "0.3",
    speed: Annotated[str, typer.Option(metavar="V|V,V", help="Speed of the robots or its range, m/s.")] = "1",
    clearance: ClearanceOption = 0.0,
    gap: GapOption = 0.05,
    leave: Annotated[bool, typer.Option("--leave", help="Robots leave at their goals instead of staying.")] = False,
    well_formed: Annotated[
        bool, typer.Option("--well-formed", help="Every robot has a way past all other starts and goals.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Make a random scene; without --output print it."""
    require_writable(output, "a scene", SCENES)
    from taut.generate import random_scene

    with progress("making a scene"):
        scene = random_scene(
            robots,
            obstacles,
            seed,
            size=None if size is None else _range(size, "--size"),
            density=density,
            obstacle_size=_range(obstacle_size, "--obstacle-size"),
            radius=_range(radius, "--radius"),
            speed=_range(speed, "--speed"),
            clearance=clearance,
            gap=gap,
            at_goal="leave" if leave else "stay",
            well_formed=well_formed,
        )
    _hand_over(scene, output, as_json)


def random_warehouse(
    output: OutputOption = None,
    robots: Annotated[int, typer.Option(min=1, help="How many robots.")] = 20,
    seed: SeedOption = 0,
    shelf: Annotated[str, typer.Option(metavar="W,H", help="Width and height of a shelf, m.")] = "1,4",
    aisle: Annotated[float | None, typer.Option(help="Width of the aisles, m; one robot wide if not given.")] = None,
    cross: Annotated[float | None, typer.Option(help="Width of the cross aisles, m; likewise.")] = None,
    radius: Annotated[float, typer.Option(help="Radius of the robots, m.")] = 0.3,
    speed: Annotated[float, typer.Option(help="Speed of the robots, m/s.")] = 1.0,
    clearance: ClearanceOption = 0.0,
    gap: GapOption = 0.05,
    as_json: JsonOption = False,
) -> None:
    """Make a random warehouse: shelves, and aisles one robot wide; without --output print it."""
    require_writable(output, "a scene", SCENES)
    from taut import generate

    sides = _range(shelf, "--shelf")
    if not isinstance(sides, tuple):
        raise typer.BadParameter(
            f"must be a width and a height with a comma between, got {shelf!r}", param_hint="--shelf"
        )
    with progress("making a scene"):
        scene = generate.random_warehouse(
            robots,
            seed,
            shelf=sides,
            aisle=aisle,
            cross=cross,
            radius=radius,
            speed=speed,
            clearance=clearance,
            gap=gap,
        )
    _hand_over(scene, output, as_json)


def _hand_over(scene: Scene, output: Path | None, as_json: bool) -> None:
    """Print a scene that was made, or write it and say so."""
    from taut.formats import save

    if output is None:
        _print_scene(scene, as_json)
        return
    save(scene, output)
    if as_json:
        say_json({**scene_report(scene), "files": [str(output)]})
    else:
        say_scene(scene_report(scene))
        say(f"wrote {output}")


def scenes(as_json: JsonOption = False) -> None:
    """List the ready scenes."""
    from taut.formats import scene_abouts

    listed = scene_abouts()
    if as_json:
        say_json({"scenes": [{"name": name, "about": about} for name, about in listed]})
        return
    say_facts(listed)


def warmup(as_json: JsonOption = False) -> None:
    """Compile the kernels once, so that the first plan, simulation and steered team do not wait for them."""
    from taut.certificate import certify
    from taut.control import consensus
    from taut.freespace import FreeSpace
    from taut.graph import contact_graph
    from taut.roadmap import visibility_graph
    from taut.route import shortest_path
    from taut.scene import Polygon, Robot, Scene
    from taut.simulation import (
        Detector,
        Disturbances,
        Lidar,
        detect,
        fiedler_values,
        run_data,
        scene_from,
        simulate,
        steer,
        surroundings_of,
    )
    from taut.team import plan as plan_team

    began = time.perf_counter()
    wall = Polygon([(4, 3), (6, 3), (6, 7), (4, 7)])
    # points are certified by more kernels than discs
    robots = [Robot("R1", (1, 5), (9, 5), radius=0.3), Robot("R2", (9, 5.5), (1, 4.5))]
    tiny = Scene((0, 0, 10, 10), [wall], robots, gap=0.05)
    with progress("compiling"):
        certificate = certify(plan_team(tiny, rounds=1).plan)
        for method in ("search", "optimal"):
            plan_team(tiny, method)
        in_contact = plan_team(tiny, contact=9.0).plan
        free = FreeSpace.of(tiny, robots[0])
        visibility_graph(free, edges="all", points=[robots[0].start])
        shortest_path(free, robots[0].start, robots[0].goal)
        run = simulate(in_contact, disturbances=Disturbances(dies={"R2": 1.0}), lidar=Lidar(beams=3, noise=0.01))
        run_data(run)
        scene_from(run)
        detect(Detector(), surroundings_of(tiny), run.poses[0], robot=0)
        near = partial(contact_graph, reach=9.0)
        fiedler_values(steer(tiny, consensus(near), seconds=1.0), near)
    elapsed = time.perf_counter() - began
    if as_json:
        say_json({"ok": certificate.ok, "elapsed": elapsed})
    else:
        say(f"ready: compiled, planned, certified and simulated a small scene in {elapsed:.2f} s")
    if not certificate.ok:
        complain("the plan of the small scene does not hold")


def _range(text: str, option: str) -> float | tuple[float, float]:
    """Read "3" or "1,4"."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    match numbers:
        case [number]:
            return number
        case [low, high]:
            return low, high
        case _:
            raise typer.BadParameter(f"must be a number or two with a comma between, got {text!r}", param_hint=option)


def _print_scene(scene: Scene, as_json: bool) -> None:
    """Print what a file of the scene would hold."""
    from taut.formats import json_text, scene_to_dict, yaml_text

    print((json_text.layout if as_json else yaml_text.scene_yaml)(scene_to_dict(scene)).rstrip("\n"))
