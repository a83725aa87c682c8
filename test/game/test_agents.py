"""Agents, racks and tournaments: moves are legal, results repeat, and better players win."""

from dataclasses import replace
from itertools import count
import json

import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.game import Call, Decision, judge, Outcome, Ruling, start, State
from billiard_shot.game.agents import player as player_module
from billiard_shot.game.agents.greedy import Greedy
from billiard_shot.game.agents.player import Player
from billiard_shot.game.ideas import Idea, indirect_pots, Position, rate, RatedIdea, safeties
from billiard_shot.game.rack import (
    agent_names,
    ENDS,
    find_agent,
    Pairing,
    play,
    play_on,
    play_rack,
    RackRecord,
    replayed,
    scene_of,
    simulated,
    summary,
)
from billiard_shot.game.state import find_game, outcome_of
from billiard_shot.game.strokes import (
    best_break,
    best_break_of,
    break_racks,
    hit_something,
    placed,
)
from billiard_shot.game.valuation import (
    at_table,
    best_next,
    EQUAL,
    extra_shots,
    HARD,
    next_shots,
    rule_on,
    RuledBatch,
    second_ply,
    SHOT,
    shots_left,
    Skills,
    value,
    values,
    win_probabilities,
)
from billiard_shot.planning.within_noise import noise_of, play_within_noise
from billiard_shot.scene.player import ModelError
from billiard_shot.table.model.motion import NOTHING

TABLE = Scene.load('seven_foot')
EXACT = replace(TABLE, noise=TABLE.noise.times(0.0))
STROKE = Stroke.from_offsets(speed=1.0)


def without_times(record):
    data = record.to_dict()
    for shot in data['shots']:
        del shot['cpu'], shot['wall']
    return data


@pytest.mark.parametrize('game', ['eight_ball', 'nine_ball'])
def test_a_rack_repeats_and_is_kept_as_data(game):
    pairing = Pairing(game, TABLE, ('random', 'random'), seed=2)
    record = play(pairing, 1)
    assert without_times(play(pairing, 1)) == without_times(record)
    assert RackRecord.from_dict(json.loads(json.dumps(record.to_dict()))) == record
    assert record.winner in ('random', None)
    assert {shot.end for shot in record.shots} <= {'', *ENDS} - {'illegal'}
    assert record.state['breaker'] == 1
    assert record.shots[0].state['balls'] != play(pairing, 2).shots[0].state['balls']


def test_a_rack_records_miscues():
    def slips(scene, stroke, errors):
        return replace(simulated(scene, stroke, errors), miscue=True)

    record = play(Pairing('practice', TABLE, ('random',), balls=1, simulator=slips), 0)
    assert record.shots
    assert all(shot.miscue for shot in record.shots)
    assert RackRecord.from_dict(json.loads(json.dumps(record.to_dict()))) == record


def test_two_racks_in_turn_are_alike_but_for_the_breaker():
    pairing = Pairing('nine_ball', TABLE, ('random', 'random'), seed=2)
    one, two = (State.from_dict(play(pairing, n).shots[0].state) for n in (4, 5))
    assert (one.breaker, two.breaker) == (0, 1)
    assert one.object_balls == two.object_balls
    assert all(one.balls[ball] == two.balls[ball] for ball in one.object_balls)


def test_a_rack_is_replayed_with_its_errors():
    record = play(Pairing('nine_ball', TABLE, ('random', 'random'), seed=3), 0)
    shown = list(replayed(record, TABLE))
    assert len(shown) == sum(bool(shot.offsets) for shot in record.shots)
    for played, shot in shown:
        state = State.from_dict(played.state)
        assert judge(state, Call(**played.call), shot).text == played.text


def test_a_rack_of_a_game_that_no_module_has_is_replayed():
    own = replace(find_game('practice'), name='mine')
    record = play(Pairing(own, TABLE, ('greedy',), balls=2), 0)
    record = RackRecord.from_dict(json.loads(json.dumps(record.to_dict())))
    shown = list(replayed(record, TABLE))
    assert len(shown) == len(record.shots)
    for played, shot in shown:
        assert (
            judge(State.from_dict(played.state, own), Call(**played.call), shot).text
            == played.text
        )


class Illegal:
    def __init__(self, **answer):
        self.answer = answer

    def place(self, state):
        return self.answer.get('place', (-0.8, 0.0))

    def decide(self, state):
        call = Call(self.answer.get('ball'))
        return Decision(call=call, choice=self.answer.get('choice', ''))

    def saw(self, state, decision, ruling):
        pass


