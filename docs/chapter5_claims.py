"""The claims of the thesis' chapter 5, and what is true of them, for docs/chapter5.md."""

from __future__ import annotations

from collections.abc import Sequence

from chapter5_values import DELTA, Chapter, clearance_of


def claims(done: Chapter) -> Sequence[tuple[str, str, str]]:
    """Return what the thesis says, whether it is true, and as what it was found here."""
    central = [(name, robot, route) for name, found in done.central.items() for robot, route in found.items()]
    crossing = [
        (route, route.length / done.shortest[name][robot].length) for name, robot, route in central if route.crossed
    ]
    longer = [100 * (ratio - 1) for _, ratio in crossing]
    hit = sum(not route.free for route, _ in crossing)
    room = min(
        clearance_of(done.plain[name], route.points) for name, _, route in central if route.free and route.crossed
    )
    robots, lost, most = sum(c.robots for c in done.crowds), sum(c.lost for c in done.crowds), done.crowds[-1]
    edges = ", ".join(f"{route.roadmap.graph.m}" for route in done.central["thesis-2"].values())
    return (
        (
            "VG with Dijkstra is shortest and complete (5.4)",
            "yes",
            "with all edges; the thesis' hand-drawn graphs lack some",
        ),
        (
            "VG paths touch obstacles (5.4)",
            "yes",
            "for point robots without D_s; VG on grown obstacles keeps D_s as exactly as OCA does",
        ),
        (
            'CA gives "the shortest collision free paths" (5.6)',
            "no",
            f"on scenes 1 and 2 its paths are {min(longer):.1f} % to {max(longer):.1f} % longer than the shortest, "
            f"and {hit} of {len(crossing)} are not free",
        ),
        (
            'CA maintains "a safe distance from the obstacles" (5.6)',
            "no",
            "δ keeps the waypoints away from the obstacle that they belong to; not the way between them, nor any other "
            f"obstacle. The least clearance of a free path is {room:.4f} m with δ = {DELTA:g} m",
        ),
        (
            "CA ignores other obstacles (5.6, as a drawback)",
            "yes",
            f"{most.hit} of {most.robots} paths among {most.obstacles} obstacles hit one",
        ),
        (
            'CA has "general solutions for various scenarios" (5.6)',
            "no",
            f"{lost} of {robots} robots on the random maps get no path; every one of them has a way",
        ),
        (
            "CA uses fewer obstacles and edges (5.6)",
            "yes",
            f"{edges} edges for the robots of scene 2 against {done.all_edges['thesis-2'][1]} of VG",
        ),
        (
            "CA takes less time than VG (5.6)",
            "on large maps",
            "hardly on 100 corners, more and more beyond; but from 1,000 on no path between far places was free "
            "([measured](performance.md#one-path-on-a-map-rich-in-obstacles-time))",
        ),
        (
            'OCA\'s paths are "fully collision-free" (5.7)',
            "not as written",
            "grown or not, obstacles that the baseline does not cross are hit; made exact, yes, with a proof",
        ),
        (
            'OCA "provides the shortest collision-free paths" at a safe distance (5.7)',
            "not as written",
            "made exact, its paths are as long as the shortest in the visibility graph of all obstacles grown",
        ),
        (
            '"the shortest paths … in comparison with" VG (note to table 5.12)',
            "no",
            "nothing is shorter than VG's; with D_s > 0 they are longer, as they keep a distance",
        ),
        (
            'OCA ensures "the completeness of the algorithm" (5.8)',
            "not as written",
            "made exact, yes: no path among a few obstacles, none among all",
        ),
        (
            "OCA uses few obstacles (5.7)",
            "yes",
            f"{100 * most.used:.1f} % of {most.obstacles} on the mean, and hardly any between near places",
        ),
        (
            "OCA takes less time than VG (5.7)",
            "on large maps",
            "for one path, the larger the map and the nearer the places, the more; hardly on 100 corners. Graphs and "
            "hub labels that are kept answer many questions on one map faster ([Shortest paths](paths.md))",
        ),
        (
            "added obstacles do not change paths (5.7.2)",
            "unless they interfere",
            "then the robots concerned are planned anew, and it is said who and why",
        ),
    )
