"""Properties of the tracker: detections with errors, losses, wrong names, and motion."""

from contextlib import suppress
import math

from hypothesis import example, given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot.perception.gate import (
    check_count,
    check_name,
    check_position,
    check_quaternion,
    MAX_BALLS,
    MAX_DEVIATION,
    plane_covariance,
)
from billiard_shot.perception.sightings import moved
from billiard_shot.perception.tracker import BallTracker, Detection, TrackerSettings

RADIUS = 0.0286
PERIOD = 1 / 30
TOLERANCE = 1e-3
"""Default of the driver's parameter `table_tolerance` [m]."""

PLACES = {'cue': (-0.4, 0.1), '8': (0.5, 0.2), '3': (0.5, 0.2 + 2 * RADIUS), '9': (0.0, -0.3)}
"""The 3 and the 8 are frozen."""


class Camera:
    """Detects balls with errors; a tracker sees every picture."""

    def __init__(self, noise, seed=0, loss=0.0, swap=0.0, pockets=(), counts=None):
        self.random = np.random.default_rng(seed)
        self.noise, self.loss, self.swap = noise, loss, swap
        self.places, self.time = dict(PLACES), 100.0
        self.kinds = {}  # classes that are not the name of the ball
        self.tracker = BallTracker(RADIUS, TrackerSettings(), pockets, counts or {})

    def picture(self):
        self.time += PERIOD
        names = list(self.places)
        labels = list(names)
        if len(names) > 1 and self.random.random() < self.swap:
            i, k = self.random.choice(len(names), 2, replace=False)
            labels[i], labels[k] = labels[k], labels[i]
        seen = [
            self.detection(self.kinds.get(label, label), self.places[name])
            for name, label in zip(names, labels, strict=True)
            if self.random.random() >= self.loss
        ]
        self.random.shuffle(seen)
        self.tracker.update(seen, self.time)

    def detection(self, kind, place=None):
        """Detection of a ball, or of a class at a place [m]."""
        variance = self.noise**2
        place = self.places[kind] if place is None else place
        seen = tuple((place + self.random.normal(0.0, self.noise, 2)).tolist())
        return Detection(kind, seen, (variance, 0.0, variance))

    def watch(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.picture()
        return self.balls()

    def balls(self):
        return self.tracker.balls(self.time)


@pytest.mark.parametrize('noise', [0.13e-3, 0.5e-3, 2.3e-3])
def test_the_estimate_of_a_resting_ball_has_the_stated_uncertainty(noise):
    """After 2 s the errors of 25 runs have the covariance that the tracker states."""
    errors = []
    for seed in range(25):
        balls = Camera(noise, seed).watch(2.0)
        assert set(balls) == set(PLACES)
        for name, ball in balls.items():
            assert ball.is_seen
            assert not ball.is_moving
            (xx, xy, yy) = ball.covariance
            assert math.sqrt(xx) == pytest.approx(noise / math.sqrt(60), rel=0.3)
            assert xy == 0.0
            error = np.subtract(ball.position, PLACES[name])
            errors += (error / np.sqrt([xx, yy])).tolist()
    assert np.std(errors) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize('noise', [0.13e-3, 0.5e-3])
def test_fifty_of_fifty_shots_are_played_and_moved_balls_noticed(noise):
    """A plan is made after 1 s, its balls are compared for 5 s, then one ball is moved 3 mm."""
    played = noticed = 0
    for seed in range(50):
        camera = Camera(noise, 1000 + seed, loss=0.05, swap=0.02)
        planned = camera.watch(1.0)
        said = ''
        for _ in range(150):
            camera.picture()
            said = said or moved(planned, camera.balls(), TOLERANCE)
        played += not said
        name = list(PLACES)[seed % len(PLACES)]
        heading = camera.random.uniform(-math.pi, math.pi)
        if name in ('3', '8'):
            heading = -math.pi / 2 if name == '8' else math.pi / 2  # away from each other
        x, y = camera.places[name]
        camera.places[name] = x + 3e-3 * math.cos(heading), y + 3e-3 * math.sin(heading)
        noticed += any(
            (camera.picture(), moved(planned, camera.balls(), TOLERANCE))[1] for _ in range(30)
        )
    assert (played, noticed) == (50, 50)


def test_wrong_names_and_losses_change_no_place():
    """A tenth of the pictures have swapped names, a fifth of the detections are lost."""
    camera = Camera(0.5e-3, 5, loss=0.2, swap=0.1)
    camera.watch(1.0)
    for _ in range(300):
        camera.picture()
        balls = camera.balls()
        assert set(balls) == set(PLACES)
        for name, ball in balls.items():
            assert math.dist(ball.position, PLACES[name]) < 1e-3
            assert not ball.is_moving


def test_balls_that_are_exchanged_are_exchanged():
    camera = Camera(0.5e-3, 6)
    camera.watch(2.0)
    camera.places['9'], camera.places['cue'] = camera.places['cue'], camera.places['9']
    balls = camera.watch(3.0)
    assert math.dist(balls['9'].position, PLACES['cue']) < 1e-3
    assert math.dist(balls['cue'].position, PLACES['9']) < 1e-3


def test_a_ball_that_is_hidden_is_not_seen_but_stays_where_it_was():
    camera = Camera(0.5e-3, 7)
    camera.watch(1.0)
    place = camera.places.pop('9')
    before = camera.time
    ball = camera.watch(2.0)['9']
    assert not ball.is_seen
    assert ball.time == pytest.approx(before)
    assert math.dist(ball.position, place) < 1e-3
    assert not camera.tracker.pocketed
    camera.places['9'] = place
    assert camera.watch(0.1)['9'].is_seen


def test_a_ball_at_whose_place_another_one_lies_is_not_seen():
    camera = Camera(0.5e-3, 7)
    camera.watch(1.0)
    x, y = camera.places.pop('9')
    assert camera.watch(0.1)['9'].is_seen
    for place in np.linspace(PLACES['cue'], (x + 1.5 * RADIUS, y), 6):
        camera.places['cue'] = tuple(place.tolist())
        balls = camera.watch(PERIOD)
    assert math.dist(balls['cue'].position, camera.places['cue']) < 2e-3
    assert not balls['9'].is_seen


@pytest.mark.parametrize('speed', [0.05, 0.5, 5.0])
def test_a_ball_that_moves_is_moving_until_it_rests(speed):
    camera = Camera(0.5e-3, 8)
    camera.watch(1.0)
    states = []
    for _ in range(20):
        x, y = camera.places['cue']
        camera.places['cue'] = x + speed * PERIOD, y - 0.3 * speed * PERIOD
        camera.picture()
        states.append(camera.balls()['cue'].is_moving)
    assert not any(states[:1])
    assert all(states[8:]), states
    ball = camera.watch(0.5)['cue']
    assert not ball.is_moving
    assert math.dist(ball.position, camera.places['cue']) < 1e-3
    assert all(not each.is_moving for each in camera.balls().values())


def test_a_single_wrong_detection_moves_nothing():
    """One ball far off, one spurious ball, one detection of two balls at one place."""
    camera = Camera(0.5e-3, 9)
    before = camera.watch(1.0)
    variance = camera.noise**2
    for name, position in (('cue', (0.3, 0.3)), ('8', (-0.39, 0.1)), ('new', (0.1, 0.1))):
        camera.time += PERIOD
        camera.tracker.update([Detection(name, position, (variance, 0.0, variance))], camera.time)
        assert not moved(before, camera.balls(), TOLERANCE), name
        camera.watch(0.2)
    assert set(camera.watch(1.0)) == set(PLACES)


@pytest.mark.parametrize(('pictures', 'last'), [(20, 0.95), (6, 0.7)], ids=['slow', 'fast'])
def test_a_ball_lost_as_it_rolls_into_a_pocket_is_pocketed(pictures, last):
    """The fast ball, 3.4 m/s, is seen last at 24 cm from the pocket."""
    pocket = (1.2, 0.6, 0.06)
    camera = Camera(0.5e-3, 10, pockets=[pocket])
    camera.watch(1.0)
    for share in np.linspace(0.0, last, pictures):
        start, end = np.array(PLACES['8']), np.array(pocket[:2])
        camera.places['8'] = tuple((start + share * (end - start)).tolist())
        camera.picture()
    del camera.places['8']
    balls = camera.watch(1.0)
    assert camera.tracker.pocketed == {'8'}
    assert set(balls) == set(PLACES) - {'8'}
    camera.places['8'] = (0.3, 0.3)
    assert '8' in camera.watch(1.0)
    assert not camera.tracker.pocketed


def test_a_ball_that_is_boxed_twice_is_one_ball():
    """The second box has any class, and is up to half a radius aside."""
    camera = Camera(0.5e-3, 18)
    for k in range(90):
        camera.picture()
        x, y = camera.places['cue']
        aside, heading = camera.random.uniform(0.0, 0.5 * RADIUS), camera.random.uniform(0, 6.3)
        second = x + aside * math.cos(heading), y + aside * math.sin(heading)
        seen = [camera.detection('cue'), camera.detection(('cue', '8', '7')[k % 3], second)]
        camera.time += PERIOD
        camera.tracker.update(seen, camera.time)
        assert set(camera.balls()) <= set(PLACES)
    assert math.dist(camera.watch(1.0)['cue'].position, PLACES['cue']) < 1e-3


def test_a_class_has_no_more_balls_than_its_number():
    """A second cue ball is left out, and told; so is a third solid."""
    camera = Camera(0.5e-3, 19, counts={'solid': 2})
    camera.kinds = {'3': 'solid', '8': 'solid', '9': 'solid'}
    camera.places['other'] = (-0.8, 0.3)
    camera.kinds['other'] = 'cue'
    assert set(camera.watch(5.0)) == {'cue', 'solid', 'solid_2'}
    assert sorted(camera.tracker.surplus) == ['cue', 'solid']


def test_a_ball_is_never_made_by_a_change_of_class():
    """One ball has the class of another one in more and more pictures: there are four balls."""
    camera = Camera(0.5e-3, 20)
    for share in np.linspace(0.0, 1.0, 300):
        camera.kinds = {'9': '7'} if camera.random.random() < share else {}
        camera.picture()
        assert len(camera.balls()) in (0, len(PLACES))
    assert set(camera.balls()) == {'cue', '8', '3', '7'}


def test_a_false_ball_in_few_pictures_or_over_a_pocket_is_no_ball():
    camera = Camera(0.5e-3, 21, loss=0.2, pockets=[(1.2, 0.6, 0.06)])
    camera.watch(1.0)
    for k in range(600):
        camera.picture()
        false = [camera.detection('7', (1.22, 0.61))]  # of the leather, in every picture
        if k % 5 == 0:
            false.append(camera.detection('6', (0.2, 0.2)))
        camera.time += PERIOD
        camera.tracker.update([*map(camera.detection, camera.places), *false], camera.time)
        assert set(camera.balls()) == set(PLACES)


def test_a_false_ball_does_not_bring_back_one_that_was_potted():
    hole = (1.2, 0.6)
    camera = Camera(0.5e-3, 22, pockets=[(*hole, 0.06)])
    camera.watch(1.0)
    for share in np.linspace(0.0, 0.95, 20):
        camera.places['8'] = tuple((1 - share) * np.array(PLACES['8']) + share * np.array(hole))
        camera.picture()
    del camera.places['8']
    for k in range(90):
        camera.time += PERIOD
        false = [camera.detection('8', (-0.2, 0.4))] if k % 5 == 0 else []
        camera.tracker.update([*map(camera.detection, camera.places), *false], camera.time)
    assert camera.tracker.pocketed == {'8'}


def test_two_cameras_may_take_a_picture_at_one_time():
    """Each sees one half of the table; both see the ball in the middle."""
    camera = Camera(0.5e-3, 24)
    for _ in range(60):
        camera.time += PERIOD
        for names in (('cue', '9'), ('3', '8', '9')):
            camera.tracker.update([camera.detection(name) for name in names], camera.time)
    assert set(camera.balls()) == set(PLACES)
    assert all(ball.is_seen for ball in camera.balls().values())


def test_a_ball_that_rattles_in_the_jaws_and_is_seen_no_more_is_pocketed():
    """Its last motion is along the hole and back, not towards it."""
    camera = Camera(0.5e-3, 23, pockets=[(1.2, 0.6, 0.06)])
    camera.places['8'] = (0.9, 0.53)
    camera.watch(1.0)
    for x, y in ((1.0, 0.53), (1.1, 0.53), (1.15, 0.54), (1.17, 0.53), (1.15, 0.53)):
        camera.places['8'] = (x, y)
        camera.picture()
    del camera.places['8']
    camera.watch(1.0)
    assert camera.tracker.pocketed == {'8'}


def test_a_ball_lost_as_it_rolls_past_a_pocket_is_not_pocketed():
    camera = Camera(0.5e-3, 12, pockets=[(1.2, 0.6, 0.06)])
    camera.watch(1.0)
    for x in np.linspace(0.5, 1.0, 6):
        camera.places['8'] = (x, 0.2)
        camera.picture()
    del camera.places['8']
    assert not camera.watch(1.0)['8'].is_seen
    assert not camera.tracker.pocketed


def test_reset_forgets_all_balls():
    camera = Camera(0.5e-3, 11)
    camera.watch(1.0)
    camera.tracker.reset()
    assert not camera.balls()
    del camera.places['8']
    assert set(camera.watch(1.0)) == set(PLACES) - {'8'}


def test_a_camera_without_balls_still_takes_pictures():
    camera = Camera(0.5e-3, 13)
    assert camera.tracker.time == 0.0
    camera.watch(1.0)
    camera.places = {}
    camera.watch(1.0)
    assert camera.tracker.time == camera.time
    assert not any(ball.is_seen for ball in camera.balls().values())
    camera.tracker.reset()
    assert camera.tracker.time == camera.time, 'the time of the last picture does not change'


def test_balls_of_one_class_are_told_apart():
    """Losses and wrong classes change no name; a ball that rolls keeps its name."""
    camera = Camera(0.5e-3, 14, loss=0.05, swap=0.05, counts={'solid': 3})
    camera.kinds = {'3': 'solid', '8': 'solid', '9': 'solid', 'cue': 'cue'}
    names = {name: ball.position for name, ball in camera.watch(1.0).items()}
    assert set(names) == {'cue', 'solid', 'solid_2', 'solid_3'}
    for _ in range(300):
        camera.picture()
        assert set(camera.balls()) == set(names)
        for name, ball in camera.balls().items():
            assert math.dist(ball.position, names[name]) < 2e-3
    rolling = min(names, key=lambda name: math.dist(names[name], PLACES['9']))
    for x in np.linspace(0.1, 0.6, 6):  # 0.1 m between two pictures
        camera.places['9'] = (x, -0.3)
        camera.picture()
    balls = camera.watch(1.0)
    assert set(balls) == set(names)
    assert math.dist(balls[rolling].position, (0.6, -0.3)) < 1e-3


def test_a_numbered_ball_never_takes_the_name_of_a_class():
    camera = Camera(0.5e-3, 15, counts={'red': 2})
    camera.kinds = {'3': 'red', '8': 'red', '9': 'red_2', 'cue': 'cue'}
    balls = camera.watch(1.0)
    assert set(balls) == {'cue', 'red', 'red_2', 'red_3'}
    assert math.dist(balls['red_2'].position, PLACES['9']) < 1e-3


@pytest.mark.parametrize('heading', np.linspace(-math.pi, math.pi, 8, endpoint=False))
@pytest.mark.parametrize('pictures', [3, 5])
def test_a_ball_that_was_pushed_near_a_pocket_is_not_pocketed(heading, pictures):
    """It lies 102 mm from the middle of a hole, is displaced by 4 mm, and is then hidden."""
    camera = Camera(0.5e-3, 16, pockets=[(0.5, 0.302, 0.06)])
    camera.watch(1.0)
    x, y = camera.places['8']
    camera.places['8'] = x + 4e-3 * math.cos(heading), y + 4e-3 * math.sin(heading)
    camera.watch(pictures * PERIOD)
    del camera.places['8']
    assert not camera.watch(1.0)['8'].is_seen
    assert not camera.tracker.pocketed


@pytest.mark.parametrize('speed', [0.05, 0.2, 1.0, 3.0])
@pytest.mark.parametrize('seed', range(3))
def test_a_ball_is_pocketed_in_the_pocket_into_which_it_rolls(speed, seed):
    """It is detected until it is over the hole, as the simulated camera does."""
    hole = np.array([1.2, 0.6])
    camera = Camera(0.5e-3, 100 + seed, loss=0.05, pockets=[(*hole, 0.06)])
    way = hole - PLACES['8']
    length = float(np.hypot(*way))
    start = max(0.0, length - 0.06 - 0.5 * speed)  # it rolls for half a second
    camera.places['8'] = tuple(PLACES['8'] + start / length * way)
    camera.watch(1.0)
    for distance in np.arange(start, length - 0.06, speed * PERIOD):
        camera.places['8'] = tuple(PLACES['8'] + distance / length * way)
        camera.picture()
    del camera.places['8']
    camera.watch(1.0)
    assert camera.tracker.pocketed == {'8'}


def test_a_picture_with_nothing_but_wrong_balls_costs_little():
    """The number of tracks is bounded, and so is the number of pairs."""
    tracker, random = BallTracker(RADIUS), np.random.default_rng(17)
    for k in range(60):
        places = random.uniform(-1.0, 1.0, (MAX_BALLS, 2)).tolist()
        tracker.update(
            [Detection(f'{k} {i}', tuple(p), (1e-7, 0.0, 1e-7)) for i, p in enumerate(places)],
            100.0 + k * PERIOD,
        )
        assert len(tracker._tracks) <= MAX_BALLS
    assert len(tracker.balls(103.0)) <= MAX_BALLS


# --- the gate lets every ball of a real table through, and nothing that could not be one ---------

ANY = st.floats(width=64)
DEVIATION = st.floats(1e-6, 0.7 * MAX_DEVIATION)
ANGLE = st.floats(-math.pi, math.pi)


@given(st.lists(ANY, min_size=3, max_size=3))
@example([1e308, 0.0, 0.0])
@example([0.0, 1e160, 0.0])
def test_positions_are_within_10_m(position):
    if all(abs(each) <= 10.0 for each in position):
        check_position('there', position)
    else:
        with pytest.raises(ValueError, match=r'^there\.[xyz] must be from -10 to 10 m, got \S+$'):
            check_position('there', position)


@given(ANGLE, ANGLE, DEVIATION, DEVIATION, st.floats(0.0, 0.005))
def test_covariances_of_a_camera_that_looks_from_anywhere(turn, tilt, one, other, depth):
    """A rotation keeps a covariance symmetric and positive semi-definite, but for rounding."""
    c, s, k, q = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ [[1, 0, 0], [0, k, -q], [0, q, k]]
    matrix = rotation @ np.diag([one**2, other**2, (0.7 * depth) ** 2]) @ rotation.T
    found = plane_covariance('it', matrix.ravel().tolist())
    assert found == (matrix[0, 0], matrix[0, 1], matrix[1, 1])


def test_a_height_may_be_uncertain_and_an_exact_position_is_a_position():
    assert plane_covariance('it', [1e-8, 0, 0, 0, 1e-8, 0, 0, 0, 1.0]) == (1e-8, 0, 1e-8)
    assert plane_covariance('it', [0.0] * 9) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    'values',
    [
        [-1e-6, 0, 0, 0, -1e-6, 0, 0, 0, 0],
        [1.0, 0, 0, 0, 1e-6, 0, 0, 0, 0],
        [1e-6, 0, 0, 0, 26e-6, 0, 0, 0, 0],
        [1e-6, 5e-7, 0, -5e-7, 1e-6, 0, 0, 0, 0],
        [1e-6, 2e-6, 0, 2e-6, 1e-6, 0, 0, 0, 0],
        [0, 1e-6, 0, 1e-6, 0, 0, 0, 0, 0],
    ],
)
def test_what_is_no_covariance(values):
    words = (
        r'^it must be symmetric and positive semi-definite .* of at most 5 mm, got \[.*\] m\^2$'
    )
    with pytest.raises(ValueError, match=words):
        plane_covariance('it', values)


