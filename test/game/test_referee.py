"""States, outcomes and rulings, in all games."""

from dataclasses import replace
import json
import math
import sys
from types import SimpleNamespace

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, Stroke
from billiard_shot.game import (
    Call,
    choose,
    find_game,
    game_names,
    judge,
    Outcome,
    outcome_of,
    start,
    State,
)
from billiard_shot.game.rack import scene_of
from billiard_shot.game.referee import falls_in_words, spotted
from billiard_shot.game.state import CHOICES, GROUPS, IN_HAND, PHASES
from billiard_shot.game.typed import MOVED, possible_rulings, ShotReport, told_outcome
from billiard_shot.game.valuation import rule_on
from billiard_shot.table.run.results import POCKET_NAMES

TABLE = Scene.load('pool_table')
EIGHT = start('eight_ball', TABLE, seed=3)


def shot_at(balls, target, speed=2.0, cue=(0.0, 0.0), b=0.0, elevation=0.05):
    scene = replace(TABLE, balls={'cue': cue, **balls})
    azimuth = math.atan2(target[1] - cue[1], target[0] - cue[0])
    return predict(scene, Stroke.from_offsets(0.0, b, elevation, azimuth, speed))


@pytest.mark.parametrize('game', game_names())
@pytest.mark.parametrize('table', ['pool_table', 'seven_foot', 'carom'])
def test_a_game_starts_on_tables_that_suit_it(game, table):
    scene = Scene.load(table)
    if scene.table.pockets != find_game(game).pockets:
        with pytest.raises(ValueError, match='needs a table with'):
            start(game, scene)
        return
    state = start(game, scene, seed=5)
    assert state == start(game, scene, seed=5)
    if game != 'three_cushion':
        assert state.balls != start(game, scene, seed=6).balls
    placed = replace(scene, balls=state.balls)  # a scene refuses balls that cannot lie there
    assert set(placed.balls) >= set(find_game(game).balls)


@pytest.mark.parametrize('game', game_names())
def test_a_state_is_saved_and_loaded(game, tmp_path):
    state = start(game, 'carom' if game == 'three_cushion' else 'pool_table', 2, time_limit=60.0)
    state.save(tmp_path / 'state.json')
    assert State.load(tmp_path / 'state.json') == state
    assert State.from_dict(json.loads(json.dumps(state.to_dict()))) == state


@pytest.mark.parametrize(
    ('field', 'value', 'allowed'),
    [
        ('player', 2, '0 or 1'),
        ('player', None, '0 or 1'),
        ('phase', 'lag', 'break, second, play'),
        ('fouls', (1, -1), 'two whole numbers, at least 0'),
        ('groups', ('solids',), "one of ('', ''), ('solids', 'stripes')"),
        ('groups', ('solids', 'solids'), "got ('solids', 'solids')"),
        ('groups', ('solids', ''), "got ('solids', '')"),
        ('choices', ('resign',), "a list of 'accept'"),
        ('choices', ('accept',) * 100_000, 'each at most once'),
        ('choices', 'accept', 'each at most once'),
        ('game', '../../x', 'or a module such as package.module or its path'),
        ('game', '.py', 'or a module such as package.module or its path'),
        ('game', 'practice\x1b[2J', 'or a module such as package.module'),
        ('balls', {'1': (0, 0), '16': (0.5, 0)}, "14, 15, got '16'"),
        ('balls', {str(i): (0.0, 0.0) for i in range(100_000)}, "got '0'"),
        ('balls', {'\x1b[2J': (0.0, 0.0)}, 'of at most 64 printable characters'),
        ('time_left', (1.0, math.inf), 'two finite numbers'),
        (
            'balls',
            {'1': (0, 0), '2': (0, 0.05)},
            "from ball '1', which it overlaps by 7.15 mm, got (0.0, 0.05) (m)",
        ),
    ],
)
def test_a_state_refuses_what_makes_no_sense(field, value, allowed):
    with pytest.raises(ValueError, match=field) as caught:
        State.from_dict({**EIGHT.to_dict(), field: value})
    assert allowed in str(caught.value)
    assert len(str(caught.value)) < 1000
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    'field', [{'player': 1}, {'breaker': 1}, {'winner': 1}, {'choices': ('pass',)}]
)
def test_a_game_of_one_player_has_no_second_player(field):
    with pytest.raises(ValueError, match=f'{next(iter(field))} must be .* in practice'):
        replace(start('practice', TABLE), **field)


