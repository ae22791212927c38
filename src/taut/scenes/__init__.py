"""Ready scenes, one YAML file each, loaded by name with `taut.load_scene`."""
