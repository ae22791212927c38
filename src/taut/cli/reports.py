"""What the commands tell: each report is one plain mapping, printed as it is for --json and as text for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from taut.cli.output import say, say_facts
from taut.cli.tables import say_table
from taut.errors import NoPath

if TYPE_CHECKING:
    from taut.certificate import Certificate, ContactProof
    from taut.motion import Plan
    from taut.scene import Robot, Scene
    from taut.team.stages import Stage

Report: TypeAlias = dict[str, Any]

MOST_LISTED = 8


def scene_report(scene: Scene) -> Report:
    """Describe a scene: its counts, bounds and settings."""
    xs, ys = zip(*scene.workspace, strict=True)
    kinds = Counter(type(obstacle).__name__.lower() for obstacle in scene.obstacles)
    return {
        "name": scene.name,
        "bounds": [min(xs), min(ys), max(xs), max(ys)],
        "workspace_corners": len(scene.workspace),
        "obstacles": len(scene.obstacles),
        "obstacle_kinds": dict(sorted(kinds.items())),
        "robots": len(scene.robots),
        "radii": sorted({robot.radius for robot in scene.robots}),
        "speeds": sorted({robot.speed for robot in scene.robots}),
        "clearance": scene.clearance,
        "gap": scene.gap,
        "headway": scene.headway,
        "at_goal": scene.at_goal,
    }


def say_scene(report: Report) -> None:
    """Print a scene report."""
    x0, y0, x1, y1 = report["bounds"]
    corners = report["workspace_corners"]
    kinds = ", ".join(f"{count} {kind}" for kind, count in report["obstacle_kinds"].items())
    say_facts(
        [
            ("scene", report["name"] or "(no name)"),
            ("workspace", f"{x1 - x0:g} × {y1 - y0:g} m, x {x0:g} to {x1:g}, y {y0:g} to {y1:g}, {corners} corners"),
            ("obstacles", str(report["obstacles"]) + (f" ({kinds})" if kinds else "")),
            (
                "robots",
                f"{report['robots']}, radius {_span(report['radii'], 'm')}, speed {_span(report['speeds'], 'm/s')}",
            ),
            ("clearance", f"{report['clearance']:g} m from obstacles and wall"),
            ("gap", f"{report['gap']:g} m between robots, headway {report['headway']:g} s"),
            ("at the goal", str(report["at_goal"])),
        ]
    )


def reach_report(scene: Scene, robots: Sequence[Robot]) -> list[Report]:
    """Find the shortest length of every robot given; None with the reason where it cannot reach its goal."""
    from taut.freespace import FreeSpace
    from taut.roadmap import VisibilityGraph, visibility_graph
    from taut.route import shortest_routes

    spaces: dict[float, tuple[FreeSpace, VisibilityGraph]] = {}
    out: list[Report] = []
    for robot in robots:
        growth = scene.growth(robot)
        if growth not in spaces:
            free = FreeSpace(scene, growth)
            spaces[growth] = free, visibility_graph(free)
        try:
            route = shortest_routes(*spaces[growth], [robot.start], [robot.goal])[0]
            out.append({"name": robot.name, "shortest": route.length, "reason": ""})
        except NoPath as error:
            out.append({"name": robot.name, "shortest": None, "reason": error.reason})
    return out


def cuts_report(plan: Plan, certificate: Certificate) -> dict[str, float] | None:
    """Find for how many seconds each robot was a cut vertex; None if no contact had to be proved, or of too many."""
    if certificate.contact is None or certificate.contact.lambda2 is None:
        return None
    from taut.contact import contacts
    from taut.contact.cuts import cut_times

    demand = certificate.contact.demand
    found = contacts(plan, demand.reach, demand.sight)
    cuts = cut_times(found)
    return {found.names[k]: float((spans.clip(max=found.until) @ (-1, 1)).sum()) for k, spans in cuts.items()}


def certificate_facts(certificate: Certificate, cuts: Mapping[str, float] | None = None) -> list[tuple[str, str]]:
    """Return what was proved, for people; with contact also for how long which robots were cut vertices."""
    near, close = certificate.separation, certificate.clearance
    separation, clearance = "none, no two robots are there at the same time", "none, there are no robots"
    if near is not None:
        separation = f"{near.value:.9g} m between {' and '.join(near.robots)} at t = {near.time:.6g} s"
    if close is not None:
        value = 0.0 if abs(close.value) <= certificate.tol else close.value
        clearance = f"{value:.9g} m between {close.robot} and {close.obstacle} at t = {close.time:.6g} s"
    return [
        ("least separation", separation),
        ("least clearance", clearance),
        *_contact_facts(certificate.contact, cuts),
        ("certified", f"{'yes' if certificate.ok else 'NO'}, tolerance {certificate.tol:.2g} m"),
    ]


def _contact_facts(proof: ContactProof | None, cuts: Mapping[str, float] | None) -> list[tuple[str, str]]:
    if proof is None:
        return []
    demand = proof.demand
    asked = f"within {demand.reach:g} m" + (" and in sight" if demand.sight else "")
    asked += f", {demand.k}-connected" if demand.k > 1 else ""
    asked += f", λ2 at least {demand.lambda2:g}" if demand.lambda2 > 0 else ""
    facts = [("contact", asked)]
    if proof.lambda2 is not None:
        facts.append(("least λ2", f"{proof.lambda2:.6g} at t = {proof.lambda2_time:.6g} s"))
    if proof.needed_range is not None:
        facts.append(("range needed", f"{proof.needed_range:.9g} m, at t = {proof.needed_time:.6g} s"))
    if cuts is not None:
        facts.append(("cut vertices", _listed([f"{name} ({time:.4g} s)" for name, time in cuts.items()])))
    return facts


def _listed(items: Sequence[str]) -> str:
    if len(items) <= MOST_LISTED:
        return ", ".join(items) or "none"
    return f"{', '.join(items[:MOST_LISTED])} and {len(items) - MOST_LISTED} more"


def say_problems(certificate: Certificate) -> None:
    """Print every problem, a line each."""
    for problem in certificate.problems:
        say(f"problem: {problem}")


def plan_report(
    plan: Plan,
    certificate: Certificate,
    shortest: Sequence[float] | None = None,
    detours: Sequence[str] = (),
) -> Report:
    """Describe a plan robot by robot, and its costs beside their lower bound."""
    robots: list[Report] = []
    for k, (robot, trajectory) in enumerate(zip(plan.scene.robots, plan.trajectories, strict=True)):
        # Rounding leaves rests far below what the tolerance can tell apart; nobody waits there.
        waits = [
            until - since for since, until, _, _ in trajectory.waits if until - since > plan.scene.tol / robot.speed
        ]
        robots.append(
            {
                "name": robot.name,
                "length": trajectory.length,
                "arrival": trajectory.arrival,
                "shortest": None if shortest is None else float(shortest[k]),
                "waits": len(waits),
                "waiting": float(sum(waits)),
                "detour": detours[k] if k < len(detours) else "",
            }
        )
    bound = plan.lower_bound
    cuts = cuts_report(plan, certificate)
    return {
        "ok": bool(certificate.ok),
        "scene": plan.scene.name,
        "planner": dict(plan.planner),
        "robots": robots,
        "sum_of_costs": plan.sum_of_costs,
        "makespan": plan.makespan,
        "length": plan.length,
        "lower_bound": None if bound is None else dict(bound),
        "gap": _excess(getattr(plan, _bounded(bound)), bound),
        "certificate": certificate.as_dict(),
        **({} if cuts is None else {"cut_vertices": cuts}),
    }


def say_plan(report: Report, certificate: Certificate) -> None:
    """Print the table of robots, the costs and the proof of a plan."""
    rows = report["robots"]
    heads = ["robot", "length (m)", "arrival (s)", "shortest (m)", "waits", "why longer"]
    shown = [_robot_row(row) for row in rows]
    if all(row["shortest"] is None for row in rows):
        heads, shown = heads[:3] + heads[4:5], [row[:3] + row[4:5] for row in shown]
    elif not any(row[5] for row in shown):
        heads, shown = heads[:5], [row[:5] for row in shown]
    if rows:
        say_table(heads, shown, left=("robot", "waits", "why longer"))
        say()
    costs = {"sum_of_costs": f"{report['sum_of_costs']:.4f} s", "makespan": f"{report['makespan']:.4f} s"}
    bound = report["lower_bound"]
    if bound is not None and report["gap"] is not None:
        proven = ", proven" if report["planner"].get("proven") is True else ""
        gap = f"gap {100 * report['gap']:.2f} %{proven}"
        costs[_bounded(bound)] += f", at least {bound['value']:.4f} s ({bound['model']} model), {gap}"
    facts = [
        ("sum of costs", costs["sum_of_costs"]),
        ("makespan", costs["makespan"]),
        ("total length", f"{report['length']:.4f} m"),
        *certificate_facts(certificate, report.get("cut_vertices")),
    ]
    if "elapsed" in report:
        facts.append(("planned in", f"{report['elapsed']:.2f} s"))
    say_facts(facts)
    say_problems(certificate)


def say_stages(stages: Sequence[Stage]) -> None:
    """Tell what was done, stage by stage."""
    from taut.team.telling import tell, title

    for number, stage in enumerate(stages, 1):
        say(f"{number}. {title(stage)}")
        for line in tell(stage):
            say(f"   {line}")
    say()


def _robot_row(row: Report) -> list[str]:
    waits = f"{row['waits']} ({row['waiting']:.2f} s)" if row["waits"] else ""
    shortest, why = "", str(row["detour"])
    if row["shortest"] is not None:
        shortest = f"{row['shortest']:.4f}"
        if f"{row['length']:.4f}" != shortest:
            why = f"+{row['length'] - row['shortest']:.4f} m" + (f": {why}" if why else "")
    return [row["name"], f"{row['length']:.4f}", f"{row['arrival']:.4f}", shortest, waits, why]


def _bounded(bound: Mapping[str, object] | None) -> str:
    """The cost that a bound is on."""
    return "makespan" if bound is not None and bound.get("of") == "makespan" else "sum_of_costs"


def _excess(cost: float, bound: Mapping[str, object] | None) -> float | None:
    value = None if bound is None else bound.get("value")
    if not isinstance(value, int | float) or value < 0:
        return None
    if value == 0:
        return 0.0 if cost == 0 else None
    return cost / value - 1.0


def _span(values: Sequence[float], unit: str) -> str:
    if not values:
        return "none"
    return f"{values[0]:g} {unit}" if len(values) == 1 else f"{values[0]:g} to {values[-1]:g} {unit}"
