"""Studies: many runs of one plan with different seeds, what they have in common, and files of them."""

from __future__ import annotations

import json
import math
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from taut.chunks import over_chunks
from taut.errors import OutputError, SceneError
from taut.motion import Plan
from taut.simulation.disturbances import Disturbances
from taut.simulation.driving import Driven, drive
from taut.simulation.margin import Margin, tracking_margin
from taut.simulation.running import checked_seed, longest, prepared
from taut.simulation.vehicles import Vehicle
from taut.writing import write_text


@dataclass(frozen=True)
class Trial:
    """One run of a study.

    Parameters
    ----------
    seed : of the run.
    arrived : how many robots arrived.
    makespan : last arrival, seconds; of those that arrived.
    seconds : how long it lasted.
    stray : greatest distance of a robot from its path, metres.
    clearance, separation : least distance from obstacles and between robots, outline to outline, metres; None if none
        came near enough to be measured.
    collisions : how many.
    lost : seconds that robots lost waiting for others, all together.
    """

    seed: int
    arrived: int
    makespan: float
    seconds: float
    stray: float
    clearance: float | None
    separation: float | None
    collisions: int
    lost: float


@dataclass(frozen=True)
class Study:
    """Runs of one plan.

    Parameters
    ----------
    scene : name of the plan's scene.
    robots : how many there are.
    planned : makespan of the plan, seconds.
    vehicle : what they drive.
    disturbances : what the runs met.
    coordinated : whether late robots slowed those that pass after them.
    dt : seconds of a step.
    trials : the runs, by seed.
    margin : drawn from them.
    """

    scene: str
    robots: int
    planned: float
    vehicle: str
    disturbances: Mapping[str, object]
    coordinated: bool
    dt: float
    trials: tuple[Trial, ...]
    margin: Margin

    @property
    def collided(self) -> int:
        """Runs with at least one collision."""
        return sum(trial.collisions > 0 for trial in self.trials)

    @property
    def complete(self) -> int:
        """Runs in which all robots arrived."""
        return sum(trial.arrived == self.robots for trial in self.trials)

    @property
    def makespans(self) -> tuple[float, float, float]:
        """Least, median and greatest makespan, seconds."""
        values = [trial.makespan for trial in self.trials]
        return min(values), float(np.median(values)), max(values)


def study(
    plan: Plan,
    seeds: Sequence[int],
    vehicle: str | Vehicle | Mapping[str, str | Vehicle] = "differential",
    disturbances: Disturbances | None = None,
    coordination: bool = True,
    dt: float = 0.02,
    probability: float = 0.999,
    confidence: float = 0.95,
    tell: Callable[[int], None] | None = None,
) -> Study:
    """Let a team follow a plan once for every seed, on all cores, and draw a tracking margin from how far it strayed.

    Parameters
    ----------
    seeds : one run each; the same seeds give the same study, whatever the number of cores.
    vehicle, disturbances, coordination, dt : as in `simulate`.
    probability, confidence : of the margin, see `tracking_margin`.
    tell : told how many runs are done whenever one is; from any thread, one at a time.

    Raises
    ------
    PlanError
        The plan does not hold.
    SceneError
        No seeds, or as `simulate` and `tracking_margin`.

    Examples
    --------
    >>> from taut import Robot, Scene, plan
    >>> still = plan(Scene((0, 0, 4, 4), robots=[Robot("R1", (1, 1), (3, 1), radius=0.2)])).plan
    >>> study(still, range(4), disturbances=Disturbances(speed_error=0.2)).complete
    4
    """
    given = [checked_seed(seed) for seed in seeds]
    if not given:
        raise SceneError("a study needs at least one seed")
    tracking_margin([0.0], probability, confidence)  # its errors come before the work
    met = disturbances or Disturbances()
    setting, _ = prepared(plan, vehicle, coordination, dt, met.position_noise)
    until, lock = longest(plan), threading.Lock()
    done = 0

    def run(first: int, last: int) -> Trial:
        nonlocal done
        trial = _trial(given[first], drive(setting, met, given[first], until, 0))
        if tell is not None:
            with lock:
                done += 1
                tell(done)
        return trial

    trials = tuple(over_chunks(run, len(given), 1))
    return Study(
        plan.scene.name,
        len(setting.names),
        plan.makespan,
        vehicle if isinstance(vehicle, str) else "given",
        met.as_dict(),
        coordination,
        dt,
        trials,
        tracking_margin([trial.stray for trial in trials], probability, confidence),
    )


