"""Environments of Gymnasium: practice on many tables at once, and eight-ball with an opponent."""

import gymnasium

from billiard_shot.gym.actions import action_of, strokes_of
from billiard_shot.gym.eight_ball import EightBallEnv
from billiard_shot.gym.practice import PracticeEnv, PracticeVectorEnv

__all__ = ['EightBallEnv', 'PracticeEnv', 'PracticeVectorEnv', 'action_of', 'strokes_of']

gymnasium.register(
    'BilliardShot/Practice-v0',
    entry_point='billiard_shot.gym.practice:PracticeEnv',
    vector_entry_point='billiard_shot.gym.practice:PracticeVectorEnv',
)
gymnasium.register(
    'BilliardShot/EightBall-v0', entry_point='billiard_shot.gym.eight_ball:EightBallEnv'
)
