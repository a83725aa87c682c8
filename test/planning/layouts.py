"""Scenes for plans."""
from billiard_shot import Scene


def table_with(**balls):
    """Nine-foot table with the cue ball and others, named b8 or so: names of balls are digits."""
    data = Scene.load('pool_table').to_dict()
    data['balls'] = {name.removeprefix('b'): place for name, place in balls.items()}
    return Scene.from_dict(data)
