"""Scene and plan files: YAML, JSON, GeoJSON."""

from taut.formats.convert import plan_from_dict, plan_to_dict, scene_from_dict, scene_to_dict
from taut.formats.files import load_plan, load_scene, save, scene_names
from taut.formats.schema import scene_schema

__all__ = [
    "load_plan",
    "load_scene",
    "plan_from_dict",
    "plan_to_dict",
    "save",
    "scene_from_dict",
    "scene_names",
    "scene_schema",
    "scene_to_dict",
]
