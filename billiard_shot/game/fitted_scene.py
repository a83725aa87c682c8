"""A scene fitted to a simulator that others wrote, by playing shots on it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from billiard_shot.game.agent import simulated, Simulator
from billiard_shot.game.placing import places_to_try
from billiard_shot.game.playable import raised
from billiard_shot.game.racking import start
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.values import whole
from billiard_shot.shot.stroke import Stroke

# Places at rest do not tell how fast the balls were: with all frictions and the square of the
# speed of the cue ball multiplied alike, they are the same. So no number of the cue is fitted.
FITTED_PARAMETERS = (
    'contacts.ball_ball.restitution',
    'cloth.sliding_friction',
    'cloth.rolling_resistance',
    'table.cushion.restitution',
)
FIT_BALL = '1'
SLOWEST_CUE, FASTEST_FIT, HIGHEST = 0.5, 2.0, 0.3  # m/s of the cue; of b in ball radii
ASIDE = 2.0  # ball radii: largest distance of the aim from the middle of the ball
MAX_FACTOR = 3.0  # factor by which a parameter may change
USUAL = 0.05  # m: errors of places beyond it count less, because a ball met another on its way
PARAMETER_STEP = 0.05  # relative change of a parameter for a derivative: outcomes are not smooth


def fitted_scene(
    scene: Scene,
    simulator: Simulator,
    shots: int = 60,
    names: Sequence[str] = FITTED_PARAMETERS,
    seed: int = 1,
) -> Scene:
    """
    Fit numbers of a scene to a simulator, so that players can plan with it.

    Strokes of moderate speed send the cue ball at one ball, or past it, on random tables. The
    places at which both balls come to rest are compared with those that `predict` gives.

    Parameters
    ----------
    scene : Scene
        With the table, the noise and the limits of the strokes of the simulator. Its other numbers
        are where the fit begins.
    simulator : Simulator
    shots : int
        Shots that are played on the simulator, at least 10.
    names : sequence of str
        Numbers to be fitted, see `Scene.parameters`.
    seed : int
        Of the tables and strokes.

    Returns
    -------
    Scene
        With the numbers that were fitted.

    Raises
    ------
    ValueError
        If a name is unknown, or there are too few shots.

    """
    shots = whole('shots', shots, 10)
    draw = np.random.default_rng(seed)
    exact = replace(scene, noise=Noise(0.0, 0.0, 0.0, 0.0, 0.0))
    played = []
    for number in range(shots):
        tried = replace(scene, balls=_table(scene, number, draw))
        stroke = _stroke(tried, draw)
        seen = simulator(tried, stroke, draw).places
        played.append((tried.balls, stroke, seen))
    parameters = scene.parameters(names)
    begin = np.array([parameter.value for parameter in parameters])
    low = np.maximum([parameter.low for parameter in parameters], begin / MAX_FACTOR)
    high = np.minimum([parameter.high for parameter in parameters], begin * MAX_FACTOR)

    def errors(factors: NDArray[np.float64]) -> NDArray[np.float64]:
        model = exact.with_parameters(names, np.clip(factors * begin, low, high))
        found = np.zeros((shots, 2, 2))
        for error, (balls, stroke, seen) in zip(found, played, strict=True):
            places = simulated(replace(model, balls=balls), stroke, draw).places
            for row, ball in zip(error, (CUE_BALL, FIT_BALL), strict=True):
                if ball in places and ball in seen:  # else one of both was potted
                    row[:] = np.subtract(places[ball], seen[ball])
        return found.ravel()

    fit = least_squares(
        errors,
        np.ones(len(names)),
        bounds=(low / begin - 1e-9, high / begin + 1e-9),
        loss='soft_l1',
        f_scale=USUAL,
        diff_step=PARAMETER_STEP,
        xtol=1e-4,
        ftol=1e-4,
    )
    return scene.with_parameters(names, np.clip(fit.x * begin, low, high))


def _table(scene: Scene, seed: int, draw: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Place the cue ball and a ball at random."""
    state = start('practice', scene, seed, balls=1)
    x, y = draw.choice(places_to_try(state)).tolist()
    return {**state.balls, CUE_BALL: (x, y)}


def _stroke(scene: Scene, draw: np.random.Generator) -> Stroke:
    """Draw a stroke at or past the ball, with the cue as low as clearance allows."""
    x, y = np.subtract(scene.balls[FIT_BALL], scene.balls[CUE_BALL])
    aside = ASIDE * scene.ball.radius * draw.uniform(-1.0, 1.0) / np.hypot(x, y)
    speed = draw.uniform(SLOWEST_CUE, FASTEST_FIT)
    offsets = [(0.0, draw.uniform(-HIGHEST, HIGHEST), 0.0, np.arctan2(y, x) + aside, speed)]
    lifted, playable = raised(scene, np.array(offsets))
    return Stroke.from_offsets(*(lifted[0] if playable[0] else offsets[0]))
