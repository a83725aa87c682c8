"""Nine-ball against the ghost, see `billiard_shot.game.ghost`."""

from billiard_shot.game.ghost import ghost
from billiard_shot.game.rules import nine_ball

GAME = ghost(nine_ball.GAME)
