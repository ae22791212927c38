"""The 200 committed teams that can keep contact, with a witness for each: reading them, and making them anew.

``python benchmarks/contact_instances.py [FOLDER]`` makes them: every name asks `random_team_in_contact` for one team,
with the first seed from 1 on that yields one. Each file holds the witness, a plan with its scene, as gzipped JSON.
"""

from __future__ import annotations

import gzip
import json
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from taut.errors import SceneError
from taut.formats.convert import plan_from_dict, plan_to_dict
from taut.generate.contact import random_team_in_contact
from taut.motion import Plan

FOLDER = Path(__file__).resolve().parent / "contact"
TEAMS = (5, 10, 15, 25, 35, 50)
REACHES = (4, 6, 10, 16)
"""In units of 0.5 m, the (mean) diameter of the robots."""

HARDEST = 25
"""Team size at which most are to be solved: there each reach has two instances more."""

_DIAMETER = 0.5
KINDS = tuple((ground, formation) for ground in ("hall", "rooms", "corner") for formation in ("swarm", "chain"))


@dataclass(frozen=True)
class Asked:
    """One instance: its team, reach in diameters, ground and formation; whether in sight, and of mixed robots."""

    robots: int
    reach: int
    ground: str
    formation: str
    sight: bool = False
    mixed: bool = False

    @property
    def name(self) -> str:
        """Of the instance, its scene and its file."""
        words = [f"{self.robots:02d}", f"r{self.reach:02d}", self.ground, self.formation]
        return "-".join([*words, *["sight"] * self.sight, *["mixed"] * self.mixed])

    def made(self) -> Plan:
        """Make the witness; the first seed that yields one is taken."""
        radius, speed = ((0.2, 0.3), (0.8, 1.2)) if self.mixed else (_DIAMETER / 2, 1.0)
        for seed in range(1, 100):
            try:
                return random_team_in_contact(
                    self.robots,
                    self.reach * _DIAMETER,
                    seed,
                    ground=self.ground,
                    formation=self.formation,
                    sight=self.sight,
                    radius=radius,
                    speed=speed,
                    name=self.name,
                )[1]
            except SceneError as error:
                print(f"{self.name}, seed {seed}: {error}", flush=True)
        raise SceneError(f"{self.name}: no seed yields a team")


def asked() -> Iterator[Asked]:
    """All instances: six kinds, one with mixed robots and one in sight for each team size and reach, two more at 25."""
    turn = 0
    for robots in TEAMS:
        for reach in REACHES:
            yield from (Asked(robots, reach, *kind) for kind in KINDS)
            yield Asked(robots, reach, "hall", "swarm", mixed=True)
            for _ in range(3 if robots == HARDEST else 1):
                yield Asked(robots, reach, *KINDS[turn % len(KINDS)], sight=True)
                turn += 1


def witness(name: str) -> Plan:
    """Read the witness of an instance; its scene is the instance, its claim the contact asked for."""
    return plan_from_dict(json.loads(gzip.decompress((FOLDER / f"{name}.json.gz").read_bytes())))


def main() -> None:
    """Make all instances into a folder."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for one in asked():
        began = time.perf_counter()
        plan = one.made()
        text = json.dumps(plan_to_dict(plan), separators=(",", ":"))
        packed = gzip.compress(text.encode(), mtime=0)
        (folder / f"{one.name}.json.gz").write_bytes(packed)
        print(f"{one.name}: {plan.makespan:g} s, {len(packed)} bytes, {time.perf_counter() - began:.1f} s", flush=True)


if __name__ == "__main__":
    main()
