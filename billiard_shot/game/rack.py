"""Racks and tournaments: agents decide, a simulator plays their strokes, the referee rules."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from inspect import signature
import json
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple, Protocol

import numpy as np

from billiard_shot.game.referee import choose, concede, illegal, judge, start
from billiard_shot.game.state import (
    Decision,
    find_game,
    find_plugin,
    Game,
    names_in,
    Outcome,
    outcome_of,
    Ruling,
    State,
)
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be_one_of, reason, refused
from billiard_shot.scene.player import NOISES
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke


class Agent(Protocol):
    """A player. It decides from states, and must not change them."""

    def place(self, state: State) -> tuple[float, float]:
        """
        Place the cue ball that is in hand.

        Parameters
        ----------
        state : State
            With `places_cue_ball`.

        Returns
        -------
        (x, y)
            [m]; a place that the rules forbid loses the rack.

        """

    def decide(self, state: State) -> Decision:
        """
        Decide on a stroke and its call; or, if the state has `choices`, take one of them.

        A decision without a stroke is a foul. A choice that is not offered loses the rack, and so
        does a call of a ball that the game does not have.
        """

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """
        Receive a shot of either player, and its ruling.

        Parameters
        ----------
        state : State
            Before the shot; `state.player` played it.
        decision : Decision
        ruling : Ruling

        """


class Simulator(Protocol):
    """A function that plays a stroke, by simulation or with a robot."""

    def __call__(self, scene: Scene, stroke: Stroke, errors: np.random.Generator) -> Outcome:
        """
        Play a stroke with the errors of the player.

        Parameters
        ----------
        scene : Scene
            With the balls as they lie.
        stroke : Stroke
            As it is planned.
        errors : numpy.random.Generator
            Source of the errors of the execution.

        """


def simulated(scene: Scene, stroke: Stroke, errors: np.random.Generator) -> Outcome:
    """Play a stroke as `predict` does, with the execution noise of the scene. A `Simulator`."""
    played = scene.noise.perturb(stroke, errors, scene.ball.radius)
    return outcome_of(predict(scene, played))


def scene_of(scene: Scene, state: State) -> Scene:
    """Return the scene with the balls of a state."""
    return replace(scene, balls=state.balls)


LEVEL = '@'  # between the name of a player and its noise level, as in `player@fargo_500`


def scene_for(scene: Scene, player: str) -> Scene:
    """Return the scene with the noise that the name of a player states, if it does."""
    level = player.partition(LEVEL)[2]
    return replace(scene, noise=NOISES[level]) if level else scene


MakeAgent = Callable[[Scene, int], Agent]
"""Makes an agent from the scene with which it plans and the seed of its random numbers."""

# How visits to the table end. A miss is a shot that the player gave an even chance or more; a
# shot with less was all that the leave before it had left. A safety is called; where two players
# call nothing, it is a stroke whose chance was stated, at no named ball.
ENDS = ('won', 'miss', 'leave', 'scratch', 'foul', 'safety', 'no shot', 'break', 'illegal')


@dataclass(frozen=True, slots=True)
class PlayedShot:
    """One decision of a rack."""

    state: dict[str, Any]  # before it, see `State.to_dict`
    offsets: tuple[float, ...] = ()  # as planned, of `from_offsets`; empty if there is no stroke
    call: dict[str, Any] = field(default_factory=dict)  # see `Call`
    choice: str = ''  # that was taken
    success: float | None = None  # probability that the player gave its shot
    reason: str = ''  # why it was played
    kept: bool = False  # whether the player kept its turn
    miscue: bool = False  # the tip slid on the cue ball
    fouls: tuple[str, ...] = ()
    text: str = ''  # the ruling
    end: str = ''  # how the visit ended, one of `ENDS`; '' if it went on
    cpu: float = 0.0  # s that the decision took
    wall: float = 0.0  # s


@dataclass(frozen=True, slots=True)
class RackRecord:
    """A rack that was played."""

    game: str
    number: int  # in its tournament
    seed: int  # of the errors of execution, see `agent_errors`
    players: tuple[str, ...]  # names of players 0 and 1
    shots: tuple[PlayedShot, ...]
    state: dict[str, Any]  # at the end

    @property
    def winner(self) -> str | None:
        """Name of the winner; None if nobody has won."""
        winner = self.state.get('winner')
        return None if winner is None else self.players[winner]

    def to_dict(self) -> dict[str, Any]:
        """Plain dict that `from_dict` turns into an equal record."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> 'RackRecord':
        """Make a record from such a dict."""
        shots = tuple(
            PlayedShot(**shot | {name: tuple(shot[name]) for name in ('offsets', 'fouls')})
            for shot in data['shots']
        )
        return cls(**{**data, 'players': tuple(data['players']), 'shots': shots})

    def save(self, path: Path) -> None:
        """Write the record as JSON; a file that was there is replaced at once."""
        new = path.with_name(f'{path.name}.new')
        new.write_text(json.dumps(self.to_dict(), allow_nan=False) + '\n', encoding='utf-8')
        new.replace(path)

    @classmethod
    def load(cls, path: Path) -> 'RackRecord':
        """Read a record that `save` wrote; ValueError names the file."""
        try:
            record = cls.from_dict(json.loads(path.read_text(encoding='utf-8')))
            State.from_dict(record.state)
        except (KeyError, TypeError, json.JSONDecodeError, UnicodeDecodeError):
            raise ValueError(f'{path}: must be the record of a rack') from None
        except (OSError, ValueError) as error:
            raise ValueError(f'{path}: {reason(error)}') from None
        return record


