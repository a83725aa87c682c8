"""When all balls rest."""

from dataclasses import replace

from billiard_shot.perception.sightings import REST_DISTANCE, REST_TIME, RestWatch, Sighting

LYING = {'cue': Sighting((0.1, 0.2)), '8': Sighting((0.5, 0.0))}


def test_balls_that_lie_long_enough_rest():
    watch = RestWatch()
    assert watch.restless(LYING, 0.0)
    assert watch.restless(LYING, 0.9 * REST_TIME) == 'the balls have not rested for 0.5 s'
    assert not watch.restless(LYING, 1.1 * REST_TIME)


def test_a_ball_that_creeps_moves_on():
    watch = RestWatch()
    watch.restless(LYING, 0.0)
    for step in range(1, 20):
        creeping = LYING | {'8': Sighting((0.5 + 1.1 * step * REST_DISTANCE, 0.0))}
        assert watch.restless(creeping, step * REST_TIME) == "ball '8' moves on"


def test_a_ball_that_is_not_seen_or_comes_anew_does_not_rest():
    watch = RestWatch()
    watch.restless(LYING, 0.0)
    hidden = LYING | {'cue': replace(LYING['cue'], is_seen=False)}
    assert watch.restless(hidden, 1.0) == "ball 'cue' is not seen"
    moving = LYING | {'cue': replace(LYING['cue'], is_moving=True)}
    assert watch.restless(moving, 2.0) == "ball 'cue' moves on"
    assert watch.restless(LYING, 2.1)
    assert watch.restless({'8': LYING['8']}, 9.0)
    assert not watch.restless({'8': LYING['8']}, 10.0)


def test_a_ball_that_is_not_seen_counts_as_resting_after_a_while():
    """The others must rest meanwhile; a ball that appears begins anew."""
    watch = RestWatch()
    hidden = LYING | {'cue': replace(LYING['cue'], is_seen=False, is_moving=True)}
    for now in (0.0, 1.0, 5.0):
        assert watch.restless(hidden, now, unseen_time=5.0) == "ball 'cue' is not seen"
    assert not watch.restless(hidden, 5.1, unseen_time=5.0)
    assert watch.restless(hidden, 99.0) == "ball 'cue' is not seen"
    assert watch.restless(LYING, 99.1, unseen_time=5.0)
    assert watch.restless(hidden, 99.2, unseen_time=5.0) == "ball 'cue' is not seen"
    rolling = hidden | {'8': replace(LYING['8'], is_moving=True)}
    assert watch.restless(rolling, 110.0, unseen_time=5.0) == "ball '8' moves on"
