"""Eight-ball for learning agents: one rack against an agent of the package."""

from collections.abc import Mapping
from typing import Any

from gymnasium import spaces
import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.game.rack import find_agent, MAX_SHOTS, scene_of, simulated, take_shot
from billiard_shot.game.referee import choose, concede, judge, start
from billiard_shot.game.state import Call, NO_CALL, Outcome, Ruling, State
from billiard_shot.game.strokes import raised
from billiard_shot.gym.actions import (
    action_space,
    checked_actions,
    DrawnEnv,
    Float32Array,
    scaled_places,
    scene_of_table,
    strokes_of,
)
from billiard_shot.scene import SceneLike
from billiard_shot.scene.placement import CUE_BALL, head_string, Place
from billiard_shot.shot.stroke import Stroke

EIGHT_BALL = 'eight_ball'
RACKED_BALLS = (CUE_BALL, *map(str, range(1, 16)))
IN_HAND_ROLE = {'': 0.0, 'kitchen': -1.0, 'anywhere': 1.0}


class EightBallEnv(DrawnEnv):
    """
    One rack of eight-ball against an agent, by the rules and with the noise of the scene.

    An observation (16, 4) has a row for each ball, the cue ball first: x and y relative to half
    the length and half the width; 1 if the ball is on the table; and the role of the ball: 1 if it
    may be met first and potted, else -1. The role of the cue ball is 1 if it is in hand, -1 if it
    is in hand behind the head string, else 0. An action (7,) is a stroke and a place of the cue
    ball in hand, clipped to -1 and 1, see `strokes_of`; x is scaled to the part of the table where
    the rules allow the cue ball. The cue is raised as far as it needs for clearance. The call is
    made afterwards: the first ball that falls and may be potted was called. If rules offer
    choices, the first one is taken.

    The reward is 1 for a rack that is won, -1 for one that is lost, else 0. A cue ball that is
    placed onto another ball loses the rack. The opponent plays in the same step until its turn
    ends. `text` of the infos has the rulings.

    Parameters
    ----------
    scene : Scene, str or Path
        Table, noise, limits of the strokes.
    opponent : str
        See `find_agent`.
    render_mode
        As of `DrawnEnv`.

    """

    def __init__(
        self,
        scene: SceneLike = 'seven_foot',
        opponent: str = 'greedy',
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        self._is_ready = False
        self.scene = scene_of_table(scene)
        self._make_opponent = find_agent(opponent)
        high = np.ones((len(RACKED_BALLS), 4), np.float32)
        low = -high
        low[:, 2] = 0.0
        self.observation_space = self._space = spaces.Box(low, high)
        self.action_space = action_space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Rack the balls; who breaks is drawn."""
        super().reset(seed=seed)
        rack, player, breaker = self.np_random.integers(2**31, size=3).tolist()
        self._opponent = self._make_opponent(self.scene, player)
        self._state = start(EIGHT_BALL, self.scene, rack, breaker % 2)
        self._is_ready = True
        text = self._opponent_plays()
        self.show()
        return self._seen(), {'text': text}

    def step(self, action: ArrayLike) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Play a stroke, and then the opponent's turn."""
        rows = checked_actions(np.asarray(action)[np.newaxis], 1, is_ready=self._is_ready)
        text = [self._play(rows), *self._opponent_plays()]
        self.show()
        state = self._state
        reward = float((state.winner == 0) - (state.winner == 1))
        return self._seen(), reward, state.over, state.shots >= MAX_SHOTS, {'text': text}

    def places(self) -> Mapping[str, Place]:
        """Places of the balls that are on the table, by name [m]."""
        return self._state.balls if self._is_ready else {}

    def _play(self, action: NDArray[np.float64]) -> str:
        """Play the stroke of player 0; return the ruling."""
        state, half = self._state, 0.5 * self._state.length - self._state.radius
        if state.places_cue_ball:
            last = head_string(state) - 1e-6 if state.in_hand == 'kitchen' else half
            x, y = scaled_places(state.length, state.width, state.radius, action, last)[0].tolist()
            if why := state.no_place(x, y):
                return self._rule(concede(state, f'the cue ball cannot be placed: {why}'))
            state = state.with_cue_ball(x, y)
        scene = scene_of(self.scene, state)
        stroke = strokes_of(scene, action)
        lifted, playable = raised(scene, stroke)
        offsets = (lifted if playable[0] else stroke)[0].tolist()
        outcome = simulated(scene, Stroke.from_offsets(*offsets), self.np_random)
        return self._rule(judge(state, _call(state, outcome), outcome))

    def _opponent_plays(self) -> list[str]:
        """Play until it is the turn of player 0; return the rulings."""
        text = []
        while not self._state.over and self._state.shots < MAX_SHOTS:
            if self._state.player == 1:
                taken = take_shot(self._state, self.scene, self._opponent, self.np_random)
                text.append(self._rule(taken.ruling))
            elif self._state.choices:
                self._state = choose(self._state, self._state.choices[0])
            else:
                break
        return text

    def _rule(self, ruling: Ruling) -> str:
        self._state = ruling.state
        return ruling.text

    def _seen(self) -> Float32Array:
        state = self._state
        legal = () if state.over else state.game.targets(state)
        seen = np.zeros((len(RACKED_BALLS), 4), np.float32)
        for row, ball in zip(seen, RACKED_BALLS, strict=True):
            if ball in state.balls:
                x, y = state.balls[ball]
                role = 1.0 if ball in legal else -1.0
                row[:] = 2.0 * x / state.length, 2.0 * y / state.width, 1.0, role
        seen[0, 3] = 0.0 if CUE_BALL in state.balls else IN_HAND_ROLE[state.in_hand]
        return np.clip(seen, self._space.low, self._space.high)


def _call(state: State, outcome: Outcome) -> Call:
    """Call the first ball that fell and may be potted."""
    may = state.game.targets(state)
    return next((Call(*pair) for pair in outcome.pocketed if pair[0] in may), NO_CALL)
