"""
Environments of Gymnasium for learning agents: practice on random balls, and a rack of eight-ball.

Actions are numbers from -1 to 1. A table of practice lasts until a stroke pots nothing; the rack
is played against an agent of the package.
"""

from collections.abc import Mapping, Sequence
import math
from typing import Any

import gymnasium
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.game.rack import find_agent, MAX_SHOTS, scene_of, simulated, take_shot
from billiard_shot.game.referee import choose, concede, judge, start
from billiard_shot.game.state import Call, NO_CALL, Outcome, Ruling, State
from billiard_shot.game.strokes import raised
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.records import Array
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import must_be_one_of
from billiard_shot.scene.fields import whole
from billiard_shot.scene.placement import CUE_BALL, head_string, Place
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, with_errors
from billiard_shot.shot.play import play_strokes
from billiard_shot.shot.stroke import Stroke, vectors_of
from billiard_shot.table.model.motion import NOTHING
from billiard_shot.table.run.states import TableStates

Float32Array = NDArray[np.float32]

ACTION = 7  # a, b, elevation, azimuth, speed; x, y of the cue ball if it is in hand


def action_space() -> spaces.Box:
    """Return the space of actions (7,) of one table."""
    return spaces.Box(-1.0, 1.0, (ACTION,), np.float32)


def scene_of_table(scene: Any) -> Scene:
    """Load a scene; ValueError if it has no pockets."""
    found = Scene.load(scene)
    if found.table is None or not found.table.pockets:
        raise ValueError('scene must have a table with pockets')
    return found


def checked_actions(actions: ArrayLike, count: int, *, is_ready: bool) -> Array:
    """
    Return actions as an array (count, 7); ValueError if they have another shape or a NaN.

    Raises
    ------
    ResetNeeded
        If the environment is not ready, because `reset` was not called.

    """
    if not is_ready:
        raise ResetNeeded('reset must be called before step')
    rows = np.asarray(actions, float)
    if rows.shape != (count, ACTION):
        shape = (ACTION,) if count == 1 else (count, ACTION)
        raise ValueError(f'action must have the shape {shape}, got an array of {rows.size}')
    if not np.isfinite(rows).all():
        raise ValueError(f'action must be finite, got {rows[~np.isfinite(rows).all(axis=1)][0]}')
    return rows


def strokes_of(scene: Scene, actions: ArrayLike) -> Array:
    """
    Return the strokes of actions.

    Parameters
    ----------
    scene : Scene
        Its `robot` limits the strokes.
    actions : (n, 7) array_like
        -1 and 1 are the limits of the robot: of a and b together its largest offset, of the
        azimuth the ends of its range. What is beyond -1 and 1 is clipped.

    Returns
    -------
    (n, 5) float array
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.

    """
    middle, half = _limits(scene)
    offsets: Array = middle + half * np.clip(np.asarray(actions, float)[:, :5], -1.0, 1.0)
    distance = np.hypot(offsets[:, A], offsets[:, B])
    largest = scene.robot.offset_max
    offsets[:, [A, B]] *= np.minimum(1.0, largest / np.maximum(distance, largest))[:, np.newaxis]
    return offsets


def scaled_places(
    length: float, width: float, radius: float, actions: ArrayLike, last: float
) -> Array:
    """Scale x, y of actions (n, 7) to places of the cue ball (n, 2) [m] with x up to `last`."""
    half = np.array([0.5 * length, 0.5 * width]) - radius
    places: Array = half * np.clip(np.asarray(actions, float)[:, 5:], -1.0, 1.0)
    places[:, 0] = -half[0] + (places[:, 0] + half[0]) * (last + half[0]) / (2.0 * half[0])
    return places


def action_of(
    scene: Scene, offsets: ArrayLike, place: ArrayLike = (0.0, 0.0)
) -> NDArray[np.float32]:
    """
    Return the actions of strokes: the inverse of `strokes_of`.

    Parameters
    ----------
    scene : Scene
    offsets : (n, 5) array_like
        As of `Stroke.from_offsets`; what is beyond the limits is clipped.
    place : (2,) or (n, 2) array_like
        Of the cue ball, if it is in hand anywhere on the table [m].

    """
    middle, half = _limits(scene)
    table, radius = scene.table, scene.ball.radius
    assert table is not None
    rows = np.array(offsets, float)
    found = np.zeros((len(rows), ACTION))
    change = rows - middle
    change[:, AZIMUTH] = wrapped(change[:, AZIMUTH])
    found[:, :5] = change / np.maximum(half, 1e-12)
    found[:, 5:] = np.asarray(place) / (np.array([table.length, table.width]) / 2.0 - radius)
    return np.clip(found, -1.0, 1.0).astype(np.float32)