def test_the_cue_ball_is_placed_by_the_rules():
    with pytest.raises(ValueError, match='behind the head string'):
        EIGHT.with_cue_ball(-0.635, 0.0)
    with pytest.raises(ValueError, match=r'must be at x -1\.241 to 1\.241'):
        EIGHT.with_cue_ball(-1.25, 0.0)
    anywhere = replace(EIGHT, in_hand='anywhere')
    with pytest.raises(ValueError, match=r'at least 57\.15 mm from ball'):
        anywhere.with_cue_ball(0.6, 0.0)
    assert anywhere.with_cue_ball(0.5, 0.0).balls['cue'] == (0.5, 0.0)
    with pytest.raises(ValueError, match='is not in hand'):
        EIGHT.with_cue_ball(-0.7, 0.0).with_cue_ball(-0.7, 0.0)


def test_an_unknown_game_is_refused():
    with pytest.raises(ValueError, match='eight_ball, eight_ball_ghost, nine_ball, '):
        find_game('snooker')
    with pytest.raises(ValueError, match='is not a module with GAME'):
        find_game('json.decoder')
    with pytest.raises(ValueError, match=r"or its path, got 'nine_bal'; .* is nine_ball$"):
        find_game('nine_bal')
    for name in ('../../x', '.json', 'json.', 'json..decoder'):
        with pytest.raises(ValueError, match='or a module such as'):
            find_game(name)


def test_a_game_has_the_name_of_its_module(monkeypatch):
    """By its name a saved state finds its game again."""
    module = SimpleNamespace(GAME=find_game('practice'))
    monkeypatch.setitem(sys.modules, 'games.other', module)
    with pytest.raises(ValueError, match=r"games\.other\.GAME\.name must be 'games\.other', got"):
        find_game('games.other')
    module.GAME = replace(module.GAME, name='games.other')
    state = start('games.other', TABLE)
    assert State.from_dict(state.to_dict()) == state


def test_a_game_is_an_object_or_in_a_file(tmp_path):
    """A saved state finds the game of a file again; a game that is an object is given."""
    path = tmp_path / 'mine.py'
    path.write_text("from billiard_shot.game import find_game\nGAME = find_game('practice')\n")
    state = start(str(path), TABLE)
    assert State.from_dict(state.to_dict()) == state
    mine = replace(find_game('practice'), name='mine')
    own = start(mine, TABLE)
    own.save(tmp_path / 'state.json')
    assert State.load(tmp_path / 'state.json', mine) == own
    with pytest.raises(ValueError, match="'mine'"):
        State.load(tmp_path / 'state.json')
    with pytest.raises(ValueError, match='is not a file with GAME'):
        find_game(str(tmp_path / 'none.py'))


def test_a_pot_is_read_from_a_prediction():
    balls, ghost = {'3': (0.9, 0.45), '4': (-0.9, 0.3)}, (0.849, 0.4244)
    outcome = outcome_of(shot_at(balls, ghost, cue=(0.3, 0.0)))
    assert outcome.pocketed == (('3', 'foot_left'),)
    assert outcome.first_contact == '3'
    assert outcome.met == ('3',)
    assert set(outcome.places) == {'cue', '4'}
    assert outcome.places['4'] == (-0.9, 0.3)
    assert not outcome.refused


