"""Straight pool alone: a run from the break on, see `billiard_shot.game.ghost`."""

from billiard_shot.game.ghost import ghost
from billiard_shot.game.rules import straight_pool

GAME = ghost(straight_pool.GAME)
