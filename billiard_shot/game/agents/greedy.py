"""The agent `greedy`: the direct shot with the best chance, wherever it leaves the cue ball."""

import numpy as np

from billiard_shot.game.agent import scene_of
from billiard_shot.game.call import Call, Decision
from billiard_shot.game.game import find_game
from billiard_shot.game.placing import placed, places_to_try
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.safe_stroke import break_stroke, hit_something
from billiard_shot.game.state import State
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run import POCKET_NAMES


class Greedy:
    """
    Looks at the direct shots of the table as it is, and at nothing that comes after.

    Parameters
    ----------
    scene : Scene
        With which it plans.
    seed : int

    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene, self._draw = scene, np.random.default_rng(seed)

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball where the best direct shot has the best chance."""
        if state.phase == 'break':
            return -0.3 * state.length, 0.1 * state.width
        places = places_to_try(state, self._draw)
        tables = placed(state, places)
        direct = shots(self._scene, tables, find_game(state.game).targets(state))
        x, y = places[int(np.argmax(direct.best))].tolist()
        return x, y

    def decide(self, state: State) -> Decision:
        """Play the direct shot with the best chance; without one, just hit something legal."""
        if state.choices:
            return Decision(choice=state.choices[0])
        scene = scene_of(self._scene, state)
        if state.phase == 'break':
            return Decision(break_stroke(scene), reason='break')
        direct = shots(scene, placed(state), find_game(state.game).targets(state))
        if not len(direct):
            return hit_something(scene, state)
        best = int(np.argmax(direct.chance))
        return direct_decision(direct, best)

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Learn nothing."""


def direct_decision(direct: DirectShots, number: int) -> Decision:
    """Make a decision of a direct shot."""
    ball = direct.names[int(direct.ball[number])]
    pocket = POCKET_NAMES[int(direct.pocket[number])]
    chance = float(direct.chance[number])
    return Decision(
        Stroke.from_offsets(*direct.offsets[number].tolist()),
        Call(ball=ball, pocket=pocket),
        success=chance,
        reason=f'{ball} has the best chance, {100.0 * chance:.0f} %',
    )


make = Greedy