@pytest.mark.parametrize(
    ('answer', 'end'),
    [
        ({'place': (0.3, 0.0)}, 'illegal'),
        ({'choice': 'pass'}, 'illegal'),
        ({'ball': '99'}, 'illegal'),
        ({}, 'no shot'),
    ],
)
def test_an_illegal_move_loses_the_rack(answer, end):
    state = start('nine_ball', TABLE).to_dict()
    first = RackRecord('nine_ball', 0, 1, ('one', 'two'), (), state)
    record = play_rack(first, TABLE, [Illegal(**answer)] * 2)
    assert record.shots[0].end == end
    assert record.winner == 'two'  # without a shot, by three fouls in a row


@pytest.mark.parametrize(
    ('decision', 'end'),
    [
        (Decision(STROKE, success=0.1), 'safety'),  # nine-ball has no call that says so
        (Decision(STROKE, Call('1', 'foot_left'), success=0.1), 'leave'),
        (Decision(STROKE, Call('1', 'foot_left'), success=0.9), 'miss'),
        (Decision(STROKE), 'miss'),
        (Decision(STROKE, Call(push_out=True)), 'safety'),
    ],
)
def test_a_record_tells_a_defence_from_a_miss(decision, end):
    agent = Illegal()
    agent.decide = lambda state: decision
    state = replace(start('nine_ball', TABLE).with_cue_ball(-0.8, 0.0), phase='second', in_hand='')
    first = RackRecord('nine_ball', 0, 1, ('one', 'two'), (), state.to_dict())
    nothing_falls = lambda *_: Outcome('1', to_cushion={'1'}, places=state.balls)  # noqa: E731
    record = next(play_on(first, TABLE, [agent] * 2, nothing_falls))
    assert record.shots[0].end == end


def test_another_simulator_plays():
    """It knows nothing of strokes: every shot pots the lowest ball."""

    def pots_the_lowest(scene, stroke, errors):
        ball = min((ball for ball in scene.balls if ball != 'cue'), key=int)
        left = {name: place for name, place in scene.balls.items() if name != ball}
        return Outcome(ball, ((ball, 'foot_left'),), places=left)

    pairing = Pairing('nine_ball', TABLE, ('random', 'random'), simulator=pots_the_lowest)
    record = play(pairing, 0)
    assert (record.winner, len(record.shots), record.state['winner']) == ('random', 9, 0)


def test_the_greedy_agent_takes_the_best_chance():
    state = start('practice', TABLE, balls=2)
    near = {'cue': (0.6, 0.2), '1': (0.8, 0.35), '2': (-0.8, -0.1)}
    state = replace(state, balls=near, in_hand='')
    decision = Greedy(EXACT, 1).decide(state)
    assert decision.call == Call(ball='1', pocket='foot_left')
    assert decision.success > 0.99


def test_the_probability_to_win_is_one_of_two_equal_players():
    for shared in (False, True):
        won = win_probabilities(shared, EQUAL)
        for mine in range(1, 9):
            for others in [mine] if shared else range(1, 9):
                down = won[mine - 1, mine - 1 if shared else others]
                missed = 1.0 - won[others, mine]
                expected = SHOT * down + (1.0 - SHOT) * missed
                assert won[mine, others] == pytest.approx(expected, abs=1e-12)
    assert win_probabilities(False, EQUAL)[1, 8] > win_probabilities(False, EQUAL)[8, 8] > 0.5
    for name in ('eight_ball', 'nine_ball', 'practice'):
        left = np.full((11, 2), 4)
        rises = at_table(np.linspace(0.0, 1.0, 11), find_game(name), left, EQUAL)
        assert (np.diff(rises) >= 0.0).all()
        assert 0.0 <= rises[0] < rises[-1] <= 1.0
        assert at_table(np.zeros(1), find_game(name), np.array([[0, 4]]), EQUAL) == 1.0
    assert at_table(np.ones(1), find_game('practice'), np.ones((1, 2), int), EQUAL) == 1.0


