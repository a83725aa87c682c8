"""Ten-ball against the ghost, see `billiard_shot.game.ghost`."""

from billiard_shot.game.ghost import ghost
from billiard_shot.game.rules import ten_ball

GAME = ghost(ten_ball.GAME)
