"""Any state that can be made has a ruling for any shot, and goes on after any choice."""

from hypothesis import given, settings
from hypothesis import strategies as st

from billiard_shot import Scene
from billiard_shot.game import Call, choose, find_game, game_names, judge, Outcome, State
from billiard_shot.game.state import CHOICES, GROUPS, IN_HAND, PHASES
from billiard_shot.table.run.results import POCKET_NAMES

TABLE = Scene.load('pool_table')
PLACES = [(0.1 * x, 0.1 * y) for x in range(-10, 11) for y in range(-4, 5)]


@st.composite
def states(draw):
    game = find_game(draw(st.sampled_from(game_names())))
    balls = draw(st.lists(st.sampled_from(('cue', *game.balls)), unique=True))
    places = draw(st.permutations(PLACES))[: len(balls)]
    player = st.integers(0, game.players - 1)
    return State(
        game=game.name,
        length=TABLE.table.length,
        width=TABLE.table.width,
        radius=TABLE.ball.radius,
        balls=dict(zip(balls, places, strict=True)),
        player=draw(player),
        phase=draw(st.sampled_from(PHASES)),
        in_hand=draw(st.sampled_from(IN_HAND)),
        choices=draw(st.lists(st.sampled_from(list(CHOICES)), unique=True))
        if game.players > 1
        else (),
        groups=draw(st.sampled_from(GROUPS)),
        fouls=draw(st.tuples(*[st.integers(0, 5)] * 2)),
        scores=draw(st.tuples(*[st.integers(-20, 200)] * 2)),
        target=draw(st.integers(0, 150)),
        breaker=draw(player),
    )


@st.composite
def outcomes(draw, state):
    some = lambda names: draw(st.lists(st.sampled_from(names), unique=True)) if names else []  # noqa: E731
    met = some(state.object_balls)
    gone = some(tuple(state.balls))
    pocket = st.sampled_from(POCKET_NAMES)
    fallen = draw(st.integers(0, len(gone)))
    return Outcome(
        first_contact=met[0] if met else None,
        pocketed=tuple((ball, draw(pocket)) for ball in gone[:fallen]),
        off_table=tuple(gone[fallen:]),
        to_cushion=frozenset(some(tuple(state.balls))),
        from_kitchen=draw(st.booleans()),
        double_hit=draw(st.booleans()),
        met=tuple(met),
        cushions_before=tuple(draw(st.integers(0, 4)) for _ in met),
        places={ball: place for ball, place in state.balls.items() if ball not in gone},
    )


@settings(deadline=None)
@given(states(), st.data())
def test_any_state_goes_on(state, data):
    for choice in state.choices:
        if choice in ('break', 'rebreak') and state.game.name == 'three_cushion':
            continue  # whose balls have places on a carom table
        assert not choose(state, choice).choices
    if state.choices or 'cue' not in state.balls:
        return
    names = st.none() | st.sampled_from(state.game.balls)
    call = Call(
        ball=data.draw(names),
        pocket=data.draw(st.sampled_from(('', *POCKET_NAMES))),
        safety=data.draw(st.booleans()),
        push_out=data.draw(st.booleans()),
    )
    ruling = judge(state, call, data.draw(outcomes(state)))
    assert ruling.text
    assert (
        ruling.state.over
        or ruling.state.choices
        or ruling.state.in_hand
        or ('cue' in ruling.state.balls)
    )
    assert judge(state, call, None).fouls
