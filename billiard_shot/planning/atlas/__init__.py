"""How surely balls are potted from where: a plan for each of many places."""

from billiard_shot.planning.atlas.file import append, begin, load_atlas
from billiard_shot.planning.atlas.maps import Atlas, Map
from billiard_shot.planning.atlas.places import Place, places_of
from billiard_shot.planning.atlas.request import AtlasRequest
from billiard_shot.planning.atlas.survey import atlas, PlaceChance

__all__ = [
    'append',
    'Atlas',
    'atlas',
    'AtlasRequest',
    'begin',
    'load_atlas',
    'Map',
    'Place',
    'PlaceChance',
    'places_of',
]