@given(st.lists(ANY, min_size=9, max_size=9))
@example([1e308] * 9)
@example([5e-324] * 9)
@example([1e-6, math.nan, 0.0, math.nan, 1e-6, 0.0, 0.0, 0.0, 0.0])
def test_any_numbers_are_a_covariance_or_refused(values):
    with suppress(ValueError):
        xx, xy, yy = plane_covariance('it', values)
        assert (xx, xy, yy) == (values[0], values[1], values[4])
        assert 0.0 <= xx <= MAX_DEVIATION**2
        assert 0.0 <= yy <= MAX_DEVIATION**2
        assert abs(xy) <= math.sqrt(xx) * math.sqrt(yy) * (1.0 + 1e-5) + 1e-18


@given(st.text(max_size=70))
@example('8')
@example('x' * 64)
@example('x' * 65)
@example('\x1b[2J')
def test_names_can_be_printed(name):
    if 1 <= len(name) <= 64 and name.isprintable():
        check_name('id', name)
    else:
        with pytest.raises(
            ValueError, match=r'^id must be 1 to 64 printable characters, got'
        ) as no:
            check_name('id', name)
        assert str(no.value).isprintable()


def test_a_refusal_of_a_long_name_is_short():
    with pytest.raises(ValueError, match='must be') as refused:
        check_name('id', 'x' * 1_000_000)
    assert len(str(refused.value)) < 300


class Counted(list):
    """A list whose elements nobody may look at."""

    def __iter__(self):
        raise AssertionError('somebody looked at the elements')

    __getitem__ = __iter__


def test_numbers_are_counted_first():
    check_count('balls', range(64))
    with pytest.raises(ValueError, match=r'^balls must have at most 64 elements, got 100000$'):
        check_count('balls', Counted(['x'] * 100_000))


@given(st.lists(ANY, min_size=4, max_size=4))
@example([0.0, 0.0, 0.0, 0.0])
@example([0.0, 0.0, 0.70711, 0.70711])
@example([1e308] * 4)
def test_quaternions_have_the_length_1(values):
    if 0.995 <= math.hypot(*values) <= 1.005:
        check_quaternion('turn', values)
    else:
        with pytest.raises(ValueError, match=r'^turn must have the length 1, within 0\.005, got'):
            check_quaternion('turn', values)