def _limits(scene: Scene) -> tuple[Array, Array]:
    """Return the middles and the half ranges (5,) of strokes."""
    robot = scene.robot
    low = np.array([-robot.offset_max, -robot.offset_max, 0.0, 0.0, robot.speed_min])
    high = np.array([robot.offset_max, robot.offset_max, 0.0, 0.0, robot.speed_max])
    low[ELEVATION], high[ELEVATION] = np.radians(
        [robot.elevation_min_deg, robot.elevation_max_deg]
    )
    middle, range_ = math.radians(robot.azimuth_deg), math.radians(robot.azimuth_half_range_deg)
    low[AZIMUTH], high[AZIMUTH] = middle - range_, middle + range_
    return 0.5 * (low + high), 0.5 * (high - low)


RENDER_MODES = ['rgb_array', 'human']

RENDER_FPS = 2
"""Pictures a second of a video: each shows the balls at rest before a stroke."""

DRAWN = {'render_modes': RENDER_MODES, 'render_fps': RENDER_FPS}
"""Metadata of the environments of one table."""

DPI = 80


def render_mode_of(mode: str | None, modes: Sequence[str] = RENDER_MODES) -> str | None:
    """Check a render mode; ValueError if there is no such mode."""
    if mode is not None and mode not in modes:
        raise ValueError(f'render_mode {must_be_one_of(modes, mode, "mode")}')
    return mode


def picture_of(scene: Scene, places: Mapping[str, Place], title: str = '') -> NDArray[np.uint8]:
    """
    Draw balls on the table of a scene.

    Parameters
    ----------
    scene : Scene
    places : mapping of str to (x, y)
        Places of the balls that are on the table, by name [m].
    title : str

    Returns
    -------
    (height, width, 3) uint8 array
        Red, green and blue.

    Raises
    ------
    ValueError
        If matplotlib is missing, with the command that installs it.

    """
    from billiard_shot.pictures.table import draw_balls, table_axes

    figure, axes = table_axes(scene, title=title)  # says if matplotlib is missing
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    draw_balls(axes, scene, places)
    figure.set_dpi(DPI)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


class DrawnEnv(gymnasium.Env[Any, Any]):
    """
    An environment that draws its table.

    Parameters
    ----------
    render_mode : str, optional
        `rgb_array`: `render` gives a picture; `human`: each step shows one in a window.

    """

    metadata: dict[str, Any] = DRAWN
    scene: Scene

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode_of(render_mode)
        self._window: Any = None  # image in the window

    def places(self) -> Mapping[str, Place]:
        """Places of the balls that are on the table, by name [m]."""
        raise NotImplementedError

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the table: a (height, width, 3) array, or None if a window shows it."""
        return picture_of(self.scene, self.places()) if self.render_mode == 'rgb_array' else None

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            from matplotlib import pyplot as plt

            plt.close(self._window.figure)
            self._window = None

    def show(self) -> None:
        """Show the table in the window, if the render mode is `human`."""
        if self.render_mode != 'human':
            return
        picture = picture_of(self.scene, self.places())
        from matplotlib import pyplot as plt

        if self._window is None:
            axes = plt.figure(layout='tight').subplots()
            axes.set_axis_off()
            self._window = axes.imshow(picture)
            plt.show(block=False)
        self._window.set_data(picture)
        self._window.figure.canvas.draw_idle()
        self._window.figure.canvas.flush_events()


Flags = NDArray[np.bool_]

MANY_TABLES = DRAWN | {'autoreset_mode': AutoresetMode.SAME_STEP, 'render_modes': RENDER_MODES[:1]}
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
        played = play_strokes(scene, *vectors_of(strokes), tables)
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
        self, scene: SceneLike = 'pool_table', balls: int = 3, render_mode: str | None = None
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


gymnasium.register(
    'BilliardShot/Practice-v0',
    entry_point='billiard_shot.gym:PracticeEnv',
    vector_entry_point='billiard_shot.gym:PracticeVectorEnv',
)
gymnasium.register('BilliardShot/EightBall-v0', entry_point='billiard_shot.gym:EightBallEnv')
