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
from taut.scene import Scene
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
    names, obstacles : names of its robots and obstacles.
    planned : makespan of the plan, seconds.
    vehicle : what they drive.
    disturbances : what the runs met.
    coordinated : whether late robots slowed those that pass after them.
    dt : seconds of a step.
    trials : the runs, by seed.
    margin : drawn from them.
    """

    scene: str
    names: tuple[str, ...]
    obstacles: tuple[str, ...]
    planned: float
    vehicle: str
    disturbances: Mapping[str, object]
    coordinated: bool
    dt: float
    trials: tuple[Trial, ...]
    margin: Margin

    @property
    def robots(self) -> int:
        """How many there are."""
        return len(self.names)

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


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C in a study that had made some runs.

    Parameters
    ----------
    study : of the runs with the first seeds, as many as were done.
    """

    def __init__(self, study: Study) -> None:
        super().__init__()
        self.study = study


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
    StudyInterrupted
        Ctrl-C, when the run with the first seed was done: a KeyboardInterrupt that holds the study so far.

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
    until, lock, given_up = longest(plan), threading.Lock(), threading.Event()
    trials: dict[int, Trial] = {}

    def run(first: int, last: int) -> None:
        try:
            driven = drive(setting, met, given[first], until, 0, given_up=given_up)
            with lock:
                trials[first] = _trial(given[first], driven)
                if tell is not None:
                    tell(len(trials))
        except BaseException:
            given_up.set()  # the other threads are waited for
            raise

    def found(count: int) -> Study:
        runs = tuple(trials[k] for k in range(count))
        return Study(
            plan.scene.name,
            setting.names,
            tuple(obstacle.name for obstacle in plan.scene.obstacles),
            plan.makespan,
            vehicle if isinstance(vehicle, str) else "given",
            met.as_dict(),
            coordination,
            setting.dt,
            runs,
            tracking_margin([trial.stray for trial in runs], probability, confidence),
        )

    try:
        over_chunks(run, len(given), 1)
    except KeyboardInterrupt:
        # not those that happened to be quick: that would make the margin small
        first_missing = next(k for k in range(len(given) + 1) if k not in trials)
        if first_missing:
            raise StudyInterrupted(found(first_missing)) from None
        raise
    finally:
        given_up.set()
    return found(len(given))


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
        "robots": list(study.names),
        "obstacles": list(study.obstacles),
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
        No such file, or it holds no study; a study whose margin keeps nobody apart: robots did not wait for each other,
        or some never arrived, so that nobody knows how far they would have strayed.
    """
    name = os.fspath(path)
    data = _read(path)
    fields: Any = data.get("margin")
    try:
        metres, probability, confidence = (_number(fields[key]) for key in ("metres", "probability", "confidence"))
        margin = Margin(metres, probability, confidence, _count(fields["runs"]))
        count, complete = _count(data["count"]), _count(data["complete"])
    except (KeyError, TypeError, ValueError, OverflowError):
        raise SceneError("its margin is not that of a study: metres, probability, confidence and runs", name) from None
    except SceneError as error:
        raise error.at(name) from None
    if data.get("coordinated") is not True:
        raise SceneError("is a study without coordination; no margin keeps robots apart that do not wait", name)
    if complete < count:
        raise SceneError(
            f"in {count - complete} of {count} runs not all robots arrived, and what they did not drive is not in the "
            "margin; mend what stopped them and study anew",
            name,
        )
    return margin


def study_doubts(path: str | os.PathLike[str], scene: Scene) -> tuple[str, ...]:
    """Say in what the scene of a study's file differs from a scene that is to be planned with its margin."""
    data = _read(path)
    pairs = (
        ("scene", data.get("scene"), scene.name),
        ("robots", data.get("robots"), [robot.name for robot in scene.robots]),
        ("obstacles", data.get("obstacles"), [obstacle.name for obstacle in scene.obstacles]),
    )
    return tuple(
        f"the study {os.fspath(path)} was made with other {what} than the scene"
        if what != "scene"
        else f"the study {os.fspath(path)} is of the scene {studied!r}, not of {own!r}"
        for what, studied, own in pairs
        if studied != own
    )


def _read(path: str | os.PathLike[str]) -> dict[str, Any]:
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
    except (ValueError, RecursionError):
        raise SceneError("is no study: it is not JSON", name) from None
    if not isinstance(data, dict) or data.get("kind") != "study":
        raise SceneError("is no study; write one with: taut simulate PLAN --seeds 100 -o study.json", name)
    return data


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    return float(value)


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError
    return value


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
