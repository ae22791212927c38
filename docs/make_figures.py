"""Draw the figures of the documentation again: python docs/make_figures.py."""

from __future__ import annotations

from pathlib import Path

import taut

FIGURES = Path(__file__).resolve().parent / "figures"


def main() -> None:
    """Plan the scene that the README shows; draw it still, with its visibility graph, and in motion."""
    FIGURES.mkdir(exist_ok=True)
    scene = taut.load_scene("thesis-2")
    result = taut.plan(scene)
    if not result.certificate.ok:
        raise SystemExit(f"the plan of {scene.name} does not hold: {result.certificate.problems[0]}")
    ends = [point for robot in scene.robots for point in (robot.start, robot.goal)]
    graph = taut.visibility_graph(taut.FreeSpace(scene), edges="all", points=ends)
    taut.save_figure(result.plan, FIGURES / "thesis-2.png")
    taut.save_figure(result.plan, FIGURES / "thesis-2-graph.png", graph=graph)
    taut.animate(result.plan, FIGURES / "thesis-2.gif")
    for path in sorted(FIGURES.iterdir()):
        print(path)


if __name__ == "__main__":
    main()