@pytest.mark.parametrize('limit', ['seconds', 'time_left'])
def test_with_hardly_any_time_the_player_takes_the_best_direct_shot(limit):
    state = start('nine_ball', TABLE, seed=4, time_limit=1e-6 if limit == 'time_left' else None)
    balls = {'cue': (0.3, 0.25), '1': (0.62, 0.3), '2': (-0.9, 0.05)}
    state = replace(state, balls=balls, in_hand='', phase='play')
    options = 'player:seconds=1e-6' if limit == 'seconds' else 'player'
    hasty = find_agent(options)(TABLE, 1).decide(state)
    assert hasty.stroke == Greedy(TABLE, 1).decide(state).stroke
    assert Player(TABLE, 1).decide(replace(state, time_left=None)).stroke != hasty.stroke


def test_a_planned_stroke_is_not_played_from_another_place():
    state = start('practice', TABLE, seed=4, balls=2)
    player = Player(TABLE, 1)
    x, y = player.place(state)
    elsewhere = (-x, -y) if not state.no_place(-x, -y) else (-x, y)
    there = state.with_cue_ball(*elsewhere)
    decision = player.decide(there)
    shot = predict(replace(TABLE, balls=there.balls), decision.stroke)
    assert shot.pocketed.get(decision.call.ball) == decision.call.pocket


def test_a_poor_shot_from_cue_ball_in_hand_is_thought_over(monkeypatch):
    state = start('practice', TABLE, seed=4, balls=1)
    planned = Player(TABLE, 1)
    there = state.with_cue_ball(*planned.place(state))
    expected = planned.decide(there)
    monkeypatch.setattr('billiard_shot.game.agents.player.POOR', 2.0)
    again = Player(TABLE, 1)
    assert state.with_cue_ball(*again.place(state)) == there
    assert again.decide(there) != expected


def test_the_place_and_the_stroke_share_the_time(monkeypatch):
    """By a clock on which a second passes with each look, and with shots that are all poor."""
    clock = count()
    module = 'billiard_shot.game.agents.player'
    monkeypatch.setattr(f'{module}.perf_counter', lambda: float(next(clock)))
    monkeypatch.setattr(f'{module}.POOR', 2.0)
    state = start('practice', TABLE, seed=4, balls=2)
    player = Player(TABLE, 1, seconds=9.0, effort=0.3)
    assert player.decide(state.with_cue_ball(*player.place(state))).stroke
    assert next(clock) <= 9 + 2  # the look after the place is one, and this is another


def test_after_a_push_out_the_other_player_takes_the_better_part():
    state = start('nine_ball', TABLE, seed=4).with_cue_ball(-0.8, 0.0)
    pushed = replace(state, player=1, phase='play', in_hand='', choices=('accept', 'pass'))
    chance = np.linspace(0.0, 1.0, 11)
    left = np.full((11, 2), 9)
    own = at_table(chance, find_game('nine_ball'), left, EQUAL)
    assert value(pushed, 0, chance, left, EQUAL) == pytest.approx(np.minimum(own, 1.0 - own))
    assert value(pushed, 1, chance, left, EQUAL) == pytest.approx(np.maximum(own, 1.0 - own))


def test_a_scratch_that_restores_the_table_leaves_it_to_the_other_player():
    """The 1 falls, and the cue ball after it; both go back, and nobody has the ball in hand."""
    eight_ball = find_game('eight_ball')

    def rule(state, call, outcome):
        ruling = eight_ball.rule(state, call, outcome)
        return replace(ruling, state=replace(ruling.state, in_hand=''), restore=not ruling.legal)

    balls = {'cue': (0.6, 0.1), '1': (0.8, 0.3), '8': (-0.6, 0.2), '9': (0.2, -0.3)}
    state = replace(
        start('eight_ball', TABLE),
        game=replace(eight_ball, rule=rule),
        balls=balls,
        in_hand='',
        phase='play',
        groups=('solids', 'stripes'),
    )
    follow = [[0.0, 0.4, 0.1, np.pi / 4, speed] for speed in (1.5, 2.0)]
    played = predict_batch(replace(TABLE, balls=balls), offsets=follow)
    assert played.pocketed == 2 * ({'1': 'foot_left', 'cue': 'foot_left'},)
    calls = [Call(ball='1', pocket='foot_left')] * 2
    scratched = rule_on(state, calls, played)
    same = RuledBatch((Ruling(replace(state, player=1)),), np.zeros(1, int), placed(state))
    expected = 1.0 - values(TABLE, 1, same, EQUAL)
    assert 0.0 < expected < 1.0
    assert values(TABLE, 0, scratched, EQUAL) == pytest.approx(np.repeat(expected, 2), abs=1e-12)


