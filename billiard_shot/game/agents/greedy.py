"""The agent `greedy`: the direct shot with the best chance, wherever it leaves the cue ball."""

import numpy as np

from billiard_shot.game import strokes
from billiard_shot.game.rack import scene_of
from billiard_shot.game.state import Decision, Ruling, State
from billiard_shot.planning.plan import best_in_hand
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke


class Greedy:
    """
    Looks at the direct shots of the table as it is, and at nothing that comes after.

    Parameters
    ----------
    scene : Scene
        With which it plans.
    seed : int
        Does not count.

    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene = scene

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball where the best direct shot has the best chance."""
        if state.phase == 'break':
            return -0.3 * state.length, 0.1 * state.width
        places = strokes.places_to_try(state)
        direct = strokes.direct_shots(self._scene, state, places)
        best = best_in_hand(direct)
        x, y = places[direct.table[best[0]] if len(best) else 0].tolist()
        return x, y

    def decide(self, state: State) -> Decision:
        """Play the direct shot with the best chance; without one, just hit something legal."""
        if state.choices:
            return Decision(choice=state.choices[0])
        scene = scene_of(self._scene, state)
        if state.phase == 'break':
            return Decision(strokes.break_stroke(scene), reason='break')
        direct = strokes.direct_shots(scene, state)
        if not len(direct):
            return strokes.hit_something(scene, state)
        best = int(np.argmax(direct.chance))
        chance, call = float(direct.chance[best]), strokes.call_of(direct, best)
        return Decision(
            Stroke.from_offsets(*direct.offsets[best].tolist()),
            call,
            success=chance,
            reason=f'{call.ball} has the best chance, {100.0 * chance:.0f} %',
        )

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Learn nothing."""


make = Greedy
