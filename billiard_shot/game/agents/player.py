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
from billiard_shot.game.game import find_game
from billiard_shot.game.placing import placed, places_to_try
from billiard_shot.game.pot_candidates import pot_candidates
from billiard_shot.game.referee import choose
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.safe_stroke import all_round, hit_something, towards
from billiard_shot.game.state import State
from billiard_shot.game.valuation import value, values
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.scene import Scene
from billiard_shot.shot.predict import predict_batch
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run import POCKET_NAMES

Array = NDArray[np.float64]

SHOTS = 5  # direct shots that are tried at several speeds and spins
PLACES, TIPS_IN_HAND = 6, 5  # places of the cue ball in hand that are tried; tips at each
FINALISTS, SAMPLES = 14, 20  # strokes with errors, and errors of each
WINNERS, MORE_SAMPLES = 4, 60  # of these, strokes with more errors, and errors of each
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


class Rated(NamedTuple):
    """A stroke with its value and success under errors."""

    options: Options
    number: int
    value: float
    success: float


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
        return best.options.state.balls['cue']

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
        guess *= direct.chance[made.shot] * np.minimum(weight, 3) / 3.0
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
        ranked = [
            (float(guess), i, number)
            for i, options in enumerate(all_options)
            for number, guess in enumerate(options.guess.tolist())
        ]
        ranked = [each for each in sorted(ranked, reverse=True)[:finalists] if each[0] > 0.0]
        if not ranked:
            return None
        chosen = [(i, number) for _, i, number in ranked]
        first = self._rate(all_options, chosen, SAMPLES)
        first.sort(key=lambda rated: -rated.value)
        positions = {id(options): i for i, options in enumerate(all_options)}
        again = [(positions[id(rated.options)], rated.number) for rated in first[:WINNERS]]
        return max(self._rate(all_options, again, MORE_SAMPLES), key=lambda rated: rated.value)

    def _rate(
        self, all_options: list[Options], chosen: list[tuple[int, int]], samples: int
    ) -> list[Rated]:
        """Value strokes under the same errors."""
        rated = []
        seed = self._draw.integers(2**63)
        for i in sorted({i for i, _ in chosen}):
            options = all_options[i]
            numbers = [number for j, number in chosen if j == i]
            strokes = options.offsets[numbers]
            errors = np.random.default_rng(seed)
            noise, radius = options.scene.noise, options.scene.ball.radius
            deviations = errors.standard_normal((samples, 5)) * noise.sigmas(radius)
            played = strokes[:, np.newaxis] + deviations
            played[..., 2] = np.maximum(played[..., 2], 0.0)
            played[..., 4] = np.maximum(played[..., 4], 1e-3)
            calls = [options.calls[number] for number in numbers for _ in range(samples)]
            batch = self._played(options.state, options.scene, played.reshape(-1, 5), calls)
            value = values(options.scene, options.state.player, batch).reshape(-1, samples)
            kept = batch.keeps(options.state.player).reshape(-1, samples)
            rated += [
                Rated(options, number, float(v.mean()), float(k.mean()))
                for number, v, k in zip(numbers, value, kept, strict=True)
            ]
        return rated

    def _decision(self, best: Rated) -> Decision:
        options, number = best.options, best.number
        call = options.calls[number]
        what = f'{call.ball} to {call.pocket}' if call.ball else 'safety'
        return Decision(
            Stroke.from_offsets(*options.offsets[number].tolist()),
            call,
            success=None if call.safety else best.success,
            reason=f'{what}: wins in {100.0 * best.value:.0f} %',
        )


def _best_of(direct: DirectShots, count: int) -> NDArray[np.int64]:
    """Numbers of the direct shots with the best chances."""
    return np.argsort(-direct.chance, kind='stable')[:count]


make = Player