def test_without_a_direct_shot_a_combination_is_found():
    """The 1 lies between the cue ball and the 9, which lies before the pocket."""
    state = start('nine_ball', TABLE)
    balls = {'cue': (0.3, 0.0), '1': (0.6, 0.2), '9': (0.84, 0.36)}
    state = replace(state, balls=balls, in_hand='', phase='play')
    ideas = indirect_pots(Position(state, scene_of(TABLE, state)))
    assert max(ideas, key=lambda idea: idea.guess).call == Call(ball='9', pocket='foot_left')


def test_the_better_the_other_player_the_less_a_rack_is_worth():
    chances, left = np.linspace(0.0, 1.0, 11), np.full((11, 2), 4)
    worth = np.ones(11)
    for other in (0.3, 0.5, 0.9, 0.99):
        skills = Skills(SHOT, other)
        won = win_probabilities(False, skills)
        lost = 1.0 - win_probabilities(False, skills.swapped)
        for mine, others in ((1, 1), (3, 7), (8, 2)):
            goes_on = SHOT * won[mine - 1, others] + (1.0 - SHOT) * lost[others, mine]
            assert won[mine, others] == pytest.approx(goes_on, abs=1e-12)
        less = at_table(chances, find_game('eight_ball'), left, skills)
        assert (less < worth).all()
        worth = less
    balls = {'cue': (-0.9, 0.0), '1': (0.9, 0.1), '8': (0.9, -0.4), '9': (0.2, 0.0)}
    state = replace(start('eight_ball', TABLE), balls=balls, in_hand='', phase='play')
    state = replace(state, groups=('solids', 'stripes'))
    sure = [
        find_agent(f'player:effort=0.1,plies=1,opponent={other}')(TABLE, 1).options(state)[0].value
        for other in (0.5, 0.99)
    ]
    assert sure[0] > sure[1]
    with pytest.raises(ValueError, match='opponent must be 0 to 1'):
        find_agent('player:opponent=1.5')(TABLE, 1)


def test_a_safety_is_played_only_with_two_players_and_if_allowed():
    """The 8 lies at the far cushion, behind balls of the other player."""
    balls = {'cue': (-0.9, 0.0), '8': (0.9, 0.0), '1': (0.84, 0.0), '3': (0.9, 0.06)}
    state = replace(
        start('eight_ball', TABLE),
        balls=balls | {'4': (0.9, -0.06)},
        groups=('stripes', 'solids'),
        in_hand='',
        phase='play',
    )
    assert find_agent('player:effort=0.3')(TABLE, 1).decide(state).call.safety
    assert not find_agent('player:effort=0.3,safe=false')(TABLE, 1).decide(state).call.safety
    alone = replace(state, game=find_game('eight_ball_ghost'))
    assert not find_agent('player:effort=0.3')(TABLE, 1).decide(alone).call.safety
    assert not hit_something(scene_of(TABLE, alone), alone).call.safety


@pytest.mark.parametrize(
    ('game', 'success', 'end'),
    [('nine_ball', 0.0, 'safety'), ('eight_ball', None, 'safety'), ('practice', 0.0, 'leave')],
)
def test_a_stroke_for_want_of_a_direct_shot_is_no_miss(game, success, end):
    """All balls lie at the middle of the foot cushion, straight ahead of the cue ball."""
    names = ('1', '2', '9')
    balls = {'cue': (-0.9, 0.0)} | {ball: (0.96, 0.06 * i) for i, ball in enumerate(names, -1)}
    state = replace(start(game, TABLE), balls=balls, phase='play', in_hand='')
    agent = Greedy(TABLE, 1)
    decision = agent.decide(state)
    assert (decision.reason, decision.success) == ('no direct shot', success)
    first = RackRecord(game, 0, 1, ('one', 'two')[: state.game.players], (), state.to_dict())
    nothing_falls = lambda *_: Outcome('1', to_cushion={'1'}, places=balls)  # noqa: E731
    assert next(play_on(first, TABLE, [agent] * 2, nothing_falls)).shots[0].end == end


@pytest.mark.slow
@pytest.mark.parametrize(('game', 'kept'), [('eight_ball', 0.75), ('nine_ball', 0.85)])
def test_breaks_pot_a_ball_and_do_not_scratch(game, kept):
    place, stroke = best_break(TABLE, game)
    assert start(game, TABLE).no_place(*place) == ''
    batch = break_racks(TABLE, game, np.array([[*place, *stroke.offsets]]), range(1000, 1200))
    assert batch.keeps(0).mean() >= kept


