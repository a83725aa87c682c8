"""The compiled core in other programs: scenes for pages and C, and the module in JavaScript."""

from billiard_shot.embed.c_scene import c_scene
from billiard_shot.embed.page_scene import export_scene

__all__ = ['export_scene', 'c_scene']
