"""Robots that follow a plan: vehicles, sensors, disturbances, the closed loop, and studies of many runs.

The public names below are loaded when they are first used: few of them are needed at a time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taut.simulation.detector import THESIS_DETECTOR, Detection, Detector, detect
    from taut.simulation.disturbances import Disturbances
    from taut.simulation.margin import Margin, runs_needed, tracking_margin, with_margin
    from taut.simulation.report import Link, contact_kept, dead, driven_plan, run_data, scene_from, stopped
    from taut.simulation.running import Collision, Nearest, Run, Scans, Wait, simulate
    from taut.simulation.sensors import (
        THESIS_FAR_LIDAR,
        THESIS_NEAR_LIDAR,
        Lidar,
        Radio,
        Scan,
        linked,
        scan,
    )
    from taut.simulation.steering import Steered, fiedler_values, formation_error, steer
    from taut.simulation.studies import (
        Study,
        StudyInterrupted,
        Trial,
        load_margin,
        save_study,
        study,
        study_doubts,
        study_summary,
    )
    from taut.simulation.surroundings import Surroundings, surroundings_of
    from taut.simulation.vehicles import (
        KINDS,
        Ackermann,
        DifferentialDrive,
        Integrator,
        Unicycle,
        Vehicle,
        tracking_for,
        vehicle_for,
    )

__all__ = [
    "KINDS",
    "THESIS_DETECTOR",
    "THESIS_FAR_LIDAR",
    "THESIS_NEAR_LIDAR",
    "Ackermann",
    "Collision",
    "Detection",
    "Detector",
    "DifferentialDrive",
    "Disturbances",
    "Integrator",
    "Lidar",
    "Link",
    "Margin",
    "Nearest",
    "Radio",
    "Run",
    "Scan",
    "Scans",
    "Steered",
    "Study",
    "StudyInterrupted",
    "Surroundings",
    "Trial",
    "Unicycle",
    "Vehicle",
    "Wait",
    "contact_kept",
    "dead",
    "detect",
    "driven_plan",
    "fiedler_values",
    "formation_error",
    "linked",
    "load_margin",
    "run_data",
    "runs_needed",
    "save_study",
    "scan",
    "scene_from",
    "simulate",
    "steer",
    "stopped",
    "study",
    "study_doubts",
    "study_summary",
    "surroundings_of",
    "tracking_for",
    "tracking_margin",
    "vehicle_for",
    "with_margin",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: with a module-level __getattr__ they would accept every misspelt name.
    _HOMES = {
        "taut.simulation.detector": ("THESIS_DETECTOR", "Detection", "Detector", "detect"),
        "taut.simulation.disturbances": ("Disturbances",),
        "taut.simulation.margin": ("Margin", "runs_needed", "tracking_margin", "with_margin"),
        "taut.simulation.report": ("Link", "contact_kept", "dead", "driven_plan", "run_data", "scene_from", "stopped"),
        "taut.simulation.running": ("Collision", "Nearest", "Run", "Scans", "Wait", "simulate"),
        "taut.simulation.sensors": (
            "THESIS_FAR_LIDAR",
            "THESIS_NEAR_LIDAR",
            "Lidar",
            "Radio",
            "Scan",
            "linked",
            "scan",
        ),
        "taut.simulation.steering": ("Steered", "fiedler_values", "formation_error", "steer"),
        "taut.simulation.studies": (
            "Study",
            "StudyInterrupted",
            "Trial",
            "load_margin",
            "save_study",
            "study",
            "study_doubts",
            "study_summary",
        ),
        "taut.simulation.surroundings": ("Surroundings", "surroundings_of"),
        "taut.simulation.vehicles": (
            "KINDS",
            "Ackermann",
            "DifferentialDrive",
            "Integrator",
            "Unicycle",
            "Vehicle",
            "tracking_for",
            "vehicle_for",
        ),
    }
    _HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

    def __getattr__(name: str) -> object:
        import importlib

        if name not in _HOME_OF:
            raise AttributeError(f"module 'taut.simulation' has no attribute {name!r}")
        value = getattr(importlib.import_module(_HOME_OF[name]), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
