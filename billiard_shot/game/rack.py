"""Plays a rack: agents decide, a simulator plays their strokes, the referee rules."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from billiard_shot.game.agent import Agent, scene_of, simulated, Simulator
from billiard_shot.game.call import Decision
from billiard_shot.game.checks import illegal
from billiard_shot.game.rack_record import PlayedShot, RackRecord
from billiard_shot.game.referee import choose, concede, judge
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene import Scene
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke

MAX_SHOTS = 400  # of a rack, which then ends without a winner
EVEN = 0.5  # stated probability from which on a shot that fails is a miss


def play_on(
    record: RackRecord, scene: Scene, agents: Sequence[Agent], simulator: Simulator = simulated
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

    """
    state = State.from_dict(record.state)
    while not state.over and len(record.shots) < MAX_SHOTS:
        agent, errors = agents[state.player], errors_of(record.seed, record.number, state)
        seen, decision, ruling, times = take_shot(state, scene, agent, errors, simulator)
        if not decision.choice:
            for each in agents:
                each.saw(seen, decision, ruling)
        state = ruling.state
        shots = *record.shots, _record(seen, decision, ruling, times)
        record = replace(record, shots=shots, state=state.to_dict())
        yield record


def play_rack(
    record: RackRecord, scene: Scene, agents: Sequence[Agent], simulator: Simulator = simulated
) -> RackRecord:
    """Play a rack to its end, as `play_on` does; return its last record."""
    return [record, *play_on(record, scene, agents, simulator)][-1]


class Taken(NamedTuple):
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
) -> Taken:
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
    return Taken(seen, decision, ruling, times)


def errors_of(seed: int, number: int, state: State) -> np.random.Generator:
    """
    Return the source of the errors of a shot.

    It depends on the seed, the rack, and the number of the shot in the rack only. Two racks in
    turn, in which the players take turns to break, have the same errors and balls.
    """
    return np.random.default_rng([seed, number // 2, state.shots])


def replayed(record: RackRecord, scene: Scene) -> Iterator[tuple[PlayedShot, Shot]]:
    """Predict the strokes of a rack again, with the errors that `simulated` gave them."""
    for shot in record.shots:
        if shot.offsets:
            state = State.from_dict(shot.state)
            at, stroke = scene_of(scene, state), Stroke.from_offsets(*shot.offsets)
            errors = errors_of(record.seed, record.number, state)
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
    if decision.call.safety or decision.call.push_out:
        return 'safety'
    return 'leave' if decision.success is not None and decision.success < EVEN else 'miss'