def test_a_refused_stroke_moves_nothing():
    shot = shot_at({'3': (-0.06, 0.0)}, (1.0, 0.0))
    assert shot.status.refused
    ruling = judge(replace(EIGHT, phase='play').with_cue_ball(-0.7, 0.0), Call(), shot)
    assert [foul.rule for foul in ruling.fouls] == ['6.6']
    assert ruling.state.balls == EIGHT.balls


def test_only_cushions_after_the_first_contact_count():
    cushion_first = outcome_of(shot_at({'3': (-0.4, 0.0)}, (1.0, 0.0), speed=1.6, elevation=0.15))
    assert cushion_first.first_contact == '3'
    assert cushion_first.cushions_before == (1,)
    slow = outcome_of(shot_at({'3': (0.3, 0.0)}, (1.0, 0.0), speed=0.4))
    assert slow.first_contact == '3'
    assert slow.to_cushion == frozenset()
    fast = outcome_of(shot_at({'3': (0.3, 0.0)}, (1.0, 0.0), speed=2.0))
    assert '3' in fast.to_cushion


def test_a_ball_frozen_to_a_cushion_is_not_driven_to_it():
    """WPA 8.4: it has to leave the cushion and come back, or reach another one."""
    edge = 0.635 - 2 * 0.028575 * math.sqrt(0.635 * (1 - 0.635))
    soft = shot_at({'3': (0.3, edge)}, (0.3, edge), speed=0.35, cue=(0.3, 0.3))
    assert any('3' in e.balls and e.place == 'left' for e in soft.events)
    assert '3' not in outcome_of(soft).to_cushion
    near = shot_at({'3': (0.3, edge - 0.01)}, (0.3, edge), speed=0.35, cue=(0.3, 0.3))
    assert '3' in outcome_of(near).to_cushion


def test_behind_the_head_string():
    behind = {'3': (-1.0, 0.3)}
    cue = (-0.7, 0.3)
    assert outcome_of(shot_at(behind, behind['3'], cue=cue)).from_kitchen
    assert not outcome_of(shot_at({'3': (0.5, 0.3)}, (0.5, 0.3), cue=cue)).from_kitchen
    by_the_foot = shot_at({'3': (-1.0, 0.3)}, (1.0, 0.3), cue=cue, speed=4.0, elevation=0.15)
    assert by_the_foot.first_contact == '3'
    assert not outcome_of(by_the_foot).from_kitchen


def test_balls_are_spotted_on_the_long_string():
    blocked = {'1': (0.635, 0.0), '2': (0.7, 0.02), 'cue': (0.79, 0.0)}
    found = spotted(EIGHT, blocked, ['8', '9'])
    r = EIGHT.radius
    assert found['8'][1] == found['9'][1] == 0.0
    assert math.dist(found['8'], found['cue']) > 2 * r
    for ball in ('8', '9'):
        gaps = [math.dist(found[ball], p) - 2 * r for b, p in found.items() if b != ball]
        assert min(gaps) > -1e-9
    assert found['8'][0] > 0.635
    full = {str(i): (0.635 + 2 * r * i, 0.0) for i in range(11)}
    up = spotted(EIGHT, full, ['12'])['12']
    assert up[0] == pytest.approx(0.635 - 2 * r)


def test_the_time_of_a_player_is_used_up():
    state = start('eight_ball', TABLE, time_limit=10.0).with_cue_ball(-0.7, 0.0)
    outcome = Outcome('1', (), (), frozenset('1234'), places=state.balls)
    ruling = judge(state, Call(), outcome, seconds=4.0)
    assert ruling.state.time_left == (6.0, 10.0)
    late = judge(state, Call(), outcome, seconds=10.5)
    assert [foul.rule for foul in late.fouls] == ['6.15']
    assert (late.state.over, late.state.winner) == (True, 1)
    with pytest.raises(ValueError, match='the game is over'):
        judge(late.state, Call(), outcome)


