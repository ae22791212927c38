"""Files of scenes, plans and roadmaps: YAML, JSON, GeoJSON, GraphML, NumPy archives, MovingAI maps."""

from taut.formats.convert import plan_from_dict, plan_to_dict, scene_from_dict, scene_to_dict
from taut.formats.files import load_plan, load_scene, load_scene_or_plan, save, scene_abouts, scene_names, value_of_text
from taut.formats.movingai import free_cells, load_map, load_scen
from taut.formats.roadmaps import load_roadmap, save_roadmap
from taut.formats.schema import scene_schema

__all__ = [
    "free_cells",
    "load_map",
    "load_plan",
    "load_roadmap",
    "load_scen",
    "load_scene",
    "load_scene_or_plan",
    "plan_from_dict",
    "plan_to_dict",
    "save",
    "save_roadmap",
    "scene_abouts",
    "scene_from_dict",
    "scene_names",
    "scene_schema",
    "scene_to_dict",
    "value_of_text",
]
