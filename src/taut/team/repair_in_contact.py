"""Repair in contact: a plan that keeps a team connected improved by planning some robots earlier than before."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

import numpy as np

from taut.interrupts import held_back
from taut.motion import Trajectory
from taut.team.in_contact import Stretch, Together, follow, joined
from taut.team.prioritized import Round
from taut.team.repair import Objective, Repaired, check_repair, costs_of, total_cost
from taut.team.reservations import clear
from taut.team.safe_intervals import Bench, bench_of, hold_start, take
from taut.team.ties import linked_order
from taut.team.world import World


def repaired_together(
    world: World,
    found: Together,
    seed: int | Sequence[int] = 0,
    rounds: int | None = None,
    until: float = math.inf,
    objective: Objective = "sum_of_costs",
    progress: Callable[[int, float], None] | None = None,
) -> tuple[Together, Repaired]:
    """Improve a plan in contact: a delayed robot is planned earlier in the order, and all after it anew.

    Each robot stays in contact with some before it, so the others' motions cannot be kept as they are when one changes;
    but those before it in the order can. What is better is kept. A round is one try.

    Parameters
    ----------
    found : a plan; each stretch between the places where it gathers is improved by itself.
    seed, rounds, until, objective, progress : see `taut.team.repair.repaired`.

    Raises
    ------
    ValueError
        As there.
    """
    whole = joined(world, found.stretches)
    check_repair(whole, seed, rounds, until, objective)
    history = [_cost(world, whole, objective)]
    stretches = list(found.stretches)
    most = math.inf if rounds is None else rounds
    done = 0
    with held_back() as interrupted:  # there is a plan: it must not be lost
        rng = np.random.default_rng(seed)
        benches = [bench_of(stretch.world) for stretch in stretches]
        while done < most and time.monotonic() <= until and not interrupted():
            k = done % len(stretches)
            # who gathers waits for the last
            aim = objective if k == len(stretches) - 1 else "makespan"
            stretches[k] = _tried(stretches[k], benches[k], rng, aim)
            done += 1
            whole = joined(world, stretches)
            history.append(min(_cost(world, whole, objective), history[-1]))
            if progress is not None:
                progress(done, history[-1])
        stopped = interrupted()
    motions = tuple(motion for motion in whole.trajectories if motion is not None)
    better = Together(tuple(stretches), found.passes)
    return better, Repaired(motions, history[-1], done, np.array(history), stopped)


def _cost(world: World, whole: Round, objective: Objective) -> float:
    return total_cost(
        world, costs_of(world, [motion for motion in whole.trajectories if motion is not None]), objective
    )


def _tried(stretch: Stretch, bench: Bench, rng: np.random.Generator, objective: Objective) -> Stretch:
    """Try another order; the stretch as it was unless that is better."""
    world, ties, passed = stretch.world, stretch.ties, stretch.passed
    motions = {i: motion for i, motion in enumerate(passed.trajectories) if motion is not None}
    costs = costs_of(world, [motions[i] for i in range(len(motions))])
    delays = np.maximum(costs - bench.team.least, 0.0)
    if not (delays > 1e-9 * np.maximum(costs, 1.0)).any():
        return stretch
    order = linked_order(ties, _sooner(passed.order, delays, rng))
    same = next((k for k, (a, b) in enumerate(zip(order, passed.order, strict=True)) if a != b), len(order))
    if same == len(order):
        return stretch
    clear(bench.table)
    kept = {i: motions[i] for i in order[:same]}
    for i in order:
        if i in kept:
            take(bench, i, kept[i])
        else:
            hold_start(bench, i, world.scene.robots[i].start_time + passed.hold)
    before = total_cost(world, costs, objective), float(costs.sum())
    spent = float(costs[order[:same]].sum() - bench.team.least[order[:same]].sum())
    most = before[1] - spent if objective == "sum_of_costs" else math.inf
    if follow(world, ties, bench, order, kept, stretch.slowed, most * (1 + 1e-12)) is not None:
        return stretch
    found: list[Trajectory] = [kept[i] for i in range(len(kept))]
    new = costs_of(world, found)
    if (total_cost(world, new, objective), float(new.sum())) >= before:
        return stretch
    return Stretch(world, ties, Round(tuple(order), passed.hold, tuple(found), ()), None, (), stretch.slowed)


def _sooner(order: Sequence[int], delays: np.ndarray, rng: np.random.Generator) -> list[int]:
    """The order with a delayed robot, or any, somewhere earlier; now and then two of them."""
    out = list(order)
    for _ in range(1 + int(rng.random() < 0.3)):
        weights = delays / delays.sum() if rng.random() < 0.8 else None
        i = int(rng.choice(len(out), p=weights))
        at = out.index(i)
        if at:
            out.remove(i)
            out.insert(int(rng.integers(at)), i)
    return out