@pytest.mark.parametrize(
    ('call', 'fields', 'words'),
    [
        (Call('99'), {}, r"call\.ball must be one of None, '1', .* '15', got '99'"),
        (Call(), {'first_contact': '77'}, "first_contact must be one of None, .*, got '77'"),
        (Call(), {'first_contact': 'cue'}, "first_contact must be .*, got 'cue'"),
        (Call(), {'pocketed': (('77', 'side_left'),)}, "pocketed must be .*'cue', got '77'"),
        (
            Call(),
            {'pocketed': (('1', 'corner'),)},
            "pocketed must be a pocket, one of .*, got 'corner'",
        ),
        (
            Call(),
            {'pocketed': ('1', 'side_left')},
            "pocketed must be a ball and a pocket, got '1'",
        ),
        (Call(), {'off_table': ('77',)}, "off_table must be .*, got '77'"),
        (Call(), {'to_cushion': frozenset({'77'})}, "to_cushion must be .*, got '77'"),
        (Call(), {'met': ('77',), 'cushions_before': (0,)}, "met must be .*, got '77'"),
        (Call(), {'met': ('1',)}, r'cushions_before must be 1 numbers, .* got \(\)'),
        (Call(), {'met': ('1',), 'cushions_before': (-1,)}, r'each at least 0, got \(-1,\)'),
        (Call(), {'places': {'77': (0, 0)}}, "balls must be one of cue, 1, .*, got '77'"),
        (Call(), {'places': {'1': (0, math.nan)}}, r'balls\.1 must be two finite .* nan\) \(m\)'),
    ],
)
def test_what_is_not_there_is_refused_by_name(call, fields, words):
    state = EIGHT.with_cue_ball(-0.7, 0.1)
    with pytest.raises(ValueError, match=words):
        judge(state, call, Outcome(**{'places': state.balls} | fields))


def test_an_outcome_with_a_pocket_that_does_not_exist_is_refused():
    with pytest.raises(
        ValueError, match=r"pocketed must be a pocket.*got 'foot_lift'; the nearest"
    ):
        Outcome('1', (('1', 'foot_lift'),))


@pytest.mark.parametrize('seconds', [-1.0, math.nan, math.inf, '1'])
@pytest.mark.parametrize('limit', [None, 60.0])
def test_a_time_below_zero_is_refused(seconds, limit):
    state = start('eight_ball', TABLE, time_limit=limit).with_cue_ball(-0.7, 0.1)
    with pytest.raises(
        ValueError, match=r'seconds must be a finite number at least 0, got .* \(s\)'
    ):
        judge(state, seconds=seconds)
    with pytest.raises(ValueError, match='seconds must be'):
        choose(replace(state, choices=('accept',)), 'accept', seconds)
    with pytest.raises(ValueError, match=r'time_limit must be .*above 0, got -5'):
        start('eight_ball', TABLE, time_limit=-5)


def test_a_miscue_is_legal_and_recorded():
    """WPA 8.18; only an intentional one is a foul."""
    state = replace(EIGHT.with_cue_ball(-0.7, 0.1), phase='play', in_hand='')
    outcome = Outcome('1', (), (), frozenset({'1'}), miscue=True, places=state.balls)
    ruling = judge(state, Call(ball='1', pocket='foot_left'), outcome)
    assert ruling.legal
    assert ruling.miscue
    assert ruling == replace(judge(state, shot=replace(outcome, miscue=False)), miscue=True)
    balls = {'cue': (0.0, 0.0)}
    shot = predict(replace(TABLE, balls=balls), Stroke.from_offsets(0.8, 0.0, 0.05, 0.0, 2.0))
    assert outcome_of(shot).miscue