def test_a_break_from_a_cue_ball_that_is_placed():
    """At the side, where the player would not place it: it hits the rack at full speed."""
    state = replace(start('eight_ball', TABLE, 5).with_cue_ball(-0.7, 0.3), in_hand='')
    stroke = best_break_of(TABLE, state)
    shot = predict(scene_of(TABLE, state), stroke)
    assert stroke.speed == TABLE.robot.speed_max
    assert len(outcome_of(shot).to_cushion) >= 4


def test_options_are_the_best_decisions_with_their_values():
    state = replace(start('practice', TABLE, balls=3), in_hand='')
    state = replace(state, balls={**state.balls, 'cue': (-0.8, 0.35)})
    options = Player(TABLE, 1, effort=0.3).options(state, 3)
    assert options[0].decision == Player(TABLE, 1, effort=0.3).decide(state)
    assert len(options) == 3
    assert all(each.place == state.balls['cue'] for each in options)
    with pytest.raises(ValueError, match='n must be a whole number'):
        Player(TABLE, 1).options(state, 0)


def test_safeties_are_called_only_in_games_with_calls():
    for game, calls in (('eight_ball', True), ('nine_ball', False)):
        state = replace(start(game, TABLE), phase='play', in_hand='')
        state = replace(state, balls={**state.balls, 'cue': (-0.8, 0.1)})
        some = safeties(Position(state, scene_of(TABLE, state)))
        assert some
        assert all(idea.call.safety is calls for idea in some)


def touching_pot(balls):
    """Chance of a combination of two touching balls, if places are known so well [m]."""
    noise = replace(TABLE.noise, azimuth_deg=0.02, balls=balls)
    half, r = 0.5 * TABLE.table.length, TABLE.ball.radius
    way = np.array([half, -0.5 * TABLE.table.width]) / np.hypot(half, 0.5 * TABLE.table.width)
    first = 0.3 * np.array([half, -0.5 * TABLE.table.width])
    places = {'cue': first - 0.3 * way, '1': first, '2': first + 2.0 * r * way}
    scene = replace(TABLE, noise=noise, balls={k: tuple(v.tolist()) for k, v in places.items()})
    state = replace(start('practice', TABLE, balls=2), balls=scene.balls, in_hand='')
    offsets = np.array([0.0, 0.0, 0.02, float(np.arctan2(way[1], way[0])), 2.0])
    idea = Idea(Position(state, scene), offsets, Call('2', 'foot_right'), 1.0)
    draw = np.random.default_rng(2)
    errors = draw.standard_normal((60, 5)) * noise.sigmas(r)
    return rate([idea], errors, 0, draw)[0].success


def test_what_a_cluster_does_is_uncertain_if_places_are():
    assert touching_pot(0.0) > 0.8
    assert touching_pot(2e-3) < 0.7


def test_errors_of_the_scene_count_beside_those_of_the_player():
    scene = replace(TABLE, model_error=ModelError(azimuth_deg=0.3, speed=0.1, balls=1e-3))
    noise = scene.planned_noise
    assert noise.azimuth_deg == pytest.approx(np.hypot(0.125, 0.3))
    assert (noise.a, noise.balls) == (TABLE.noise.a, 1e-3)
    assert TABLE.planned_noise == TABLE.noise
    assert noise_of(scene, 'none').speed == 0.1
    state = replace(start('practice', TABLE, balls=1), in_hand='')
    state = replace(state, balls={'cue': (-0.5, 0.2), '1': (0.3, -0.1)})
    sure, unsure = (Player(each, 1, effort=0.3).decide(state) for each in (TABLE, scene))
    assert unsure.success < sure.success - 0.1


def test_a_break_without_room_for_the_cue_is_a_foul():
    """The cue ball lies 5 mm from the cushion behind it, under the stroke."""
    exact = replace(TABLE, noise=TABLE.noise.times(0.0))
    x = -0.5 * TABLE.table.length + TABLE.ball.radius + 0.005
    breaks = [(x, 0.0, 0.0, 0.2, elevation, 0.0, 6.0) for elevation in (0.01, 0.3)]
    batch = break_racks(exact, 'eight_ball', np.array(breaks), range(2))
    said = [batch.kinds[kind].text for kind in batch.kind]
    assert ['cannot be played' in text for text in said] == [True, True, False, False]


