"""Tournaments: many racks between two players, or of one, with the same errors for all."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from inspect import signature
import json
from typing import Any

import numpy as np

from billiard_shot.game.agent import Agent, MakeAgent, simulated, Simulator
from billiard_shot.game.game import find_game
from billiard_shot.game.plugins import find_plugin, names_in
from billiard_shot.game.rack import play_rack
from billiard_shot.game.rack_record import RackRecord
from billiard_shot.game.racking import start
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be_one_of, refused


def agent_names() -> list[str]:
    """Names of the agents of the package, in alphabetical order."""
    return names_in('agents')


def find_agent(name: str) -> MakeAgent:
    """
    Return what makes an agent.

    Parameters
    ----------
    name : str
        One of `agent_names`; or `package.module`, a module of your own with a function `make`.
        Options for `make` may follow, such as `player:effort=0.5,plies=1`.

    Raises
    ------
    ValueError
        If there is no such agent.

    """
    module, _, words = name.partition(':')
    make: MakeAgent = find_plugin(module, 'agents', 'make', 'player')
    try:
        signature(make).bind(None, 0)
    except (TypeError, ValueError):
        raise refused(
            make, 'a function of a scene and a seed', f'make of player {module!r}'
        ) from None
    return partial(make, **dict(_option(make, name, word) for word in words.split(',') if word))


def _option(make: MakeAgent, name: str, word: str) -> tuple[str, Any]:
    """Read an option of an agent."""
    option, _, value = word.partition('=')
    known = [
        each.name for each in signature(make).parameters.values() if each.kind == each.KEYWORD_ONLY
    ]
    where = f'option of player {name.partition(":")[0]!r}'
    if option not in known:
        if not known:
            raise refused(option, 'left out', where)
        raise ValueError(f'{where} {must_be_one_of(known, option)}')
    try:
        return option, json.loads(value)
    except ValueError:
        raise refused(value, 'a number, true or false', f'{where}: {option}') from None


@dataclass(frozen=True, slots=True)
class Pairing:
    """
    What is played.

    Parameters
    ----------
    game : str
    scene : Scene
        Table, noise and limits, for simulator and players.
    players : tuple of str
        Two names; one for a game of one player.
    seed : int
        Of racks, errors and players.
    balls : int, optional
        How many balls are racked, see `start`.
    simulator : Simulator

    """

    game: str
    scene: Scene
    players: tuple[str, ...]
    seed: int = 1
    balls: int | None = None
    simulator: Simulator = simulated


def play(pairing: Pairing, number: int) -> RackRecord:
    """
    Play one rack of a pairing; players take turns to break, and two racks in turn are alike.

    The same pairing and number give the same rack in any process.
    """
    record, agents = first_record(pairing, number), agents_of(pairing, number)
    return play_rack(record, pairing.scene, agents, pairing.simulator)


def first_record(pairing: Pairing, number: int) -> RackRecord:
    """Rack the balls of a rack, and return its record without shots."""
    players = pairing.players
    breaker = number % 2 if len(players) > 1 else 0
    rack = pairing.seed + number // 2 if len(players) > 1 else pairing.seed + number
    state = start(pairing.game, pairing.scene, rack, breaker, pairing.balls)
    return RackRecord(pairing.game, number, pairing.seed, players, (), state.to_dict())


def agents_of(pairing: Pairing, number: int) -> list[Agent]:
    """Make the players of a rack."""
    return [
        find_agent(name)(pairing.scene, pairing.seed + 7919 * number + i)
        for i, name in enumerate(pairing.players)
    ]


def check_pairing(pairing: Pairing) -> None:
    """Raise ValueError for players that are not there, or too many or few of them."""
    needed = find_game(pairing.game).players
    if len(pairing.players) != needed:
        raise refused(len(pairing.players), f'{needed} for {pairing.game}', 'players')
    for name in pairing.players:
        find_agent(name)
    start(pairing.game, pairing.scene, balls=pairing.balls)


def play_racks(
    pairing: Pairing, numbers: Sequence[int], executor: Executor | None = None
) -> Iterable[RackRecord]:
    """Play racks in this process or with an executor, and yield their records in order."""
    check_pairing(pairing)
    work: Callable[[int], RackRecord] = partial(play, pairing)
    yield from map(work, numbers) if executor is None else executor.map(work, numbers)


def summary(players: Sequence[str], racks: Sequence[RackRecord]) -> dict[str, Any]:
    """
    Summarize racks: wins, breaks, run-outs, how visits ended, and times, by player.

    Returns
    -------
    dict
        `racks`, `without_winner`, and for each player `wins`, `interval` (Wilson 95 %), `broken`,
        `break_and_run`, `shots`, `ends`, and `cpu` and `wall` (median, 95 %, largest) [s] of
        decisions with a stroke.

    """
    result: dict[str, Any] = {
        'racks': len(racks),
        'without_winner': sum(rack.winner is None for rack in racks),
        'players': [],
    }
    for number, name in enumerate(players):
        own = [
            (rack, [shot for shot in rack.shots if shot.state['player'] == number])
            for rack in racks
        ]
        wins = sum(rack.state.get('winner') == number for rack in racks)
        broken = [(rack, shots) for rack, shots in own if rack.state['breaker'] == number]
        runs = sum(
            rack.state.get('winner') == number and len(shots) == len(rack.shots)
            for rack, shots in broken
        )
        strokes = [shot for _, shots in own for shot in shots if not shot.choice]
        ends = Counter(shot.end for shot in strokes if shot.end)
        result['players'].append(
            {
                'name': name,
                'wins': wins,
                'interval': wilson_interval(wins, len(racks)),
                'broken': len(broken),
                'break_and_run': runs,
                'break_and_run_interval': wilson_interval(runs, len(broken)),
                'shots': len(strokes),
                'ends': dict(ends.most_common()),
                'cpu': _times([shot.cpu for shot in strokes]),
                'wall': _times([shot.wall for shot in strokes]),
            }
        )
    return result


def _times(seconds: list[float]) -> tuple[float, float, float]:
    """Median, 95 % and largest of times [s]."""
    if not seconds:
        return 0.0, 0.0, 0.0
    median, most = np.quantile(seconds, [0.5, 0.95]).tolist()
    return median, most, max(seconds)