def test_a_simulated_batch_gets_the_rulings_of_its_shots():
    draw = np.random.default_rng(7)
    state = replace(EIGHT.with_cue_ball(-0.7, 0.1), phase='play', in_hand='')
    scattered = start('practice', TABLE, seed=11).balls
    state = replace(state, balls={**scattered, 'cue': (0.05, 0.02)}, groups=('solids', 'stripes'))
    scene = replace(TABLE, balls=state.balls)
    offsets = np.zeros((40, 5))
    offsets[:, 2], offsets[:, 3] = 0.35, draw.uniform(-np.pi, np.pi, 40)
    offsets[:, 4] = draw.uniform(0.3, 3.0, 40)
    calls = [Call(ball='3', pocket='foot_left')] * 40
    played = predict_batch(scene, offsets=offsets)
    batch = rule_on(state, calls, played)
    ruled = set()
    for i, row in enumerate(offsets.tolist()):
        one = judge(state, calls[i], predict(scene, Stroke.from_offsets(*row)))
        many = batch.kinds[batch.kind[i]]
        assert [foul.rule for foul in one.fouls] == [foul.rule for foul in many.fouls]
        assert one.state.player == many.state.player
        assert set(one.state.balls) == set(many.state.balls)
        there = batch.states.present[i]
        assert set(one.state.balls) | {'cue'} >= set(np.array(batch.states.names)[there].tolist())
        ruled |= {foul.rule for foul in one.fouls} or {'legal'}
    assert ruled >= {'6.2', '6.3', 'legal'}


def test_a_frozen_ball_is_driven_to_its_cushion_in_no_batch_if_the_referee_denies_it():
    draw = np.random.default_rng(5)
    up, reach = (
        TABLE.ball.radius * (2.0 * TABLE.table.cushion.height - 1.0),
        0.5 * TABLE.table.width,
    )
    touching = reach - math.sqrt(TABLE.ball.radius**2 - up**2)
    no_rail = stricter = 0
    for _ in range(15):
        along = [0.25, 0.4, 0.55, 0.7, -0.25, -0.4, -0.55, -0.7]
        frozen = {str(i + 1): (x, touching) for i, x in enumerate(along)}
        state = replace(EIGHT, phase='play', in_hand='', groups=('solids', 'stripes'))
        state = replace(state, balls={'cue': tuple(draw.uniform(-0.5, 0.5, 2)), **frozen})
        scene, places = replace(TABLE, balls=state.balls), np.array(list(frozen.values()))
        x, y = (places[draw.integers(8, size=20)] - state.balls['cue']).T
        offsets = np.zeros((20, 5))
        offsets[:, 2], offsets[:, 4] = 0.05, draw.uniform(0.3, 1.5, 20)
        offsets[:, 3] = np.arctan2(y, x) + draw.normal(0.0, 0.02, 20)
        batch = rule_on(state, [Call()] * 20, predict_batch(scene, offsets=offsets))
        for i, row in enumerate(offsets.tolist()):
            one = judge(state, Call(), predict(scene, Stroke.from_offsets(*row)))
            fouls = {foul.rule for foul in one.fouls}
            more = {foul.rule for foul in batch.kinds[batch.kind[i]].fouls} - fouls
            assert fouls <= {foul.rule for foul in batch.kinds[batch.kind[i]].fouls}
            assert more <= {'6.3'}
            no_rail, stricter = no_rail + ('6.3' in fouls), stricter + bool(more)
    assert no_rail > 30
    assert stricter <= 3  # of 300: a ball that hops lands within a millimetre of its cushion


# --- rulings from pictures: what the places of the balls before and after a shot allow -----------

SCENE = Scene.load('pool_table')


def state_of(game, balls, **fields):
    return replace(start(game, SCENE), phase='play', in_hand='', choices=(), balls=balls, **fields)


BALLS = {'cue': (-0.3, 0.0), '1': (0.3, 0.1), '9': (0.6, -0.3), '8': (0.0, 0.4)}


def test_a_lone_ball_that_fell_was_met():
    state = state_of('practice', BALLS)
    after = {**BALLS, 'cue': (0.1, 0.0)}
    del after['1']
    (ruling,) = possible_rulings(state, Call(), after)
    assert ruling.legal
    assert ruling.state.player == 0