def test_the_player_leaves_the_next_ball():
    """Straight stun would leave no direct shot at 2; draw or follow does."""
    state = start('practice', TABLE, balls=2)
    balls = {'cue': (0.3, 0.25), '1': (0.62, 0.36), '2': (-0.9, 0.05)}
    state = replace(state, balls=balls, in_hand='')
    player = Player(TABLE, 1)
    decision = player.decide(state)
    assert decision.success > 0.8
    assert decision.reason.startswith(f'{decision.call.ball} to ')
    again = Player(TABLE, 1).decide(state)
    assert again == decision


def test_a_miscue_counts_as_lost_although_it_is_legal():
    state = start('practice', TABLE, balls=1)
    state = replace(state, balls={'cue': (0.5, 0.2), '1': (0.9, 0.4)}, in_hand='')
    offsets = np.tile((0.0, 0.0, 0.0, np.arctan2(0.2, 0.4), 2.0), (17, 1))
    offsets[:, 1] = np.linspace(-0.8, 0.8, 17)
    run = predict_batch(scene_of(TABLE, state), offsets=offsets)
    batch = rule_on(state, [Call('1', 'foot_left')] * 17, run)
    assert 0 < run.miscue.sum() < 10
    assert not values(TABLE, 0, batch, EQUAL)[run.miscue].any()
    assert not batch.keeps(0)[run.miscue].any()
    legal = np.array([ruling.legal for ruling in batch.kinds])[batch.kind]
    assert legal[run.miscue].any()
    assert values(TABLE, 0, batch, EQUAL)[legal & ~run.miscue].any()


def test_no_stroke_of_the_player_is_a_miscue():
    """Among wide errors strokes with much draw looked best, although every other one slips."""
    table, draw = Scene.load('robot_table'), np.random.default_rng(2)
    half = 0.5 * np.array([table.table.length, table.table.width]) - 0.06
    slipped = []
    for number in range(5):
        while True:
            places = draw.uniform(-half, half, (4, 2))
            apart = np.hypot(*(places[:, np.newaxis] - places).T)
            if apart[np.triu_indices(4, 1)].min() > 0.07:
                break
        balls = dict(zip(('cue', '1', '4', '9'), map(tuple, places.tolist()), strict=True))
        state = replace(start('nine_ball', table), balls=balls, phase='play', in_hand='')
        stroke = Player(table, number, effort=0.2).decide(state).stroke
        slipped.append(predict(scene_of(table, state), stroke).miscue)
    assert not any(slipped)


@pytest.mark.slow
def test_the_player_clears_tables():
    players = [play(Pairing('practice', TABLE, ('player',), 5, balls=3), n) for n in range(4)]
    assert all(record.winner == 'player' for record in players)
    result = summary(('player',), players)['players'][0]
    assert result['ends'].get('illegal', 0) == 0
    assert result['shots'] <= 12


def test_a_tournament_is_resumed(tmp_path, capsys):
    file = str(tmp_path / 'racks.jsonl')
    words = ['tournament', 'nine_ball', '--scene', 'seven_foot', '--players', 'random', 'random']
    words += ['--json', '--workers', '1', '-o', file]
    assert main([*words, '--racks', '2']) == 0
    capsys.readouterr()
    assert main([*words, '--racks', '3']) == 0
    resumed = json.loads(capsys.readouterr().out)
    assert main([*words[:-2], '--racks', '3']) == 0
    at_once = json.loads(capsys.readouterr().out)
    for result in (resumed, at_once):
        for player in result['players']:
            del player['cpu'], player['wall']
    assert resumed == at_once
    assert at_once['racks'] == 3
    assert main([*words, '--seed', '9', '--racks', '3']) == 2
    assert 'of game, players and seed' in capsys.readouterr().err


def test_each_player_may_have_noise_of_its_own():
    """Of one without errors, strokes are played as planned; also when the rack is replayed."""
    record = play(Pairing('nine_ball', TABLE, ('greedy@none', 'greedy@fargo_400')), 0)
    for played, shot in replayed(record, TABLE):
        exact = shot.stroke.offsets == pytest.approx(played.offsets, abs=1e-9)
        assert exact == (played.state['player'] == 0)
    assert {shot.state['player'] for shot in record.shots} == {0, 1}


