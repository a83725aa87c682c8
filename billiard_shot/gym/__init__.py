"""Environments of Gymnasium: practice on many tables at once, and eight-ball with an opponent."""

import gymnasium

from billiard_shot.gym.environments import (
    action_of,
    EightBallEnv,
    PracticeEnv,
    PracticeVectorEnv,
    strokes_of,
)

__all__ = ['EightBallEnv', 'PracticeEnv', 'PracticeVectorEnv', 'action_of', 'strokes_of']

gymnasium.register(
    'BilliardShot/Practice-v0',
    entry_point='billiard_shot.gym.environments:PracticeEnv',
    vector_entry_point='billiard_shot.gym.environments:PracticeVectorEnv',
)
gymnasium.register(
    'BilliardShot/EightBall-v0', entry_point='billiard_shot.gym.environments:EightBallEnv'
)
