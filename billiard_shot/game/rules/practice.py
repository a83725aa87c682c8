"""
Practice: one player clears the table, from cue ball in hand, until a shot pots nothing.

The balls lie at random places, drawn from the seed. Any ball may be met and potted; the fouls are
the standard ones of the World Pool-Billiard Association. A foul or a shot without a pot ends it.
"""

import math
import random

from billiard_shot.game.referee import after_shot, falls_in_words, in_words, standard_fouls
from billiard_shot.game.state import Call, Game, Outcome, Ruling, State
from billiard_shot.scene.placement import Place

SMALLEST_GAP = 1e-3  # m: smallest gap between balls, and between balls and noses


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot: it has to pot a ball without a foul."""
    fouls = standard_fouls(state, outcome, None)
    left = set(state.object_balls) - outcome.gone
    goes_on = bool(outcome.fallen) and not fouls
    cleared = goes_on and not left
    after = after_shot(
        state,
        fouls,
        keeps=goes_on,
        player=state.player,
        over=cleared or not goes_on,
        winner=state.player if cleared else None,
    )
    text = 'cleared' if cleared else falls_in_words(outcome)
    return Ruling(after, fouls, in_words(fouls, text))


def rack(state: State, balls: tuple[str, ...]) -> dict[str, Place]:
    """Place the balls at random, by the seed of the state."""
    draw = random.Random(state.seed)
    apart = 2.0 * state.radius + SMALLEST_GAP
    bed = 0.5 * state.length - 0.5 * apart, 0.5 * state.width - 0.5 * apart
    places: dict[str, Place] = {}
    while len(places) < len(balls):
        x, y = (half * (2.0 * draw.random() - 1.0) for half in bed)
        if all(math.dist((x, y), other) >= apart for other in places.values()):
            places[balls[len(places)]] = x, y
    return places


GAME = Game(
    name='practice',
    rule=rule,
    rack=rack,
    balls=tuple(str(ball) for ball in range(1, 16)),
    in_hand='anywhere',
    phase='play',
    calls=False,
    players=1,
)
