"""The compiled core in other programs: scenes for pages and C, and the module in JavaScript."""

from billiard_shot.embed.scenes import c_scene, export_scene

__all__ = ['export_scene', 'c_scene']
