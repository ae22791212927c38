"""Random teams in contact are repeatable and valid, and their witnesses prove that they can be planned."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from contact_instances import FOLDER, TEAMS, asked, witness
from sound import core
from taut.certificate import certify
from taut.contact import Contact, contact_of
from taut.errors import SceneError
from taut.generate.contact import random_team_in_contact
from taut.motion import Plan
from taut.scene import Scene
from taut.validation import validate

GROUNDS = ("hall", "rooms", "corner")
FORMATIONS = ("swarm", "chain")


def sampled_losses(plan: Plan) -> list[float]:
    """Times, at stamps and twice between any two, at which the team is not connected: by networkx and shapely."""
    demand = contact_of(plan.claims["contact"])  # type: ignore[arg-type]
    scene = plan.scene
    # an oracle without any of taut's geometry: what is a millionth inside an obstacle is in the way
    solids = [core(o).buffer(o.own_radius - 1e-6) if o.own_radius else core(o).buffer(-1e-6) for o in scene.obstacles]
    clear = shapely.Polygon(scene.workspace).buffer(1e-6).difference(shapely.union_all(solids))
    shapely.prepare(clear)
    stamps = sorted({float(t) for path in plan.trajectories for t in path.times})
    times = [a + (b - a) * k / 3 for a, b in pairwise(stamps) for k in range(3)] + stamps[-1:]
    out = []
    for time in times:
        places = plan.at(time)
        graph = nx.empty_graph(len(places))
        near = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) <= demand.reach
        i, j = np.nonzero(np.triu(near, 1))
        seen = shapely.covers(clear, shapely.linestrings(np.stack([places[i], places[j]], axis=1)))
        graph.add_edges_from(zip(i[seen], j[seen], strict=True) if demand.sight else zip(i, j, strict=True))
        if not nx.is_connected(graph):
            out.append(time)
    return out


def mean_trip(scene: Scene) -> float:
    return float(np.mean([math.dist(robot.start, robot.goal) for robot in scene.robots]))


def test_the_same_arguments_give_the_same_scene_and_witness_bit_for_bit() -> None:
    wanted: dict[str, Any] = {"robots": 8, "reach": 2.0, "radius": (0.2, 0.3), "speed": (0.8, 1.2)}
    first, second = (random_team_in_contact(seed=3, **wanted) for _ in range(2))
    assert first[0] == second[0]
    assert first[1].trajectories == second[1].trajectories
    assert random_team_in_contact(seed=4, **wanted)[0] != first[0]


def test_the_global_generator_of_numpy_is_neither_used_nor_moved() -> None:
    np.random.seed(1)  # noqa: NPY002
    before = np.random.get_state()[1].tolist()  # type: ignore[index]  # noqa: NPY002
    random_team_in_contact(4, 2.0, 1)
    assert np.random.get_state()[1].tolist() == before  # type: ignore[index]  # noqa: NPY002


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize(("formation", "sight"), [("swarm", False), ("chain", True)])
def test_a_witness_is_certified_with_its_claim(ground: str, formation: str, sight: bool) -> None:
    scene, plan = random_team_in_contact(9, 3.0, 2, ground=ground, formation=formation, sight=sight)
    assert validate(scene) == ()
    assert plan.scene == scene
    assert plan.claims == {"contact": Contact(3.0, sight).claim}
    proof = certify(plan, scene)
    assert proof.problems == ()
    assert proof.contact is not None
    assert proof.contact.demand == Contact(3.0, sight)


@settings(deadline=None, max_examples=6)
@given(
    seed=st.integers(0, 2**32),
    robots=st.integers(1, 8),
    ground=st.sampled_from(GROUNDS),
    formation=st.sampled_from(FORMATIONS),
    sight=st.booleans(),
    mixed=st.booleans(),
)
def test_a_witness_is_never_out_of_contact(
    seed: int, robots: int, ground: str, formation: str, sight: bool, mixed: bool
) -> None:
    radius, speed = ((0.2, 0.3), (0.8, 1.2)) if mixed else (0.25, 1.0)
    try:
        scene, plan = random_team_in_contact(
            robots, 2.5, seed, ground=ground, formation=formation, sight=sight, radius=radius, speed=speed
        )
    except SceneError:
        assume(False)
    assert certify(plan).ok
    assert sampled_losses(plan) == []
    assert mean_trip(scene) > 0.3 * scene.workspace[1][0]


def test_a_witness_with_less_reach_than_it_needs_is_refused_by_the_oracle() -> None:
    _, plan = random_team_in_contact(9, 2.0, 2, formation="chain")
    short = replace(plan, claims={"contact": Contact(0.8).claim})
    assert sampled_losses(short) != []
    assert not certify(short).ok


def test_a_chain_is_longer_at_its_goals_than_a_swarm() -> None:
    def spread(formation: str) -> float:
        scene, _ = random_team_in_contact(12, 3.0, 1, formation=formation)
        return max(math.dist(a.goal, b.goal) for a, b in combinations(scene.robots, 2))

    assert spread("chain") > 1.5 * spread("swarm")


def test_the_order_of_the_robots_mixes_on_the_way() -> None:
    scene, _ = random_team_in_contact(15, 3.0, 1)
    middle = [np.mean([getattr(robot, end) for robot in scene.robots], axis=0) for end in ("start", "goal")]
    way = middle[1] - middle[0]
    first, last = (np.argsort([np.dot(getattr(r, end), way) for r in scene.robots]) for end in ("start", "goal"))
    assert not np.array_equal(first, last)


def test_robots_and_speeds_lie_in_their_ranges() -> None:
    scene, plan = random_team_in_contact(10, 3.0, 1, radius=(0.2, 0.3), speed=(0.8, 1.2), clearance=0.1, gap=0.07)
    assert all(0.2 <= robot.radius <= 0.3 and 0.8 <= robot.speed <= 1.2 for robot in scene.robots)
    assert len({robot.speed for robot in scene.robots}) > 5
    assert (scene.clearance, scene.gap) == (0.1, 0.07)
    assert 0.9 < certify(plan).max_speed_ratio <= 1.0


def test_one_robot_goes_alone() -> None:
    scene, plan = random_team_in_contact(1, 2.0, 1)
    assert certify(plan).ok
    assert mean_trip(scene) > 5


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ({"robots": 0}, "robots must be at least 1"),
        ({"robots": 2.5}, "robots must be a whole number"),
        ({"robots": 1001}, "robots must be at most 1000"),
        ({"seed": -1}, "seed must be a whole number"),
        ({"obstacles": -1}, "obstacles must be a whole number"),
        ({"reach": 0.0}, "range must be positive"),
        ({"reach": math.nan}, "range must be a finite number"),
        ({"reach": 0.5}, "reach of 0.5 m is too short"),
        ({"reach": 1e9}, "reach must be between"),
        ({"ground": "lake"}, "ground: 'lake' is unknown, take hall, rooms, corner"),
        ({"formation": "row"}, "formation: 'row' is unknown, take swarm, chain"),
        ({"sight": 1}, "sight must be true or false"),
        ({"size": 0.0}, "size must be between"),
        ({"size": "wide"}, "size must be a number"),
        ({"radius": 0.0}, "radius must be above 0"),
        ({"speed": (2.0, 1.0)}, "speed must be above 0, lowest first"),
        ({"size": 5.0}, "size must be between 5.5"),
        ({"size": 6.0, "obstacles": 0, "robots": 90}, "got stuck in a hall of 6 × 6 m"),
        ({"size": 6.0, "obstacles": 900}, "900 obstacles do not fit"),
        ({"clearance": (0.1, 0.2)}, "clearance must be a number"),
    ],
)
def test_senseless_arguments_are_refused_in_one_line(words: dict[str, Any], text: str) -> None:
    with pytest.raises(SceneError) as told:
        random_team_in_contact(**words)
    assert text in str(told.value)
    assert "\n" not in str(told.value)


def test_there_are_200_committed_instances_of_the_teams_and_reaches_told() -> None:
    instances = list(asked())
    names = [one.name for one in instances]
    assert len(set(names)) == len(names) == 200
    assert {path.name.removesuffix(".json.gz") for path in FOLDER.iterdir()} == set(names)
    assert sum(one.robots == 25 for one in instances) == 40
    assert sum(one.sight for one in instances) == 32
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 3_000_000


@pytest.mark.parametrize("one", list(asked())[::23], ids=lambda one: one.name)
def test_a_committed_witness_is_certified(one: Any) -> None:
    plan = witness(one.name)
    scene = plan.scene
    assert scene.name == one.name
    assert len(scene.robots) == one.robots
    assert one.robots in TEAMS
    assert plan.claims == {"contact": Contact(one.reach / 2, one.sight).claim}
    assert validate(scene) == ()
    assert certify(plan).problems == ()
    assert mean_trip(scene) > 0.25 * scene.workspace[1][0]
