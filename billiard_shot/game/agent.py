"""Interfaces of players, who decide on strokes, and of simulators, which play them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from billiard_shot.game.call import Decision
from billiard_shot.game.outcome import Outcome, outcome_of
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene import Scene
from billiard_shot.shot.predict import predict
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


MakeAgent = Callable[[Scene, int], Agent]
"""Makes an agent from the scene with which it plans and the seed of its random numbers."""
