"""Why a robot is later, or goes farther, than it would alone."""

from __future__ import annotations

import numpy as np

from taut.motion import Plan
from taut.team import _kernels
from taut.team._kernels import Floats
from taut.team.reservations import Reservations
from taut.team.world import World


def explain(world: World, plan: Plan, earliest: np.ndarray) -> tuple[str, ...]:
    """Per robot: whom it would have met, where and when, on its shortest way at top speed; "" if it lost nothing.

    ``earliest`` (n,) is each robot's arrival if it were alone, seconds.
    """
    scene = world.scene
    reservations = Reservations(scene, world.cell, world.horizon)
    for i, trajectory in enumerate(plan.trajectories):
        reservations.take(i, trajectory)
    out = []
    for i, trajectory in enumerate(plan.trajectories):
        robot, route = scene.robots[i], world.routes[i]
        late = trajectory.arrival - earliest[i] > 1e-9 * max(1.0, earliest[i])
        if not late or len(route.points) < 2:
            out.append("")
            continue
        tau = np.hypot(*np.diff(route.points, axis=0).T) / robot.speed
        depart = robot.start_time + np.append(0.0, np.cumsum(tau)[:-1])
        points = np.ascontiguousarray(route.points)
        arrays = reservations.arrays
        legs, edges = _kernels.blockers(points, tau, depart, arrays, i, world.body(i))
        met: dict[int, tuple[float, float, float]] = {}
        for leg, k in zip(legs.tolist(), edges.tolist(), strict=True):
            there = _closest_approach(arrays[0][leg], points[k], points[k + 1], float(depart[k]), float(tau[k]))
            other = int(arrays[1][leg])
            if other not in met or there < met[other]:
                met[other] = there
        out.append(_sentence({scene.robots[j].name: there for j, there in met.items()}))
    return tuple(out)


def _closest_approach(leg: Floats, a: Floats, b: Floats, depart: float, tau: float) -> tuple[float, float, float]:
    """Time and place (on the edge from a to b) at which the two are nearest while both move on these pieces."""
    x0, y0, t0, x1, y1, t1 = leg.tolist()
    begin, end = max(t0, depart), min(t1, depart + tau)
    own = (b - a) / tau
    theirs = np.array([x1 - x0, y1 - y0]) / (t1 - t0)
    apart = a - own * depart - (np.array([x0, y0]) - theirs * t0)
    relative = own - theirs
    square = float(relative @ relative)
    t = begin if square == 0 else min(max(-float(apart @ relative) / square, begin), end)
    x, y = a + own * (t - depart)
    return t, float(x), float(y)


def _sentence(met: dict[str, tuple[float, float, float]]) -> str:
    if not met:
        return "gives way to starts held for robots planned later"
    (name, (t, x, y)), *others = sorted(met.items(), key=lambda item: item[1])
    more = f" and {len(others)} more" if others else ""
    return f"gives way to {name} near ({x:.2f}, {y:.2f}) at {t:.2f} s{more}"
