"""Integration of vector fields: what a team does under a control law, as trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import comb
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853, Radau
from threadpoolctl import threadpool_limits

from taut.control.curves import DEGREE, SHARES, legs
from taut.control.laws import Field
from taut.errors import TautError
from taut.motion import Trajectory

Floats: TypeAlias = NDArray[np.float64]
Velocities: TypeAlias = Callable[[float, Any], Floats]

_STEPS_BEFORE_STIFF = 1_000
_MOST_STEPS = 20_000
_FINEST = 2.0**-40
_HUGE = 1e100
# SciPy's least relative tolerance: the place of the origin is not to loosen the absolute one
_RELATIVE = 100 * float(np.finfo(np.float64).eps)


def integrate(
    field: Field,
    positions: ArrayLike,
    seconds: float,
    names: Sequence[str] | None = None,
    error: float = 1e-3,
    jumps: ArrayLike = (),
) -> tuple[Trajectory, ...]:
    """Follow a vector field from given positions and return the trajectories, one a robot.

    Parameters
    ----------
    field : velocities (n, 2) in metres a second from time in seconds and positions (n, 2).
    positions : (n, 2) metres, at t = 0.
    seconds : how long, ≥ 0.
    names : of the robots, n different ones; R1, R2, … by default.
    error : metres. The legs stay within it of the computed solution at every instant, and the solver takes steps that
        err by less than a thousandth of it, as far as it can tell.
    jumps : times in seconds at which the field jumps, such as a leader's stamps. No step reaches across one; at the
        jump itself the field is taken for what comes after.

    Raises
    ------
    ValueError
        Positions that are not (n, 2) finite numbers, a negative or non-finite time, names too few, too many or twice,
        an error that is not positive or finer than doubles resolve at these positions, a field that does not give
        (n, 2) numbers.
    TautError
        The field cannot be followed to the end: velocities that are not finite or grow without bound, or jump so
        often that 20,000 steps do not suffice. The text says when.

    Notes
    -----
    Each trajectory has its own stamps, at 0, at ``seconds``, and as many between as the error needs. The errors of
    the steps hardly matter in fields that draw neighbouring motions together, as consensus does; fields that drive
    them apart magnify them. The solver is an explicit Runge-Kutta method of order 8 (SciPy's DOP853), which also finds
    its way beside positions without a velocity, as rendezvous has them. In a stiff field (weights that differ by
    magnitudes) its steps are very short: after 1,000 of them between two jumps the implicit method Radau goes on.

    >>> from taut.control import consensus
    >>> from taut.graph import Graph
    >>> first, second = integrate(consensus(Graph.from_edges(2, [(0, 1)])), [(0, 0), (2, 0)], seconds=10)
    >>> first.at(10).round(3)
    array([1., 0.])
    """
    start = _checked_positions(positions)
    labels = _checked_names(names, len(start))
    if not (np.isfinite(seconds) and seconds >= 0):
        raise ValueError(f"seconds must be finite and not negative, got {seconds:g}")
    largest = float(np.abs(start).max(initial=0.0))
    if not (np.isfinite(error) and error > _FINEST * largest):
        raise ValueError(f"error must be positive, finite and above 2⁻⁴⁰ of the largest coordinate, got {error:g}")
    if seconds == 0 or len(start) == 0:
        return tuple(Trajectory(name, np.array([[0.0, *place]])) for name, place in zip(labels, start, strict=True))
    # what is not finite is found and told in words
    with threadpool_limits(1, user_api="blas"), np.errstate(all="ignore"):
        times, control = _solve(field, start, _spans(float(seconds), jumps), labels, error)
    if error <= _FINEST * np.abs(control).max():
        raise TautError(f"robots get {np.abs(control).max():.3g} m far: give an error above {error:g} m")
    return tuple(Trajectory(name, legs(times, control[:, :, i], error)) for i, name in enumerate(labels))


def _checked_positions(positions: ArrayLike) -> Floats:
    start = np.array(positions, dtype=np.float64)
    if start.size == 0:
        return np.empty((0, 2))
    if start.ndim != 2 or start.shape[1] != 2 or not np.isfinite(start).all():
        raise ValueError("positions must be rows of two finite numbers [x, y]")
    return start


def _checked_names(names: Sequence[str] | None, n: int) -> Sequence[str]:
    labels = [f"R{i + 1}" for i in range(n)] if names is None else list(names)
    if len(labels) != n:
        raise ValueError(f"{len(labels)} names for {n} robots")
    if len(set(labels)) < n:
        raise ValueError("a name is given twice")
    return labels


def _spans(seconds: float, jumps: ArrayLike) -> list[tuple[float, float]]:
    """Return the stretches of time between jumps."""
    when = np.unique(np.asarray(jumps, dtype=np.float64))
    if not np.isfinite(when).all():
        raise ValueError("jumps must be finite times in seconds")
    inside = when[(when > 0) & (when < seconds)]
    return list(pairwise([0.0, *inside.tolist(), seconds]))


def _solve(
    field: Field, start: Floats, spans: Sequence[tuple[float, float]], names: Sequence[str], error: float
) -> tuple[Floats, Floats]:
    """Ends of the solver's steps, (s + 1,), and the control points of all robots in each, (s, 8, n, 2)."""
    times = [0.0]
    pieces: list[Floats] = []
    # the solver bounds the root mean square over all coordinates; so no robot's error hides behind the others'
    tolerance = error / 1000 / np.sqrt(start.size)
    state = start.ravel()
    for begin, end in spans:
        # as the field jumps at its end, a span sees what is before
        last = end if end == spans[-1][1] else float(np.nextafter(end, begin))
        for time, points in _steps(_flat(field, len(start), last), begin, state, end, tolerance, names):
            if len(pieces) == _MOST_STEPS:
                raise TautError(
                    f"gave up at t = {time:.6g} s after {_MOST_STEPS:,} steps: the velocities change too fast or too "
                    "often (growth without bound? links that come and go?); allow a larger error or fewer seconds"
                )
            times.append(time)
            pieces.append(points.reshape(DEGREE + 1, -1, 2))
            state = points[-1]
    return np.array(times), np.stack(pieces)


def _steps(
    velocities: Velocities, begin: float, state: Floats, end: float, tolerance: float, names: Sequence[str]
) -> Iterator[tuple[float, Floats]]:
    """Yield the end of each step of the solver and the control points of all coordinates in it, (8, 2 n)."""
    if not np.isfinite(velocities(begin, state)).all():
        raise _failure(velocities, begin, state, names)
    solver: DOP853 | Radau = DOP853(velocities, begin, state, end, rtol=_RELATIVE, atol=tolerance)
    count = 0
    while solver.status == "running":
        if count == _STEPS_BEFORE_STIFF:
            slopes = _jacobian(velocities, tolerance)
            solver = Radau(_rejectable(velocities), solver.t, solver.y, end, rtol=_RELATIVE, atol=tolerance, jac=slopes)
        time, state = solver.t, solver.y
        solver.step()
        count += 1
        if solver.status == "failed":
            raise _failure(velocities, time, state, names)
        points = _control_points(solver)
        if np.isfinite(points).all():
            yield float(solver.t), points
        else:  # the interpolation looks beside the way, where there is no velocity: nearer in a shorter step
            half = (solver.t - time) / 2
            solver = DOP853(velocities, time, state, end, first_step=half, rtol=_RELATIVE, atol=tolerance)


def _flat(field: Field, n: int, last: float) -> Velocities:
    """Return the field on flat arrays, at times up to ``last``."""

    def velocities(time: float, state: Floats) -> Floats:
        found = np.asarray(field(min(float(time), last), state.reshape(n, 2)), dtype=np.float64)
        if found.shape != (n, 2):
            raise ValueError(f"the field must give velocities ({n}, 2), got shape {found.shape}")
        return found.ravel()

    return velocities


def _rejectable(velocities: Velocities) -> Velocities:
    """Return velocities for trial steps of Radau, which rejects what is huge but fails with what is not finite."""

    def finite(time: float, state: Floats) -> Floats:
        found = velocities(time, state)
        return np.where(np.isfinite(found), found, _HUGE)

    return finite


def _jacobian(velocities: Velocities, tolerance: float) -> Callable[[float, Any], Floats]:
    """Return the derivatives of velocities by positions, (2 n, 2 n), from differences as small as the tolerance.

    SciPy's own take wider ones, which may leave the region where the law holds; here the other side is tried then.
    """

    def slopes(time: float, state: Floats) -> Floats:
        here = velocities(time, state)
        aside = max(tolerance, _FINEST * float(np.abs(state).max()))
        columns = []
        for shift in aside * np.eye(len(state)):
            column = (velocities(time, state + shift) - here) / aside
            if not np.isfinite(column).all():
                column = (here - velocities(time, state - shift)) / aside
            columns.append(np.where(np.isfinite(column), column, 0.0))
        return np.stack(columns, axis=1)

    return slopes


def _control_points(solver: DOP853 | Radau) -> Floats:
    """Bernstein coefficients of all coordinates in the last step, (8, 2 n), its ends exactly the solver's."""
    curve = solver.dense_output()
    points: Floats = _FROM_SAMPLES @ curve(solver.t_old + (solver.t - solver.t_old) * _SAMPLES).T
    points[0], points[-1] = curve(solver.t_old), solver.y
    return points


def _failure(velocities: Velocities, time: float, state: Floats, names: Sequence[str]) -> TautError:
    """Say when and for whom the field cannot be followed."""
    speeds = np.hypot(*velocities(time, state).reshape(-1, 2).T)
    lost = [name for name, speed in zip(names, speeds.tolist(), strict=True) if not np.isfinite(speed)]
    if lost:
        some = ", ".join(lost[:5]) + (" and others" if len(lost) > 5 else "")
        return TautError(
            f"at t = {time:.6g} s the law gives no finite velocity for {some}: it does not hold at these positions"
        )
    fastest = int(speeds.argmax())
    x, y = state.reshape(-1, 2)[fastest]
    return TautError(
        f"the law cannot be followed beyond t = {time:.6g} s: its velocities end or grow without bound there "
        f"(the fastest is {names[fastest]} at ({x:.6g}, {y:.6g}), {speeds[fastest]:.3g} m/s)"
    )


# Chebyshev points with the ends, and the matrix from values there to Bernstein coefficients
_SAMPLES = (1 - np.cos(np.pi * SHARES)) / 2
_FROM_SAMPLES = np.linalg.inv(
    [[comb(DEGREE, k) * x**k * (1 - x) ** (DEGREE - k) for k in range(DEGREE + 1)] for x in _SAMPLES.tolist()]
)
