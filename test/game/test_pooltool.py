"""pooltool as a simulator: conventions both ways, the same strokes, and games."""

from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.game import Decision, judge, Pairing, play
from billiard_shot.planning.within_noise import NOISES

pytest.importorskip('pooltool', reason='needs the extra pooltool, in an environment of its own')
import pooltool as pt
from pooltool.physics.resolve.ball_cushion.han_2005 import (
    Han2005Circular,
    Han2005Linear,
)
from pooltool.physics.resolve.resolver import default_resolver

from billiard_shot.game.pooltool import (
    Ai,
    balls_of,
    here,
    outcome_of_system,
    POCKETS,
    Pooltool,
    pooltool_action,
    state_of_system,
    stroke_of_action,
    there,
)

NONE = np.random.default_rng(0)


def pooltool(*, han=False):
    resolver = default_resolver()
    if han:
        resolver.ball_linear_cushion = Han2005Linear()
        resolver.ball_circular_cushion = Han2005Circular()
    return Pooltool(engine=pt.physics.PhysicsEngine(resolver))


def exact(table):
    return replace(table.scene, noise=NOISES['none'])


def test_places_and_strokes_are_the_same_both_ways():
    table = pt.Table.default()
    for place in ((0.3, -0.2), (-0.9, 0.4)):
        assert here(table, np.array(there(table, place))) == pytest.approx(place)
    stroke = Stroke.from_offsets(0.2, -0.1, 0.05, -2.0, 1.5)
    assert stroke_of_action(pooltool_action(stroke)).offsets == pytest.approx(stroke.offsets)
    # to the foot, with right side: pooltool counts its angle from across, and its side to the left
    action = pooltool_action(Stroke.from_offsets(0.2, 0.1, 0.0, 0.0, 1.0))
    assert (action.phi, action.a, action.b) == pytest.approx((90.0, -0.2, 0.1))


@pytest.mark.parametrize('pocket', POCKETS.values())
def test_balls_fall_into_the_pockets_of_the_same_names(pocket):
    table = pooltool()
    scene = exact(table)
    ends = {'foot': 1.0, 'head': -1.0, 'side': 0.0}
    end, side = pocket.split('_')
    x = ends[end] * 0.5 * scene.table.length
    y = (1.0 if side == 'left' else -1.0) * 0.5 * scene.table.width
    scene = replace(scene, balls={'cue': (0.7 * x, 0.7 * y)})
    stroke = Stroke.from_offsets(0.0, 0.0, 0.0, math.atan2(y, x), 1.0)
    outcome = table.foreign(scene, stroke, NONE)
    assert outcome.pocketed == (('cue', pocket),)
    assert predict(scene, stroke).pocketed == dict(outcome.pocketed)


@pytest.mark.parametrize('han', [False, True])
def test_the_same_strokes_lead_to_the_same_places(han):
    """Strokes with side and height at balls and cushions, by the scene of the table alone."""
    table = pooltool(han=han)
    scene, draw = exact(table), np.random.default_rng(2)
    errors = []
    for _ in range(12):
        balls = {'cue': (-0.5, draw.uniform(-0.3, 0.3)), '1': (0.3, draw.uniform(-0.3, 0.3))}
        way = np.subtract(balls['1'], balls['cue'])
        azimuth = math.atan2(way[1], way[0]) + draw.uniform(-0.04, 0.04)
        a, b = draw.uniform(-0.25, 0.25, 2)
        stroke = Stroke.from_offsets(a, b, 0.0, azimuth, draw.uniform(0.5, 2.0))
        lying = replace(scene, balls=balls)
        outcome, shot = table.foreign(lying, stroke, NONE), predict(lying, stroke)
        ends = shot.run.places_left
        errors += [math.dist(ends[n], at) for n, at in outcome.places.items() if n in ends]
    assert np.median(errors) < 0.03


def test_outcomes_tell_what_rules_ask():
    table = pooltool()
    scene = replace(exact(table), balls={'cue': (0.2, 0.0), '1': (0.7, 0.0), '2': (-0.5, 0.1)})
    system = table.play(scene, Stroke.from_offsets(0.0, 0.0, 0.0, math.pi, 2.0), NONE)
    outcome = outcome_of_system(system)
    assert outcome.first_contact == outcome.met[0]
    assert outcome.cushions_before[0] >= 1
    assert outcome.from_kitchen is False
    assert set(outcome.places) == set(balls_of(system)) == set(scene.balls)


def test_a_rack_is_played_with_a_game_that_is_an_object(monkeypatch):
    monkeypatch.syspath_prepend('docs/examples')
    from restored import GAME

    table = pooltool()
    pairing = Pairing(GAME, table.scene, ('random', 'random'), seed=2, simulator=table.foreign)
    record = play(pairing, 0)
    assert len(record.shots) > 2
    assert record.game == 'restored'


class Straight:
    def __init__(self, scene, seed):
        pass

    def place(self, state):
        return -0.6, 0.0

    def decide(self, state):
        return Decision(Stroke.from_offsets(0.0, 0.1, 0.0, 0.0, 6.0))


@pytest.mark.parametrize('game', ['eight_ball', 'nine_ball'])
def test_an_agent_breaks_as_a_player_of_pooltool(game):
    kind = {'eight_ball': pt.GameType.EIGHTBALL, 'nine_ball': pt.GameType.NINEBALL}[game]
    table = Pooltool()
    rules = pt.get_ruleset(kind)([pt.Player('one'), pt.Player('two')])
    balls = pt.get_rack(kind, table.table)
    system = pt.System(cue=pt.Cue(cue_ball_id='cue'), table=table.table.copy(), balls=balls)
    state = state_of_system(system, rules)
    assert (state.phase, state.in_hand, state.places_cue_ball) == ('break', 'kitchen', True)
    ai = Ai(table.scene, Straight)
    ai.apply(system, ai.decide(system, rules))
    assert (system.cue.V0, system.cue.phi) == (6.0, 90.0)
    pt.simulate(system, engine=table.engine, inplace=True)
    placed = replace(state.with_cue_ball(-0.6, 0.0), in_hand='kitchen')
    ruling = judge(placed, shot=outcome_of_system(system))
    rules.process_and_advance(system)
    assert state_of_system(system, rules).player == ruling.state.player


def test_the_scene_is_a_scene():
    scene = pooltool().scene
    assert Scene.from_dict(scene.to_dict()) == scene
    assert scene.table.cushion.model == 'stronge'
    assert pooltool(han=True).scene.table.cushion.model == 'han'