MAX_SHOTS = 400  # of a rack, which then ends without a winner
EVEN = 0.5  # stated probability from which on a shot that fails is a miss


def play_on(
    record: RackRecord,
    scene: Scene,
    agents: Sequence[Agent],
    simulator: Simulator = simulated,
    game: Game | None = None,
) -> Iterator[RackRecord]:
    """
    Play a rack from the state of its record to its end; yield the record after each decision.

    Parameters
    ----------
    record : RackRecord
    scene : Scene
        On which the simulator plays; agents may plan with another one.
    agents : sequence of Agent
        Players 0 and 1.
    simulator : Simulator
    game : Game, optional
        Needed if no module has it.

    """
    state = State.from_dict(record.state, game)
    while not state.over and len(record.shots) < MAX_SHOTS:
        agent, errors = agents[state.player], agent_errors(record.seed, record.number, state.shots)
        own = scene_for(scene, record.players[state.player])
        seen, decision, ruling, times = take_shot(state, own, agent, errors, simulator)
        if not decision.choice:
            for each in agents:
                each.saw(seen, decision, ruling)
        state = ruling.state
        shots = *record.shots, _record(seen, decision, ruling, times)
        record = replace(record, shots=shots, state=state.to_dict())
        yield record


def play_rack(
    record: RackRecord,
    scene: Scene,
    agents: Sequence[Agent],
    simulator: Simulator = simulated,
    game: Game | None = None,
) -> RackRecord:
    """Play a rack to its end, as `play_on` does; return its last record."""
    return [record, *play_on(record, scene, agents, simulator, game)][-1]


class ShotExecution(NamedTuple):
    """A decision that was carried out: the state that was seen, and CPU and wall time [s]."""

    seen: State
    decision: Decision
    ruling: Ruling
    times: tuple[float, float]


def take_shot(
    state: State,
    scene: Scene,
    agent: Agent,
    errors: np.random.Generator,
    simulator: Simulator = simulated,
) -> ShotExecution:
    """
    Let an agent decide, play its stroke, and rule on it; or carry out its choice.

    Parameters
    ----------
    state, scene, simulator
        As of `play_on`.
    agent : Agent
    errors : numpy.random.Generator
        Source of the errors of execution.

    """
    cpu, wall = process_time(), perf_counter()
    seen, decision, refusal = decision_of(agent, state)
    times = process_time() - cpu, perf_counter() - wall
    if refusal:
        ruling = concede(seen, refusal)
    elif decision.choice:
        ruling = Ruling(choose(seen, decision.choice, times[1]), text=decision.choice)
    else:
        outcome = None
        if decision.stroke is not None:
            outcome = simulator(scene_of(scene, seen), decision.stroke, errors)
        ruling = judge(seen, decision.call, outcome, times[1])
    return ShotExecution(seen, decision, ruling, times)


