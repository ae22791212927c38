"""Write docs/mrppa.md and its figures: python docs/make_mrppa.py."""

from __future__ import annotations

from pathlib import Path

import taut
from taut.team import Result
from taut.team.stages import FirstPathStage
from taut.team.telling import tell, title

DOCS = Path(__file__).resolve().parent
FIGURES = DOCS / "figures"
SCENES = ("thesis-1", "thesis-2")

HEAD = """# MRPPA stage by stage

*Made by `./dev docs` from the stages themselves; edit `docs/make_mrppa.py`.*

MRPPA, the Multi-Robot Path Planning Algorithm of the [thesis](thesis.md), lets the **algebraic connectivity** λ2 of the
map's visibility graph decide which edges join its parts. λ2 is the second smallest eigenvalue of the graph's Laplacian
L = D − A: zero if and only if the graph falls apart, and the larger the better it hangs together. Its eigenvector, the
*Fiedler vector*, says where the graph is weakest.

1. **Free space** of one size of robot; teams of several sizes go through the stages once for each.
2. **Obstacle graph**: starts, goals and corners of obstacles, joined by the obstacles' edges only.
3. **Split in two**: the visibility graph in which each obstacle is one vertex is cut by the signs of its Fiedler
   vector; all edges between the sides are removed, so λ2 = 0. Robots with a way within one side get their first path.
4. **Bridges**, one at a time: among the edges that give or shorten the path of a robot not yet served, the one with the
   largest λ2. All candidates are valued exactly from one eigendecomposition (`taut.graph.best_edges`).
5. **Full visibility graph**: all edges are put back.
6. **Planned in sequence**: one robot after another, each avoiding those before it; every conflict is told with its
   kind, place, time and how it was resolved. The result is an ordinary certified plan.

```sh
taut plan thesis-1 --method mrppa --explain
taut plan thesis-1 --method mrppa --stages out/   # a figure, a text and a JSON record of every stage
```

```python
import taut

result = taut.plan(taut.load_scene("thesis-1"), method="mrppa")
assert result.certificate.ok
print([type(stage).__name__ for stage in result.stages])
```

A split of your own is `--split "O1,O2,R1 start"` (`split=` in Python), another weight of edges in λ2
`--weight distance` (`weight=`, also any function of the length). On obstacles grown by a disc's radius, round corners
are drawn with few vertices here (the plan itself uses fine ones), since λ2 counts vertices.
"""


def page(results: dict[str, Result]) -> str:
    """Return the text of the page."""
    parts = [HEAD]
    for name, result in results.items():
        parts.append(f"## {name}\n")
        for number, stage in enumerate(result.stages, 1):
            parts.append(f"### {number}. {title(stage)}\n")
            parts.append("\n".join(f"{line}  " for line in tell(stage)).rstrip() + "\n")
            if not isinstance(stage, FirstPathStage) or number <= 6:
                parts.append(f"![{title(stage)}](figures/{figure_name(name, number)})\n")
    return "\n".join(parts)


def figure_name(scene: str, number: int) -> str:
    """Return the file name of a stage's figure."""
    return f"mrppa-{scene}-{number:02d}.png"


def main() -> None:
    """Plan both scenes, write the page and its figures."""
    results = {name: taut.plan(taut.load_scene(name), method="mrppa") for name in SCENES}
    text = page(results)
    (DOCS / "mrppa.md").write_text(text, encoding="utf-8")
    for name, result in results.items():
        for number, stage in enumerate(result.stages, 1):
            if f"({'figures/' + figure_name(name, number)})" in text:
                taut.save_figure(stage, FIGURES / figure_name(name, number))
    print(DOCS / "mrppa.md")


if __name__ == "__main__":
    main()
