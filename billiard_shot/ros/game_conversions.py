"""Conversions between messages of games and the library: pure functions."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from billiard_shot_msgs.msg import BallState, GameState
from geometry_msgs.msg import Point
import numpy as np

from billiard_shot.game.game import find_game
from billiard_shot.game.state import State
from billiard_shot.ros.conversions import filled, sightings_of
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused
from billiard_shot.scene.placement import CUE_BALL

# Fields of a state that the message does not have.
OF_THE_TABLE = ('length', 'width', 'radius', 'balls', 'time_left')
NOBODY = -1


def state_of(message: GameState, balls: Mapping[str, tuple[float, float]], scene: Scene) -> State:
    """
    Read the state of a game on the table of a scene, with the balls at their places (x, y) [m].

    A cue ball in hand is not on the table, wherever it lies. ValueError names all mistakes.
    """
    if scene.table is None:
        raise ValueError('scene: a game needs a table')
    values = _shared(message)
    for name in ('choices', 'groups', 'fouls', 'scores'):
        values[name] = tuple(np.asarray(values[name]).tolist())
    values['phase'] = message.phase or 'play'
    values['winner'] = None if message.winner == NOBODY else message.winner
    values['balls'] = {
        name: place for name, place in balls.items() if name != CUE_BALL or not message.in_hand
    }
    if not (CUE_BALL in values['balls'] or message.in_hand or message.choices or message.over):
        raise refused(sorted(balls), f'with {CUE_BALL!r}, which is not in hand', 'balls')
    if message.winner != NOBODY and not message.over:
        raise refused(message.winner, f'{NOBODY} while the rack is not over', 'winner')
    decisive = find_game(message.game).decisive
    if not (message.over or message.choices or decisive in ('', *balls)):
        raise refused(sorted(balls), f'with {decisive!r} while the rack is not over', 'balls')
    values['length'], values['width'] = scene.table.length, scene.table.width
    values['radius'] = scene.ball.radius
    return State(**values)


def game_state_message(state: State) -> GameState:
    """Message of the state of a game."""
    values = _shared(state)
    values['game'] = state.game.name
    values['winner'] = NOBODY if state.winner is None else state.winner
    return GameState(**{**values, 'choices': list(state.choices), 'groups': list(state.groups)})


def _shared(record: State | GameState) -> dict[str, Any]:
    """Fields that a state and its message have in common."""
    names = (each.name for each in fields(State) if each.name not in OF_THE_TABLE)
    return {name: getattr(record, name) for name in names}


def balls_message(balls: Mapping[str, tuple[float, float]]) -> list[BallState]:
    """Message of balls at rest at their places (x, y) [m]."""
    return [BallState(id=name, position=filled(Point, place)) for name, place in balls.items()]


def places_of(balls: Sequence[BallState]) -> dict[str, tuple[float, float]]:
    """Read the places (x, y) [m] of balls; ValueError for balls that cannot be."""
    return {name: ball.position for name, ball in sightings_of(balls).items()}
