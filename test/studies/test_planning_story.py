"""The story of a search: its stages are those of the planner, and its numbers add up."""

import numpy as np

from billiard_shot import Scene
from studies.planning_story import tell


def test_a_hidden_ball_is_potted_by_a_kick():
    story = tell(Scene.load('blocked'), '8')
    # Ball 1 is in the way of straight paths. With such a kick the search needs no curves.
    assert [stage.name for stage in story.stages] == ['combinations', 'one cushion']
    combinations, kicks = story.stages
    # No kick of the first list pots the ball without errors: the search refines near misses.
    assert combinations.reached.sum() > kicks.reached.sum()
    best = [stage.refined[-1].success.max() for stage in (combinations, kicks)]
    assert best[1] > 1.5 * best[0]  # with errors it is the other way around
    winner = story.finalists[0]
    kept = kicks.refined[-1].strokes
    assert (np.abs(kept - winner.stroke.offsets) < 1e-12).all(axis=1).any()
    assert abs(winner.success - best[1]) < 0.1  # fresh errors say the same