def test_unknown_players_are_refused(capsys):
    assert agent_names() == ['greedy', 'player', 'random']
    with pytest.raises(ValueError, match='greedy, player, random'):
        find_agent('best')
    with pytest.raises(ValueError, match=r"must be one of effort, .*, opponent, got 'skill'"):
        find_agent('player:skill=9')
    with pytest.raises(ValueError, match=r"effort must be a number, true or false, got 'much'"):
        find_agent('player:effort=much')
    with pytest.raises(ValueError, match=r'noise of .* must be one of .*, got .*is fargo_500'):
        find_agent('player@fargo_555')
    with pytest.raises(ValueError, match=r'plies must be .*, got 3'):
        find_agent('player:plies=3')(TABLE, 1)
    assert main(['tournament', 'practice', '--players', 'best', '--racks', '1']) == 2
    assert ", got 'best'" in capsys.readouterr().err


def test_a_player_whose_make_takes_no_scene_is_refused(tmp_path, monkeypatch, capsys):
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'bare.py').write_text('def make():\n    return None\n')
    monkeypatch.syspath_prepend(tmp_path)
    assert main(['play', 'practice', '--players', 'mine.bare']) == 2
    assert "make of player 'mine.bare' must be a function of a scene and a seed" in (
        capsys.readouterr().err
    )


def test_touching_balls_get_fewer_trials_because_their_strokes_take_long(monkeypatch):
    trials = []

    def rate(ideas, errors, plies, draw):
        trials[-1] += len(ideas) * len(errors)
        return [RatedIdea(idea, 0.5, 0.5) for idea in ideas]

    def safeties(position):
        stroke = np.array([0.0, 0.0, 0.1, 0.0, 1.0])
        return [Idea(position, stroke, Call(safety=True), 0.5)] * 20

    monkeypatch.setattr(player_module, 'rate', rate)
    monkeypatch.setattr(player_module, 'safeties', safeties)
    monkeypatch.setattr(player_module, 'indirect_pots', lambda position: [])
    racked = start('eight_ball', TABLE).with_cue_ball(-0.6, 0.1)
    racked = replace(racked, phase='play', in_hand='')
    apart = {ball: (x, 1.2 * y) for ball, (x, y) in racked.balls.items()}
    for state in (racked, replace(racked, balls=apart)):
        trials.append(0)
        Player(TABLE, 1).decide(state)
    assert 0 < trials[0] < 0.3 * trials[1]


# --- the second ply tells end states apart that the next shot alone does not ---------------------

NINE_FOOT = Scene.load('pool_table')


def end_states(*rows, game='practice', **given):
    """Several places of a few balls that are left, by default two in practice."""
    state = replace(start(game, NINE_FOOT), phase='play', **given)
    states = [replace(state, balls=balls, in_hand='', shots=1) for balls in rows]
    tables = placed(states[0])
    many = tables.take(np.zeros(len(rows), int))
    for i, each in enumerate(states):
        many.position[i, :, :2] = [each.balls[name] for name in many.names]
    return RuledBatch((Ruling(states[0]),), np.zeros(len(rows), int), many)


def test_a_second_ball_that_can_be_reached_is_worth_more():
    near = {'cue': (0.7, 0.35), '1': (0.95, 0.475)}
    easy = near | {'2': (0.9, -0.45)}  # beside the other corner
    hard = near | {'2': (-1.2, 0.0)}  # frozen to the middle of the far cushion
    batch = end_states(easy, hard)
    first = values(NINE_FOOT, 0, batch, EQUAL)
    assert first[0] == pytest.approx(first[1], abs=0.01)
    second = second_ply(NINE_FOOT, 0, batch, first, EQUAL)
    assert second[0] > second[1] + 0.1


def test_without_a_shot_the_first_value_stays():
    blocked = {'cue': (0.0, 0.0), '1': (1.2, 0.0), '2': (1.2, 0.1)}
    batch = end_states(blocked)
    first = np.array([0.123])
    assert second_ply(NINE_FOOT, 1, batch, first, EQUAL).tolist() == [
        0.123
    ]  # it is not this player's turn


def test_the_last_two_balls_are_won_by_two_pots():
    last = {'cue': (0.7, 0.35), '1': (0.95, 0.475), '2': (0.9, -0.45)}
    batch = end_states(last)
    assert second_ply(NINE_FOOT, 0, batch, values(NINE_FOOT, 0, batch, EQUAL), EQUAL)[0] > 0.9


