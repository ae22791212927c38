"""Draw the figures of the documentation again: python docs/make_figures.py."""

from __future__ import annotations

from pathlib import Path

import taut
from taut.figures import animate_run
from taut.simulation import Detector, Disturbances, Lidar, simulate

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
    draw_contact()
    draw_simulation()
    for path in sorted(FIGURES.iterdir()):
        print(path)


def draw_contact() -> None:
    """Plan the teams of the page on contact, and draw them."""
    mine = taut.plan(taut.load_scene("mine-rescue-8"), contact=taut.Contact(14, sight=True)).plan
    taut.save_figure(mine, FIGURES / "contact-mine.png")
    taut.animate(mine, FIGURES / "contact-mine.gif", fps=12, seconds=10, width=640)
    search = taut.plan(taut.load_scene("search-20"), contact=taut.Contact(4, k=2)).plan
    taut.animate(search, FIGURES / "contact-search.gif", fps=10, seconds=8, width=560)
    names = ("leader", "left", "right", "wing-left", "wing-right")
    hall = taut.Scene(
        (0, 0, 24, 10),
        [taut.Rectangle(11.5, 0, 1, 4.4), taut.Rectangle(11.5, 5.6, 1, 4.4)],
        [taut.Robot(name, (5, 5), (20, 5), radius=0.3) for name in names],
        gap=0.1,
        name="wedge",
    )
    offsets = {"left": (-1, 1), "right": (-1, -1), "wing-left": (-2, 2), "wing-right": (-2, -2)}
    wedge = taut.travel(taut.in_formation(hall, offsets), contact=3).plan
    taut.animate(wedge, FIGURES / "contact-formation.gif", fps=12, seconds=8, width=560)


def draw_simulation() -> None:
    """Let the robots of the page on simulation follow their plan, and draw what they do."""
    yard = taut.Scene(
        (0, 0, 10, 8),
        [
            taut.Rectangle(3, 1.5, 1.5, 3, name="shed"),
            taut.Circle((7, 4.5), 0.8, "tank"),
            taut.Line([(4.5, 6), (6, 6.5), (7.5, 6.5)], 0.1, "fence"),
        ],
        [
            taut.Robot("R1", (1, 1), (9, 7), radius=0.25),
            taut.Robot("R2", (9, 1), (1, 7), radius=0.25),
            taut.Robot("R3", (1, 4), (9, 2.5), radius=0.25),
            taut.Robot("R4", (9, 5.5), (1.5, 2.5), radius=0.25),
        ],
        clearance=0.1,
        gap=0.1,
        name="yard",
    )
    met = Disturbances(speed_error=0.2, stops=0.1)
    run = simulate(taut.plan(yard).plan, seed=3, disturbances=met, lidar=Lidar(reach=3.0))
    taut.save_figure(run, FIGURES / "simulation.png")
    animate_run(run, FIGURES / "simulation.gif", fps=6, seconds=8, width=480, detector=Detector(reach=3.0))


if __name__ == "__main__":
    main()
