"""Eight-ball against the ghost, see `billiard_shot.game.ghost`."""

from billiard_shot.game.ghost import ghost
from billiard_shot.game.rules import eight_ball

GAME = ghost(eight_ball.GAME)