def test_a_stroke_whose_cue_hits_the_cue_ball_again_does_not_count(monkeypatch):
    """As most strokes do that pot a ball 2 mm in front of the cue ball."""
    played = []

    def play(*arguments):
        played.append(play_within_noise(*arguments))
        rows = played[-1].played
        tables = rows.tables.copy()
        tables['double_hit'] = True
        return replace(played[-1], played=rows._replace(tables=tables))

    ball, way = np.array([0.9, 0.45]), np.array([2.0, 1.0]) / 5.0**0.5
    place = ball - way * (2.0 * NINE_FOOT.ball.radius + 0.002)
    batch = end_states({'cue': tuple(place), '1': tuple(ball), '2': (0.9, -0.45)})
    first = values(NINE_FOOT, 0, batch, EQUAL)
    monkeypatch.setattr('billiard_shot.game.valuation.play_within_noise', play)
    assert first[0] > 0.5
    assert second_ply(NINE_FOOT, 0, batch, first, EQUAL).tolist() == [0.0]
    potted = played[0].pocket[:, 1] != NOTHING
    assert played[0].double_hit[potted].mean() > 0.5


def test_a_rack_is_won_by_the_last_ball_and_the_8():
    """The 8 counted as a ball that is needed after it had fallen."""
    last = {'cue': (0.7, 0.35), '1': (0.95, 0.475), '8': (0.9, -0.45)}
    groups = 'solids', 'stripes'
    batch = end_states(last | {'9': (-0.9, 0.0)}, game='eight_ball', groups=groups)
    assert second_ply(NINE_FOOT, 0, batch, values(NINE_FOOT, 0, batch, EQUAL), EQUAL)[0] > 0.9
    on_8 = end_states({'cue': (0.7, -0.35), '8': (0.9, -0.45)}, game='eight_ball', groups=groups)
    assert second_ply(NINE_FOOT, 0, on_8, values(NINE_FOOT, 0, on_8, EQUAL), EQUAL)[0] > 0.9


def needed_shots(batch):
    """Shots that the players need, of the first table."""
    given = batch.after, batch.kind, batch.states
    return shots_left(*given, extra_shots(NINE_FOOT, *given))[0].tolist()


def test_a_ball_that_is_hard_to_pot_takes_more_shots():
    free = {'cue': (-0.5, 0.0), '1': (0.6, 0.3), '8': (0.3, -0.2), '9': (-0.9, 0.2)}
    beside = {'10': (1.2414, 0.06), '11': (1.2414, -0.06)}
    theirs, both = (free | beside | {ball: (1.2414, 0.0)} for ball in ('9', '8'))
    states = [
        end_states(balls, game='eight_ball', groups=('solids', 'stripes'))
        for balls in (free, theirs, both)
    ]
    hard = HARD[0][1]
    # no ball of the row goes along the cushion: the others are where the cue ball has to be
    left = [[2, 2], [2, 4 + 3 * hard], [2 + hard, 4 + 3 * hard]]
    assert [needed_shots(each) for each in states] == left
    names, places = states[-1].states.names, states[-1].states.position
    places[:, names.index('8'), :2] = 0.3, -0.2  # a shot drives it out of the row
    assert needed_shots(states[-1]) == [2, 4 + 2 * hard]
    states[-1].states.present[:, names.index('10')] = False
    assert needed_shots(states[-1])[1] == 3 + hard


def test_a_hard_ball_that_can_be_potted_now_costs_one_shot():
    balls = {'cue': (0.0, 0.0), '1': (0.9, 0.45), '3': (0.6, -0.35), '8': (-0.9, 0.2)}
    batch = end_states(balls, game='eight_ball', groups=('solids', 'stripes'))
    given = batch.after, batch.kind, batch.states
    direct = next_shots(NINE_FOOT, batch, [True])
    extra = np.zeros((1, len(direct.names)), int)
    left = shots_left(*given, extra)
    chance, same = best_next(direct, left, extra)
    assert chance == direct.best
    assert same.tolist() == left.tolist() == [[3, 1]]
    worst = direct.ball[np.argmin(direct.chance)]
    extra[0, worst] = 4
    left = shots_left(*given, extra)
    chance, fewer = best_next(direct, left, extra)
    assert chance == direct.chance[direct.ball == worst].max()
    assert fewer.tolist() == [[3, 1]]
