"""What is measured in every step of a closed loop: work, and how near robots come to shapes and to each other."""

from __future__ import annotations

import numpy as np

from taut.simulation._loop_state import COLLISIONS, PAIRS, Floats, Ground, Ints, Near, Now, Tally, Team
from taut.simulation._nearness_kernels import deepest_inside, list_pairs, nearest_passing, nearest_shape
from taut.simulation._vehicle_kernels import INTEGRATOR
from taut.team._lean import lean_kernel

ROLLING = 0.02 * 9.81  # joules per kilogram and metre: hard wheels on a hall's floor


@lean_kernel
def work(kind: int, radius: float, v0: float, w0: float, v1: float, w1: float, dt: float) -> float:
    """Joules per kilogram of a step: gain of kinetic energy, of which braking gives nothing back, and rolling."""
    if kind == INTEGRATOR:
        v0, v1 = np.sqrt(v0 * v0 + w0 * w0), np.sqrt(v1 * v1 + w1 * w1)
        w0 = w1 = 0.0
    gain = 0.5 * (v1 * v1 - v0 * v0) + 0.25 * radius * radius * (w1 * w1 - w0 * w0)
    return max(gain, 0.0) + ROLLING * 0.5 * (abs(v0) + abs(v1)) * dt


@lean_kernel
def measure_ground(
    i: int, ax: float, ay: float, time: float, tol: float, team: Team, ground: Ground, now: Now, tally: Tally,
    collisions: Floats, counts: Ints,
) -> None:  # fmt: skip
    """Note how near robot i has come to the shapes while it moved from a to where it is."""
    bx, by = now.state[i, 0], now.state[i, 1]
    radius, clear, measured = team.radii[i], tally.clear, tally.measured
    measured[i, 1] += np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    within = max(clear[i, 0] + radius, radius)
    if measured[i, 0] - measured[i, 1] > within:
        return
    found, shape = nearest_shape(
        ax, ay, bx, by, 2.0 * within, ground.edges, ground.owner, ground.reach, ground.first, ground.sides,
        ground.x0, ground.y0, ground.size, ground.columns, ground.rows,
    )  # fmt: skip
    if tally.inside[i] or found <= tol:
        deep, around = deepest_inside(bx, by, ground.edges, ground.rings, ground.solid, ground.reach)
        tally.inside[i] = around >= 0
        if deep < found:
            found, shape = deep, around
    # the distance is that of the motion; its end is as near or farther
    measured[i, 0], measured[i, 1] = found, 0.0
    distance = found - radius
    if shape >= 0 and distance < clear[i, 0]:
        clear[i, 0], clear[i, 1], clear[i, 2], clear[i, 3], clear[i, 4] = distance, time, bx, by, shape
    if shape < 0 or distance >= -tol:
        tally.hitting[i] = -1
        return
    if tally.hitting[i] < 0:
        tally.hitting[i] = counts[COLLISIONS]
    for k in range(tally.hitting[i], counts[COLLISIONS]):
        if collisions[k, 0] == i and collisions[k, 1] == -1 - shape:
            collisions[k, 5] = max(collisions[k, 5], -distance)
            return
    _collide(collisions, counts, i, -1 - shape, time, bx, by, -distance)


@lean_kernel
def measure_pairs(
    time: float, dt: float, tol: float, team: Team, now: Now, tally: Tally, near: Near, collisions: Floats, counts: Ints
) -> None:
    """Note how near robots have come to each other in the step that begins at a time, as if they moved evenly."""
    state, before, apart, pairs = now.state, near.before, tally.apart, near.pairs
    for p in range(counts[PAIRS]):
        i, j = pairs[p, 0], pairs[p, 1]
        if now.gone[i] <= time or now.gone[j] <= time:
            continue
        ax, ay = before[j, 0] - before[i, 0], before[j, 1] - before[i, 1]
        bx, by = state[j, 0] - state[i, 0], state[j, 1] - state[i, 1]
        touch = team.radii[i] + team.radii[j]
        least = max(apart[i, 0], apart[j, 0], 0.0) + touch
        longest = abs(bx - ax) + abs(by - ay)
        if bx * bx + by * by > (least + longest) ** 2:
            continue
        distance, s = nearest_passing(ax, ay, bx, by)
        distance -= touch
        xi, yi = (1.0 - s) * before[i, 0] + s * state[i, 0], (1.0 - s) * before[i, 1] + s * state[i, 1]
        xj, yj = (1.0 - s) * before[j, 0] + s * state[j, 0], (1.0 - s) * before[j, 1] + s * state[j, 1]
        when = time + s * dt
        if distance < apart[i, 0]:
            apart[i, 0], apart[i, 1], apart[i, 2], apart[i, 3], apart[i, 4] = distance, when, xi, yi, j
        if distance < apart[j, 0]:
            apart[j, 0], apart[j, 1], apart[j, 2], apart[j, 3], apart[j, 4] = distance, when, xj, yj, i
        if distance >= -tol:
            pairs[p, 2] = -1
        elif pairs[p, 2] < 0:
            pairs[p, 2] = _collide(collisions, counts, i, j, when, (xi + xj) / 2, (yi + yj) / 2, -distance)
        else:
            collisions[pairs[p, 2], 5] = max(collisions[pairs[p, 2], 5], -distance)


@lean_kernel
def list_near(time: float, ground: Ground, team: Team, now: Now, near: Near, collisions: Floats, counts: Ints) -> bool:
    """List anew who may come near whom; a collision that lasts stays the same one. False if there is no room."""
    for i in range(len(near.moved)):
        near.moved[i] = 0.0
    count = list_pairs(
        now.state, now.gone, time, team.radii, near.reach + near.skin, near.most_radius,
        ground.x0, ground.y0, near.size, near.columns, near.rows, near.heads, near.follows, near.pairs,
    )  # fmt: skip
    if count < 0:
        return False
    counts[PAIRS] = count
    for p in range(count):
        i, j = near.pairs[p, 0], near.pairs[p, 1]
        dx, dy = now.state[j, 0] - now.state[i, 0], now.state[j, 1] - now.state[i, 1]
        if dx * dx + dy * dy < (team.radii[i] + team.radii[j]) ** 2:
            for k in range(counts[COLLISIONS] - 1, -1, -1):
                if collisions[k, 0] == i and collisions[k, 1] == j:
                    near.pairs[p, 2] = k
                    break
    return True


@lean_kernel
def _collide(
    collisions: Floats, counts: Ints, robot: int, other: int, time: float, x: float, y: float, depth: float
) -> int:
    """Note a new collision; ``other`` is a robot, or −1 − a shape."""
    k = counts[COLLISIONS]
    counts[COLLISIONS] = k + 1
    collisions[k, 0], collisions[k, 1], collisions[k, 2] = robot, other, time
    collisions[k, 3], collisions[k, 4], collisions[k, 5] = x, y, depth
    return int(k)
