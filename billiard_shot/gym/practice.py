"""Practice for learning agents: tables of random balls, each until a stroke pots nothing."""

from typing import Any

from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.game.referee import start
from billiard_shot.gym.actions import (
    action_space,
    checked_actions,
    DRAWN,
    DrawnEnv,
    Float32Array,
    picture_of,
    render_mode_of,
    RENDER_MODES,
    scaled_places,
    scene_of_table,
    strokes_of,
)
from billiard_shot.scene import SceneLike
from billiard_shot.scene.fields import whole
from billiard_shot.scene.placement import Place
from billiard_shot.scene.player import with_errors
from billiard_shot.shot.play import play
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.model.motion import NOTHING
from billiard_shot.table.run.states import TableStates

Flags = NDArray[np.bool_]

MANY_TABLES = DRAWN | {
    'autoreset_mode': AutoresetMode.SAME_STEP,
    'render_modes': RENDER_MODES[:1],
}
"""Metadata of the environment of many tables."""


class PracticeVectorEnv(VectorEnv[Any, Any, Any]):
    """
    Practice on many tables in one batch.

    The rules are those of the game `practice`: a stroke that pots a ball without a foul goes on.
    Strokes have the execution noise of the scene. A stroke without room for the cue is a foul, as
    is one whose cue hits the cue ball again.

    An observation (balls + 1, 3) has a row for each ball, the cue ball first: x and y relative to
    half the length and half the width, and 1 if the ball is on the table; else all are 0. At first
    the cue ball is in hand. An action (7,) is a stroke and a place of the cue ball, clipped to -1
    and 1, see `strokes_of`.

    The reward is the number of balls that fall without a foul. An episode terminates if the table
    is cleared, if no ball falls, or by a foul, also if the cue ball is placed onto another ball. A
    table whose episode has ended is set up again in the same step; `final_obs` of the infos has
    the last observations.

    Parameters
    ----------
    num_envs : int
        Number of tables, at least 1.
    scene : Scene, str or Path
        Table, noise, limits of the strokes.
    balls : int
        Balls on each table, 1 to 15.
    render_mode : str, optional
        `rgb_array`: `render` gives a picture of each table.

    """

    metadata: dict[str, Any] = MANY_TABLES

    def __init__(
        self,
        num_envs: int = 1,
        scene: SceneLike = 'pool_table',
        balls: int = 3,
        render_mode: str | None = None,
    ) -> None:
        self.render_mode = render_mode_of(render_mode, RENDER_MODES[:1])
        self._is_ready = False
        self.num_envs, self.scene = whole('num_envs', num_envs, 1), scene_of_table(scene)
        self._balls = len(start('practice', self.scene, balls=balls).object_balls)
        high = np.ones((1 + self._balls, 3), np.float32)
        low = -high
        low[:, 2] = 0.0
        self.single_observation_space = self._space = spaces.Box(low, high)
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        names = ('cue', *map(str, range(1, self._balls + 1)))
        self._tables = TableStates(names, np.zeros((num_envs, len(names), 3)))
        self._tables.position[..., 2] = self.scene.ball.radius

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Set up all tables; `options` do not count."""
        super().reset(seed=seed)
        self._set_up(np.ones(self.num_envs, np.bool_))
        self._is_ready = True
        return self._seen(), {}

    def step(
        self, actions: ArrayLike
    ) -> tuple[Float32Array, Float32Array, Flags, Flags, dict[str, Any]]:
        """Play a stroke on every table."""
        actions = checked_actions(actions, self.num_envs, is_ready=self._is_ready)
        scene, tables, cue = self.scene, self._tables, 0
        in_hand = ~tables.present[:, cue]
        assert scene.table is not None
        length, width, radius = scene.table.length, scene.table.width, scene.ball.radius
        places = scaled_places(length, width, radius, actions, 0.5 * length - radius)
        tables.position[in_hand, cue, :2] = places[in_hand]
        tables.present[:, cue] = True
        sigmas = scene.noise.sigmas(radius)
        errors = sigmas * self.np_random.standard_normal((self.num_envs, 5))
        strokes = with_errors(strokes_of(scene, actions), errors)
        played = play(scene, *vectors_of(strokes), tables)
        fallen = (played.pocket != NOTHING)[:, 1:].sum(axis=1)
        scratched = (played.pocket[:, cue] != NOTHING) | played.off_table.any(axis=1)
        missed = played.first_met[:, cue] == NOTHING
        foul = scratched | missed | played.refused | played.double_hit
        reward = np.where(foul, 0, fallen).astype(np.float32)
        self._tables = played.states
        cleared = ~self._tables.present[:, 1:].any(axis=1)
        ended = (reward == 0.0) | cleared
        infos: dict[str, Any] = {}
        if ended.any():
            infos = {
                'final_obs': self._seen(),
                '_final_obs': ended,
                'cleared': ended & ~foul & cleared,
            }
            self._set_up(ended)
        return self._seen(), reward, ended, np.zeros(self.num_envs, np.bool_), infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Draw all tables, if the render mode asks for it: (height, width, 3) arrays."""
        if self.render_mode is None:
            return None
        return tuple(
            picture_of(self.scene, self.places(table), f'table {table}')
            for table in range(self.num_envs)
        )

    def places(self, table: int) -> dict[str, Place]:
        """Places of the balls that are on a table, by name [m]."""
        tables = self._tables
        return {
            name: (float(x), float(y))
            for name, (x, y, _), there in zip(
                tables.names, tables.position[table], tables.present[table], strict=True
            )
            if there
        }

    def _set_up(self, which: Flags) -> None:
        """Place the balls of some tables at random, with the cue ball in hand."""
        tables = self._tables
        for table in np.flatnonzero(which).tolist():
            seed = int(self.np_random.integers(2**31))
            state = start('practice', self.scene, seed, balls=self._balls)
            tables.position[table, 1:, :2] = [state.balls[name] for name in tables.names[1:]]
        tables.position[which, :, 2] = self.scene.ball.radius
        tables.present[which] = True
        tables.present[which, 0] = False

    def _seen(self) -> Float32Array:
        table = self.scene.table
        assert table is not None
        tables = self._tables
        seen = np.ones(tables.position.shape, np.float32)
        seen[..., :2] = tables.position[..., :2] / (0.5 * table.length, 0.5 * table.width)
        seen[~tables.present] = 0.0
        return np.clip(seen, self._space.low, self._space.high)


class PracticeEnv(DrawnEnv):
    """
    Practice on one table: see `PracticeVectorEnv`.

    Parameters
    ----------
    scene, balls
        As of `PracticeVectorEnv`.
    render_mode
        As of `DrawnEnv`.

    """

    def __init__(
        self,
        scene: SceneLike = 'pool_table',
        balls: int = 3,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        self._tables = PracticeVectorEnv(1, scene, balls)
        self.scene = self._tables.scene
        self.observation_space = self._tables.single_observation_space
        self.action_space = self._tables.single_action_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Set up the table."""
        super().reset(seed=seed)
        seen, _ = self._tables.reset(seed=int(self.np_random.integers(2**31)))
        self.show()
        return seen[0], {}

    def step(self, action: ArrayLike) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Play a stroke."""
        seen, reward, ended, _, infos = self._tables.step(np.asarray(action)[np.newaxis])
        self.show()
        if ended[0]:
            last = infos['final_obs'][0]
            return last, float(reward[0]), True, False, {'cleared': bool(infos['cleared'][0])}
        return seen[0], float(reward[0]), False, False, {}

    def places(self) -> dict[str, Place]:
        """Places of the balls that are on the table, by name [m]."""
        return self._tables.places(0)
