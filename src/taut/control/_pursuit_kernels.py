"""Kernels of pure pursuit: the nearest point of a path, the place ahead on it, and the arc there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]


@lean_kernel
def pursue(
    points: Floats, leg: int, x: float, y: float, heading: float, lookahead: float, speed: float, top_turn_rate: float
) -> tuple[float, float, float, int]:
    """Return turn rate, place aimed at and leg of a pure pursuit of a polyline ``points`` (k ≥ 2, 2) from a leg on."""
    leg, share = _nearest_on(points, leg, x, y, lookahead)
    to_x, to_y = _exit(points, leg, share, x, y, lookahead)
    ahead_x, ahead_y = to_x - x, to_y - y
    front = math.cos(heading) * ahead_x + math.sin(heading) * ahead_y
    left = math.cos(heading) * ahead_y - math.sin(heading) * ahead_x
    away = math.hypot(front, left)
    if away == 0.0:
        return 0.0, to_x, to_y, leg
    # the sine of the bearing; what lies behind is turned to as what lies beside
    sine = left / away if front >= 0.0 else math.copysign(1.0, left)
    turn = 2.0 * speed * sine / max(away, lookahead)
    return min(max(turn, -top_turn_rate), top_turn_rate), to_x, to_y, leg


@lean_kernel
def _nearest_on(points: Floats, leg: int, x: float, y: float, lookahead: float) -> tuple[int, float]:
    """Leg and share of it nearest to (x, y), from a leg on, no farther along than the look-ahead can reach."""
    best, share = _project(points, leg, x, y)
    found, along = leg, (1.0 - share) * _length(points, leg)
    reach = best + lookahead
    k = leg + 1
    while k + 1 < len(points) and along <= reach:
        distance, s = _project(points, k, x, y)
        if distance < best:
            best, found, share = distance, k, s
        along += _length(points, k)
        k += 1
    return found, share


@lean_kernel
def _length(points: Floats, k: int) -> float:
    return math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])


@lean_kernel
def _project(points: Floats, k: int, x: float, y: float) -> tuple[float, float]:
    """Distance from (x, y) to a leg, and the share of the leg at which it is least; the last of equals."""
    ax, ay = points[k, 0], points[k, 1]
    rx, ry = points[k + 1, 0] - ax, points[k + 1, 1] - ay
    whole = rx * rx + ry * ry
    s = 1.0
    if whole > 0.0:
        s = min(max(((x - ax) * rx + (y - ay) * ry) / whole, 0.0), 1.0)
    return math.hypot(ax + s * rx - x, ay + s * ry - y), s


@lean_kernel
def _exit(points: Floats, leg: int, share: float, x: float, y: float, lookahead: float) -> tuple[float, float]:
    """First place of the polyline, from a share of a leg on, that is as far as the look-ahead; else its end."""
    ax = points[leg, 0] + share * (points[leg + 1, 0] - points[leg, 0])
    ay = points[leg, 1] + share * (points[leg + 1, 1] - points[leg, 1])
    for k in range(leg, len(points) - 1):
        bx, by = points[k + 1, 0], points[k + 1, 1]
        ux, uy = ax - x, ay - y
        inside = lookahead * lookahead - ux * ux - uy * uy
        if inside <= 0.0:
            break
        if math.hypot(bx - x, by - y) >= lookahead:
            # |u + s r| = lookahead at the positive root of |r|² s² + 2 (u·r) s − inside
            rx, ry = bx - ax, by - ay
            whole, half = rx * rx + ry * ry, ux * rx + uy * ry
            root = math.sqrt(half * half + whole * inside)
            s = inside / (half + root) if half > 0.0 else (root - half) / whole
            return ax + s * rx, ay + s * ry
        ax, ay = bx, by
    return ax, ay
