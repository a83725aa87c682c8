"""
The agent `player`: the shot with the largest probability to win the rack, the leave included.

It tries direct shots at several speeds and spins, without errors at first; then the best of them
with the errors of the player. Each end state is valued by what can follow (valuation.py). If no
pot is good, safeties compete with the pots by the same values.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.agent import scene_of
from billiard_shot.game.batch_outcomes import rule_on, RuledBatch
from billiard_shot.game.breaks import best_break
from billiard_shot.game.call import Call, Decision
from billiard_shot.game.clearance import raised
from billiard_shot.game.game import find_game
from billiard_shot.game.placing import placed, places_to_try
from billiard_shot.game.pot_candidates import pot_candidates
from billiard_shot.game.referee import choose
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.safe_stroke import all_round, hit_something, towards
from billiard_shot.game.second_ply import second_ply
from billiard_shot.game.state import State
from billiard_shot.game.valuation import value, values
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.scene import Scene
from billiard_shot.scene.player import SLOWEST
from billiard_shot.shot.predict import predict_batch
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run import POCKET_NAMES

Array = NDArray[np.float64]

SHOTS = 6  # direct shots that are tried at several speeds and spins
PLACES, TIPS_IN_HAND = 6, 5  # places of the cue ball in hand that are tried; tips at each
FINALISTS, SAMPLES = 20, 30  # strokes with errors, and errors of each
WINNERS, MORE_SAMPLES = 5, 100  # of these, strokes with more errors, and errors of each
FOLLOWED = 60  # strokes without errors whose end states are followed by a second shot
ENDS = 8  # end states of a stroke whose next shots are followed
POOR = 0.6  # success below which safeties are tried
SAFETIES = 8  # of which so many are tried with errors


class Options(NamedTuple):
    """
    Strokes to choose from, from one place of the cue ball.

    Attributes
    ----------
    state : State
        With the cue ball placed.
    scene : Scene
        With the balls of the state.
    offsets : (n, 5) float array
    calls : list of Call
        (n,)
    guess : (n,) float array
        Value without errors, times the chance of the direct shot.

    """

    state: State
    scene: Scene
    offsets: Array
    calls: list[Call]
    guess: Array


class Stroke5(NamedTuple):
    """A stroke to be tried with errors, of one of the options."""

    options: Options
    offsets: Array  # (5,)
    call: Call


class Rated(NamedTuple):
    """
    A stroke with its value and success under errors.

    Attributes
    ----------
    stroke : Stroke5
    value, success : float
        Mean value; share of the executions that keep the turn.
    turn : float
        Mean error of the azimuth of these executions [rad].
    ends : RuledBatch
        Some of these executions.
    first : (k,) float array
        Their values by the next shot alone.

    """

    stroke: Stroke5
    value: float
    success: float
    turn: float
    ends: RuledBatch
    first: Array


class Player:
    """
    Plays for the rack.

    Parameters
    ----------
    scene : Scene
        With which it plans: table, noise, limits.
    seed : int
        Of its samples.

    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene, self._draw = scene, np.random.default_rng(seed)
        self._planned: Decision | None = None

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball for the stroke that it then plays."""
        if state.phase == 'break':
            place, _ = best_break(self._scene, state.game)
            self._planned = None
            return place
        best = self._best(self._pots_in_hand(state))
        if best is None:
            places = places_to_try(state, self._draw)
            x, y = places[0].tolist()
            return x, y
        self._planned = self._decision(best)
        return best.stroke.options.state.balls['cue']

    def decide(self, state: State) -> Decision:
        """Decide on the stroke with the largest value."""
        planned, self._planned = self._planned, None
        if state.choices:
            return Decision(choice=self._choice(state))
        if planned is not None:
            return planned
        scene = scene_of(self._scene, state)
        if state.phase == 'break':
            _, stroke = best_break(self._scene, state.game)
            return Decision(stroke, reason='break')
        best = self._best(self._pots(state, scene))
        if best is None or best.success < POOR:
            safe = self._best(self._safeties(state, scene), SAFETIES)
            if safe is not None and (best is None or safe.value > best.value):
                best = safe
        if best is None:
            return hit_something(scene, state)
        return self._decision(best)

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Learn nothing."""

    def _choice(self, state: State) -> str:
        """Take the choice with the largest value for this player."""
        found = {}
        for choice in state.choices:
            after = choose(state, choice)
            pots = find_game(after.game).pots(after)
            chance = np.zeros(1)
            if after.phase == 'break':
                found[choice] = 0.5 if after.player == state.player else 0.45
                continue
            if 'cue' in after.balls:
                chance = shots(self._scene, placed(after), pots).best
            found[choice] = float(value(Ruling(after), state.player, chance)[0])
        return max(found, key=lambda choice: found[choice])

    def _pots(self, state: State, scene: Scene) -> list[Options]:
        direct = shots(scene, placed(state), find_game(state.game).pots(state))
        return [self._options(state, scene, direct, _best_of(direct, SHOTS))]

    def _pots_in_hand(self, state: State) -> list[Options]:
        places = places_to_try(state, self._draw)
        direct = shots(self._scene, placed(state, places), find_game(state.game).pots(state))
        found: list[Options] = []
        used: set[tuple[int, int]] = set()
        for number in np.argsort(-direct.chance).tolist():
            pair = int(direct.ball[number]), int(direct.pocket[number])
            if pair in used:
                continue
            used.add(pair)
            x, y = places[direct.table[number]].tolist()
            with_cue = state.with_cue_ball(x, y)
            scene = scene_of(self._scene, with_cue)
            found.append(self._options(with_cue, scene, direct, np.array([number]), TIPS_IN_HAND))
            if len(found) == PLACES:
                break
        return found

    def _options(
        self,
        state: State,
        scene: Scene,
        direct: DirectShots,
        which: NDArray[np.int64],
        tips: int = 9,
    ) -> Options:
        """Aim strokes of direct shots without errors, and guess their values."""
        made = pot_candidates(scene, direct, which, tips=tips)
        count, turns = made.offsets.shape[:2]
        if not count:
            return Options(state, scene, np.zeros((0, 5)), [], np.zeros(0))
        calls = [
            Call(
                ball=direct.names[int(direct.ball[shot])],
                pocket=POCKET_NAMES[int(direct.pocket[shot])],
            )
            for shot in made.shot.tolist()
        ]
        flat = made.offsets.reshape(-1, 5)
        batch = self._played(state, scene, flat, [call for call in calls for _ in range(turns)])
        kept = batch.keeps(state.player).reshape(count, turns)
        value = values(scene, state.player, batch).reshape(count, turns)
        # Aim at the middle of the directions that pot.
        weight = kept.sum(axis=1)
        middle = (kept * np.arange(turns)).sum(axis=1) / np.maximum(weight, 1)
        low = np.floor(middle).astype(int)
        rows, high = np.arange(count), np.minimum(low + 1, turns - 1)
        part = (middle - low)[:, np.newaxis]
        offsets = made.offsets[rows, low] * (1.0 - part) + made.offsets[rows, high] * part
        guess = (kept * value).sum(axis=1) / np.maximum(weight, 1)
        best = np.argsort(-guess, kind='stable')[:FOLLOWED]
        best = best[kept[best].any(axis=1)]
        middle_kept = np.abs(np.where(kept, np.arange(turns), np.inf) - middle[:, np.newaxis])
        chosen = best * turns + np.argmin(middle_kept[best], axis=1)
        second = second_ply(scene, state.player, batch.take(chosen), value.ravel()[chosen])
        guess[best] += second - value.ravel()[chosen]
        guess *= direct.chance[made.shot] * np.minimum(weight, 3) / 3.0
        offsets, playable = raised(scene, offsets)  # which are turned since
        guess[~playable] = 0.0
        return Options(state, scene, offsets, calls, guess)

    def _safeties(self, state: State, scene: Scene) -> list[Options]:
        targets = find_game(state.game).targets(state)
        x, y = state.balls['cue']
        near = sorted(
            targets, key=lambda b: np.hypot(state.balls[b][0] - x, state.balls[b][1] - y)
        )
        offsets = np.concatenate([towards(scene, tuple(near[:4])), all_round(scene)])
        calls = [Call(safety=True)] * len(offsets)
        if not len(offsets):
            return []
        guess = values(scene, state.player, self._played(state, scene, offsets, calls))
        return [Options(state, scene, offsets, calls, guess)]

    def _played(self, state: State, scene: Scene, offsets: Array, calls: list[Call]) -> RuledBatch:
        return rule_on(state, calls, predict_batch(scene, offsets=offsets))

    def _best(self, all_options: list[Options], finalists: int = FINALISTS) -> Rated | None:
        """Try the best strokes with errors, then the best of these with more errors."""
        ranked = sorted(
            (
                (float(guess), -i, -number)
                for i, options in enumerate(all_options)
                for number, guess in enumerate(options.guess.tolist())
                if guess > 0.0
            ),
            reverse=True,
        )
        if not ranked:
            return None
        strokes = []
        for _, i, number in ranked[:finalists]:
            options = all_options[-i]
            strokes.append(Stroke5(options, options.offsets[-number], options.calls[-number]))
        first = self._rate(strokes, SAMPLES)
        first.sort(key=lambda rated: -rated.value)
        again = [_turned(rated) for rated in first[:WINNERS]]
        return max(self._rate(again, MORE_SAMPLES), key=lambda rated: rated.value)

    def _deeper(self, rated: Rated) -> Rated:
        """Correct a value by what the next shot leaves in turn."""
        if rated.stroke.call.safety or not len(rated.first):
            return rated
        second = second_ply(
            self._scene, rated.stroke.options.state.player, rated.ends, rated.first
        )
        change = float((second - rated.first).mean())
        return rated._replace(value=rated.value + rated.success * change)

    def _rate(self, strokes: list[Stroke5], samples: int) -> list[Rated]:
        """Value strokes under the same errors."""
        rated = []
        noise, radius = self._scene.noise, self._scene.ball.radius
        errors = self._draw.standard_normal((samples, 5)) * noise.sigmas(radius)
        for options in {id(stroke.options): stroke.options for stroke in strokes}.values():
            own = [stroke for stroke in strokes if stroke.options is options]
            played = np.array([stroke.offsets for stroke in own])[:, np.newaxis] + errors
            played[..., 2] = np.maximum(played[..., 2], 0.0)
            played[..., 4] = np.maximum(played[..., 4], SLOWEST)
            calls = [stroke.call for stroke in own for _ in range(samples)]
            state = options.state
            batch = self._played(state, options.scene, played.reshape(-1, 5), calls)
            value = values(options.scene, state.player, batch).reshape(-1, samples)
            kept = batch.keeps(state.player).reshape(-1, samples)
            for number, (stroke, v, k) in enumerate(zip(own, value, kept, strict=True)):
                turn = float(errors[k, 3].mean()) if k.any() else 0.0
                some = np.flatnonzero(k)[:ENDS]
                ends = batch.take(number * samples + some)
                each = Rated(stroke, float(v.mean()), float(k.mean()), turn, ends, v[some])
                rated.append(self._deeper(each))
        return rated

    def _decision(self, best: Rated) -> Decision:
        call = best.stroke.call
        what = f'{call.ball} to {call.pocket}' if call.ball else 'safety'
        return Decision(
            Stroke.from_offsets(*best.stroke.offsets.tolist()),
            call,
            success=None if call.safety else best.success,
            reason=f'{what}: wins in {100.0 * best.value:.0f} %',
        )


def _turned(rated: Rated) -> Stroke5:
    """Turn a stroke to the middle of the azimuths that succeeded, if some did not."""
    offsets = rated.stroke.offsets.copy()
    if not rated.stroke.call.safety:
        offsets[3] += rated.turn
    return rated.stroke._replace(offsets=offsets)


def _best_of(direct: DirectShots, count: int) -> NDArray[np.int64]:
    """Numbers of the direct shots with the best chances."""
    return np.argsort(-direct.chance, kind='stable')[:count]


make = Player
