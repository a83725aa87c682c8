"""Atlases: the success probability of a pot for each of many ball layouts."""

from billiard_shot.planning.atlas.build import atlas, LayoutResult
from billiard_shot.planning.atlas.file import append, load_atlas, start_file
from billiard_shot.planning.atlas.layouts import Layout, layouts_of
from billiard_shot.planning.atlas.maps import Atlas, Map
from billiard_shot.planning.atlas.request import AtlasRequest

__all__ = [
    'append',
    'Atlas',
    'atlas',
    'AtlasRequest',
    'load_atlas',
    'Map',
    'Layout',
    'LayoutResult',
    'layouts_of',
    'start_file',
]
