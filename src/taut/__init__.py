"""Certified motion plans for robot teams on 2D maps: paths pulled taut around obstacles, timed so that nobody collides.

The public names below are loaded when they are first used, so that importing the package stays cheap.

>>> import taut
>>> scene = taut.Scene((0, 0, 10, 10), robots=[taut.Robot("R1", (1, 1), (9, 9), radius=0.2)])
>>> scene.robots[0].name
'R1'
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taut import contact as contact
    from taut import control as control
    from taut import graph as graph
    from taut import simulation as simulation
    from taut.certificate import Certificate, certify
    from taut.contact import Contact, Contacts, contacts, fading_fiedler, needed_reach
    from taut.editing import with_obstacle, without_obstacle
    from taut.errors import (
        GoalBlocked,
        NoPath,
        NoPlanExists,
        NoPlanFound,
        OutputError,
        PlanError,
        SceneError,
        StartBlocked,
        TautError,
    )
    from taut.figures import animate, draw, save_figure, save_stages
    from taut.formation import Formed, in_formation, travel
    from taut.formats import free_cells, load_map, load_plan, load_roadmap, load_scen, load_scene, save, save_roadmap
    from taut.freespace import FreeSpace
    from taut.generate import random_scene, random_warehouse
    from taut.generate.contact import random_team_in_contact
    from taut.motion import Plan, Trajectory
    from taut.roadmap import (
        Lanes,
        Roadmap,
        cells_roadmap,
        grid_lanes,
        grid_roadmap,
        sampled_roadmap,
        visibility_graph,
        voronoi_roadmap,
    )
    from taut.route import (
        PathIndex,
        Paths,
        Route,
        central_path,
        distances,
        distances_from,
        hits_of,
        index_obstacles,
        lazy_route,
        oca_path,
        oca_path_or_widest,
        paths,
        potential_path,
        prepare,
        routes_along,
        shortest_path,
        smoothed,
        widest_passage,
        widest_routes,
    )
    from taut.scene import Circle, Line, Polygon, Rectangle, Robot, Scene
    from taut.simulation import simulate, steer
    from taut.team import Replanned, Result, plan, replan
    from taut.validation import validate

    __version__: str

__all__ = [
    "Certificate",
    "Circle",
    "Contact",
    "Contacts",
    "Formed",
    "FreeSpace",
    "GoalBlocked",
    "Lanes",
    "Line",
    "NoPath",
    "NoPlanExists",
    "NoPlanFound",
    "OutputError",
    "PathIndex",
    "Paths",
    "Plan",
    "PlanError",
    "Polygon",
    "Rectangle",
    "Replanned",
    "Result",
    "Roadmap",
    "Robot",
    "Route",
    "Scene",
    "SceneError",
    "StartBlocked",
    "TautError",
    "Trajectory",
    "__version__",
    "animate",
    "cells_roadmap",
    "central_path",
    "certify",
    "contact",
    "contacts",
    "control",
    "distances",
    "distances_from",
    "draw",
    "fading_fiedler",
    "free_cells",
    "graph",
    "grid_lanes",
    "grid_roadmap",
    "hits_of",
    "in_formation",
    "index_obstacles",
    "lazy_route",
    "load_map",
    "load_plan",
    "load_roadmap",
    "load_scen",
    "load_scene",
    "needed_reach",
    "oca_path",
    "oca_path_or_widest",
    "paths",
    "plan",
    "potential_path",
    "prepare",
    "random_scene",
    "random_team_in_contact",
    "random_warehouse",
    "replan",
    "routes_along",
    "sampled_roadmap",
    "save",
    "save_figure",
    "save_roadmap",
    "save_stages",
    "shortest_path",
    "simulate",
    "simulation",
    "smoothed",
    "steer",
    "travel",
    "validate",
    "visibility_graph",
    "voronoi_roadmap",
    "widest_passage",
    "widest_routes",
    "with_obstacle",
    "without_obstacle",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: with a module-level __getattr__ they would accept every misspelt name.
    _HOMES = {
        "taut.certificate": ("Certificate", "certify"),
        "taut.contact": ("Contact", "Contacts", "contacts", "fading_fiedler", "needed_reach"),
        "taut.editing": ("with_obstacle", "without_obstacle"),
        "taut.errors": (
            "GoalBlocked",
            "NoPath",
            "NoPlanExists",
            "NoPlanFound",
            "OutputError",
            "PlanError",
            "SceneError",
            "StartBlocked",
            "TautError",
        ),
        "taut.figures": ("animate", "draw", "save_figure", "save_stages"),
        "taut.formats": (
            "free_cells",
            "load_map",
            "load_plan",
            "load_roadmap",
            "load_scen",
            "load_scene",
            "save",
            "save_roadmap",
        ),
        "taut.formation": ("Formed", "in_formation", "travel"),
        "taut.freespace": ("FreeSpace",),
        "taut.generate": ("random_scene", "random_warehouse"),
        "taut.generate.contact": ("random_team_in_contact",),
        "taut.motion": ("Plan", "Trajectory"),
        "taut.roadmap": (
            "Lanes",
            "Roadmap",
            "cells_roadmap",
            "grid_lanes",
            "grid_roadmap",
            "sampled_roadmap",
            "visibility_graph",
            "voronoi_roadmap",
        ),
        "taut.route": (
            "PathIndex",
            "Paths",
            "Route",
            "central_path",
            "distances",
            "distances_from",
            "hits_of",
            "index_obstacles",
            "lazy_route",
            "oca_path",
            "oca_path_or_widest",
            "paths",
            "potential_path",
            "prepare",
            "routes_along",
            "shortest_path",
            "smoothed",
            "widest_passage",
            "widest_routes",
        ),
        "taut.scene": ("Circle", "Line", "Polygon", "Rectangle", "Robot", "Scene"),
        "taut.simulation": ("simulate", "steer"),
        "taut.team": ("Replanned", "Result", "plan", "replan"),
        "taut.validation": ("validate",),
    }
    _HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

    def __getattr__(name: str) -> object:
        import importlib

        if name == "__version__":
            from importlib.metadata import version

            value: object = version("taut")
        elif name in ("contact", "control", "graph", "simulation"):
            value = importlib.import_module(f"taut.{name}")
        elif name in _HOME_OF:
            value = getattr(importlib.import_module(_HOME_OF[name]), name)
        else:
            raise AttributeError(f"module 'taut' has no attribute {name!r}")
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

    if "IPython" in sys.modules:
        from IPython import get_ipython

        if (shell := get_ipython()) is not None:
            from taut.notebook import show_values_as_pictures

            show_values_as_pictures(shell)