def agent_errors(seed: int, number: int, shots: int) -> np.random.Generator:
    """
    Return the source of the errors of a shot, before which so many were played.

    It depends on the seed, the rack, and the number of the shot in the rack only. Two racks in
    turn, in which the players take turns to break, have the same errors and balls.
    """
    return np.random.default_rng([seed, number // 2, shots])


def replayed(record: RackRecord, scene: Scene) -> Iterator[tuple[PlayedShot, Shot]]:
    """Predict the strokes of a rack again, with the errors that `simulated` gave them."""
    for shot in record.shots:
        if shot.offsets:  # the rules of its game do not count, and may not be there
            own = scene_for(scene, record.players[shot.state['player']])
            at = replace(own, balls=shot.state['balls'])
            stroke = Stroke.from_offsets(*shot.offsets)
            errors = agent_errors(record.seed, record.number, shot.state['shots'])
            yield shot, predict(at, at.noise.perturb(stroke, errors, at.ball.radius))


def decision_of(agent: Agent, state: State) -> tuple[State, Decision, str]:
    """Ask an agent; return the state with the cue ball placed, and why a move is illegal."""
    if state.places_cue_ball:
        x, y = map(float, agent.place(state))
        if why := state.no_place(x, y):
            return state, Decision(), f'the cue ball must be {why}, got {(x, y)} (m)'
        state = state.with_cue_ball(x, y)
    decision = agent.decide(state)
    if not isinstance(decision, Decision):
        raise TypeError(f'decide must return a Decision, got {decision!r}')
    if why := illegal(state, decision):
        return state, Decision(), why
    return state, decision, ''


def _record(
    state: State, decision: Decision, ruling: Ruling, times: tuple[float, float]
) -> PlayedShot:
    after = ruling.state
    kept = after.player == state.player and not after.over
    return PlayedShot(
        state=state.to_dict(),
        offsets=decision.stroke.offsets if decision.stroke else (),
        call=asdict(decision.call),
        choice=decision.choice,
        success=decision.success,
        reason=decision.reason,
        kept=kept,
        miscue=ruling.miscue,
        fouls=tuple(map(str, ruling.fouls)),
        text=ruling.text,
        end='' if kept or decision.choice else _end(state, decision, ruling),
        cpu=times[0],
        wall=times[1],
    )


def _end(state: State, decision: Decision, ruling: Ruling) -> str:
    """Say how a visit to the table ended, see `ENDS`."""
    rules = {foul.rule for foul in ruling.fouls}
    if ruling.state.over and ruling.state.winner == state.player:
        return 'won'
    if '6.17' in rules:
        return 'illegal'
    if decision.stroke is None:
        return 'no shot'
    if '6.1' in rules:
        return 'scratch'
    if rules:
        return 'foul'
    if state.phase == 'break':
        return 'break'
    game, success = state.game, decision.success
    silent = game.pockets and not (game.calls or game.players == 1 or decision.call.ball)
    if decision.call.passes or (silent and success is not None):
        return 'safety'
    return 'leave' if success is not None and success < EVEN else 'miss'


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
        Options for `make` may follow, such as `player:effort=0.5,plies=1`, and one of `NOISES`,
        such as `player@fargo_500`: the noise of its strokes, in place of that of the scene.

    Raises
    ------
    ValueError
        If there is no such agent.

    """
    words, _, level = name.partition(LEVEL)
    if level and level not in NOISES:
        raise ValueError(f'noise of player {words!r} {must_be_one_of(NOISES, level)}')
    module, _, given = words.partition(':')
    make: MakeAgent = find_plugin(module, 'agents', 'make', 'player')
    try:
        signature(make).bind(None, 0)
    except (TypeError, ValueError):
        raise refused(
            make, 'a function of a scene and a seed', f'make of player {module!r}'
        ) from None
    options = dict(_option(make, words, word) for word in given.split(',') if word)
    return lambda scene, seed: make(scene_for(scene, name), seed, **options)


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
    game : str or Game
        See `find_game`.
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

    game: str | Game
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
    game = find_game(pairing.game)
    return play_rack(record, pairing.scene, agents, pairing.simulator, game)


def first_record(pairing: Pairing, number: int) -> RackRecord:
    """Rack the balls of a rack, and return its record without shots."""
    players = pairing.players
    breaker = number % 2 if len(players) > 1 else 0
    rack = pairing.seed + number // 2 if len(players) > 1 else pairing.seed + number
    state = start(pairing.game, pairing.scene, rack, breaker, pairing.balls)
    return RackRecord(state.game.name, number, pairing.seed, players, (), state.to_dict())


def agents_of(pairing: Pairing, number: int) -> list[Agent]:
    """Make the players of a rack."""
    return [
        find_agent(name)(pairing.scene, pairing.seed + 7919 * number + i)
        for i, name in enumerate(pairing.players)
    ]


def check_pairing(pairing: Pairing) -> None:
    """Raise ValueError for players that are not there, or too many or few of them."""
    game = find_game(pairing.game)
    if len(pairing.players) != game.players:
        raise refused(len(pairing.players), f'{game.players} for {game.name}', 'players')
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
