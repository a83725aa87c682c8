"""The story of a search: its stages are those of the planner, and its numbers add up."""

import numpy as np

from billiard_shot import Scene
from billiard_shot.study.planning_story import tell


def test_a_hidden_ball_is_potted_by_a_kick():
    story = tell(Scene.load('blocked'), '8')
    straight, curves, kicks = story.stages
    assert not len(straight.strokes)  # ball 1 is in the way
    assert curves.reached.sum() > 10 * kicks.reached.sum() > 0
    best = [stage.refined[-1].success.max() for stage in (curves, kicks)]
    assert best[1] > 2.0 * best[0]  # with errors it is the other way around
    winner = story.finalists[0]
    kept = kicks.refined[-1].strokes
    assert (np.abs(kept - winner.stroke) < 1e-12).all(axis=1).any()
    assert abs(winner.successes / winner.trials - best[1]) < 0.1  # fresh errors say the same
