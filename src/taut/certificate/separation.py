"""Robots from each other: the least room between any two, over all time and headway."""

from __future__ import annotations

import numpy as np

from taut.certificate._kernels import least_separations
from taut.certificate.report import Problem, Separation
from taut.certificate.tracks import Tracks
from taut.scene import Scene


def check_separation(scene: Scene, tracks: Tracks) -> tuple[Separation | None, list[Problem]]:
    """Return the nearest pair and one problem per pair that comes nearer than r_i + r_j + gap - tol.

    Time O(pairs · stamps) without headway; with headway every two legs whose times come within it are compared.
    """
    robots = scene.robots
    if len(robots) < 2:
        return None, []
    pairs, rows = least_separations(
        tracks.t, tracks.x, tracks.y, tracks.vx, tracks.vy, tracks.first, tracks.stays, tracks.present,
        tracks.boxes, np.array([robot.radius for robot in robots]), scene.gap, scene.headway, scene.tol,
    )  # fmt: skip
    found = [_separation(scene, tracks, pair, row) for pair, row in zip(pairs.tolist(), rows.tolist(), strict=True)]
    problems = [
        Problem(
            "separation",
            near.robots,
            scene.gap - near.value,
            near.time,
            near.place,
            detail=f"{near.value:.6g} m between the discs, {scene.gap:.6g} m needed" + _headway(near),
        )
        for near in found[1:]
        if near is not None
    ]
    return found[0], problems


def _separation(scene: Scene, tracks: Tracks, pair: list[int], row: list[float]) -> Separation | None:
    i, j = pair
    if i < 0:
        return None
    free, time, other = row
    (xi, yi), (xj, yj) = tracks.at(i, time), tracks.at(j, other)
    names = scene.robots[i].name, scene.robots[j].name
    return Separation(free, names, time, other, ((xi + xj) / 2, (yi + yj) / 2))


def _headway(near: Separation) -> str:
    if near.time == near.other_time:
        return ""
    return f", {near.robots[1]} being there at t = {near.other_time:.9g} s"