def test_no_ball_moved():
    state = state_of('practice', BALLS)
    (ruling,) = possible_rulings(state, Call(), {**BALLS, 'cue': (0.1, 0.0)})
    assert [foul.rule for foul in ruling.fouls] == ['6.3']


def test_which_pocket_took_the_called_ball_is_not_seen():
    state = state_of('eight_ball', BALLS, groups=('solids', 'stripes'))
    after = {**BALLS, 'cue': (0.1, 0.0)}
    del after['1']
    rulings = possible_rulings(state, Call(ball='1', pocket='foot_left'), after)
    assert {ruling.state.player for ruling in rulings} == {0, 1}


def test_a_scratch_has_one_ruling_whatever_was_met():
    state = state_of('practice', BALLS)
    after = {'1': (0.5, 0.2), '9': (0.2, -0.3), '8': (0.0, 0.4)}
    (ruling,) = possible_rulings(state, Call(), after)
    assert ruling.state.over
    assert ruling.state.winner is None


@pytest.mark.parametrize('game', ['practice', 'eight_ball', 'nine_ball'])
def test_the_true_ruling_is_among_the_possible_ones(game):
    rng, compared = np.random.default_rng(5), 0
    for seed in range(60):
        state = replace(start('practice', SCENE, seed, balls=9), game=game, in_hand='')
        state = replace(state, groups=('solids', 'stripes') if game == 'eight_ball' else ('', ''))
        cue = (float(rng.uniform(-1.1, 1.1)), float(rng.uniform(-0.5, 0.5)))
        if any(math.dist(cue, place) < 0.07 for place in state.balls.values()):
            continue
        state = replace(state, balls={**state.balls, 'cue': cue})
        stroke = Stroke.from_offsets(
            elevation=0.1, azimuth=float(rng.uniform(-3.1, 3.1)), speed=float(rng.uniform(2, 5))
        )
        call = Call(ball='1', pocket='foot_left')
        outcome = outcome_of(predict(scene_of(SCENE, state), stroke))
        met = outcome.first_contact
        if outcome.refused or outcome.off_table or outcome.double_hit:
            continue
        if met in outcome.places and math.dist(outcome.places[met], state.balls[met]) < MOVED:
            continue
        ruling = judge(state, call, outcome)
        possible = possible_rulings(state, call, outcome.places)
        assert any(ruling.state == each.state for each in possible), (seed, ruling.text)
        told = ShotReport(met or '', outcome.to_cushion, dict(outcome.pocketed))
        complete = told_outcome(state, outcome.places, told)
        assert judge(state, call, complete).state == ruling.state
        compared += 1
    assert compared > 40


@pytest.mark.parametrize(
    ('told', 'words'),
    [
        ({'first_contact': '4'}, "first_contact must be one of '', '1'.*, got '4'"),
        ({'to_cushion': ['4']}, "to_cushion must be .*, got '4'"),
        ({'pockets': {'8': 'foot_left'}}, "pocketed must be one of '1', got '8'"),
        ({'pockets': {'1': 'corner'}}, "pockets must be .*, got 'corner'"),
    ],
)
def test_what_is_told_is_checked(told, words):
    after = {name: place for name, place in BALLS.items() if name != '1'}
    with pytest.raises(ValueError, match=words):
        told_outcome(state_of('practice', BALLS), after, ShotReport(**told))


# --- any state that can be made has a ruling for any shot, and goes on after any choice ----------

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


@pytest.mark.parametrize(
    ('balls', 'said'), [((), 'no ball falls'), (('3',), '3 falls'), (('3', '6'), '3, 6 fall')]
)
def test_the_balls_that_fall_are_said(balls, said):
    outcome = Outcome(pocketed=tuple((ball, 'foot_left') for ball in balls))
    assert falls_in_words(outcome) == said