def save_study(study: Study, path: str | os.PathLike[str]) -> None:
    """Write a study: a .json file with a line a run, or .jsonl with the runs and at the end the summary.

    Raises
    ------
    OutputError
        Another ending, or an unwritable path.
    """
    suffix = Path(path).suffix.lower()
    lines = [json.dumps(vars(trial), allow_nan=False) for trial in study.trials]
    summary = json.dumps(study_summary(study), allow_nan=False)
    if suffix == ".jsonl":
        write_text(path, "\n".join([*lines, summary]) + "\n")
    elif suffix == ".json":
        write_text(path, summary[:-1] + ', "runs": [\n' + ",\n".join(lines) + "\n]}\n")
    else:
        raise OutputError(f"{os.fspath(path)}: a study is written as .json or .jsonl")


def study_summary(study: Study) -> dict[str, Any]:
    """Return a study as plain data, without its runs."""
    least, median, greatest = study.makespans
    return {
        "taut": 1,
        "kind": "study",
        "scene": study.scene,
        "robots": study.robots,
        "vehicle": study.vehicle,
        "disturbances": dict(study.disturbances),
        "coordinated": study.coordinated,
        "dt": study.dt,
        "count": len(study.trials),
        "complete": study.complete,
        "collided": study.collided,
        "planned": study.planned,
        "makespan": {"least": least, "median": median, "greatest": greatest},
        "margin": vars(study.margin),
    }


def load_margin(path: str | os.PathLike[str]) -> Margin:
    """Read the margin of a study from its file.

    Raises
    ------
    SceneError
        No such file, or it holds no study.
    """
    name = os.fspath(path)
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror or error}", name) from None
    except UnicodeDecodeError:
        raise SceneError("is no study: it is not text", name) from None
    try:
        last = text.rstrip().rsplit("\n", 1)[-1] if Path(path).suffix.lower() == ".jsonl" else text
        data = json.loads(last)
    except (json.JSONDecodeError, RecursionError):
        raise SceneError("is no study: it is not JSON", name) from None
    if not isinstance(data, dict) or data.get("kind") != "study":
        raise SceneError("is no study; write one with: taut simulate PLAN --seeds 100 -o study.json", name)
    fields: Any = data.get("margin")
    try:
        metres, probability, confidence = (float(fields[key]) for key in ("metres", "probability", "confidence"))
        return Margin(metres, probability, confidence, int(fields["runs"]))
    except (KeyError, TypeError, ValueError):
        raise SceneError("its margin is not that of a study: metres, probability, confidence and runs", name) from None
    except SceneError as error:
        raise error.at(name) from None


def _trial(seed: int, driven: Driven) -> Trial:
    arrived = np.isfinite(driven.now.arrived)
    return Trial(
        seed=seed,
        arrived=int(arrived.sum()),
        makespan=float(driven.now.arrived[arrived].max(initial=0.0)),
        seconds=driven.seconds,
        stray=float(driven.tally.worst[:, 0].max(initial=0.0)),
        clearance=_finite(driven.tally.clear[:, 0].min(initial=math.inf)),
        separation=_finite(driven.tally.apart[:, 0].min(initial=math.inf)),
        collisions=len(driven.collisions),
        lost=float(driven.held[:, 4].sum()),
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
