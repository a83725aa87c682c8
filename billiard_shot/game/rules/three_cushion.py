"""
Three-cushion: Union Mondiale de Billard, World Rules of Carom Billiard, 1 January 1989.

Numbers are those of its articles. The ball `cue` is that of the player at the table, `other` that
of the other player: they change names with the turn. Balls in contact (27) are played as they lie,
and the game ends with the winning point, without an equalizing inning (29).
"""

from dataclasses import replace

from billiard_shot.game.referee import after_shot, foot_spot, head_spot, in_words
from billiard_shot.game.state import added, Call, Foul, Game, Outcome, Ruling, State
from billiard_shot.scene.placement import CUE_BALL, Place

CUSHION_CONTACTS = 3  # contacts with cushions before the second ball (83)
SPOT_DISTANCE = 0.1825  # m: from the head spot to the spots of the first cue ball (13)


def targets(state: State) -> tuple[str, ...]:
    """Balls that may be met first: both, but in the first shot the red one (23)."""
    return ('red',) if state.phase == 'break' else state.object_balls


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot: a point for both balls after three cushions (83)."""
    fouls = []
    if outcome.refused:
        fouls.append(Foul('41', f'the stroke cannot be played: {outcome.refused}'))
    for ball in outcome.off_table:
        fouls.append(Foul('28', f'ball {ball} leaves the table'))
    if outcome.double_hit:
        fouls.append(Foul('41', 'the cue hits the cue ball twice'))
    if outcome.first_contact is not None and outcome.first_contact not in targets(state):
        fouls.append(Foul('23', f'ball {outcome.first_contact} is met first'))
    point = len(outcome.met) == 2 and outcome.cushions_before[1] >= CUSHION_CONTACTS and not fouls
    scores = added(state.scores, state.player, int(point))
    after = after_shot(state, tuple(fouls), keeps=point, scores=scores)
    if point and state.target and scores[state.player] >= state.target:
        after = replace(after, over=True, winner=state.player)
    text = in_words(tuple(fouls), 'a point' if point else 'no point')

    def arrange(resting: State) -> State:
        return _arranged(resting, turns=not point)

    return Ruling(after, tuple(fouls), text, arrange=arrange)


def _arranged(state: State, *, turns: bool) -> State:
    """Change the names of the cue balls with the turn, and spot the balls that are gone (28)."""
    names = {CUE_BALL: 'other', 'other': CUE_BALL} if turns else {}
    balls = {names.get(ball, ball): place for ball, place in state.balls.items()}
    spots = {'red': foot_spot(state), CUE_BALL: head_spot(state), 'other': (0.0, 0.0)}
    return replace(state, balls=spots | balls)


def rack(state: State, balls: tuple[str, ...]) -> dict[str, Place]:
    """Return the starting position (23)."""
    x, _ = head_spot(state)
    return {CUE_BALL: (x, SPOT_DISTANCE), 'other': head_spot(state), 'red': foot_spot(state)}


GAME = Game(
    name='three_cushion',
    rule=rule,
    targets=targets,
    rack=rack,
    balls=('other', 'red'),
    in_hand='',
    calls=False,
    goal=40,
    pockets=False,
)
