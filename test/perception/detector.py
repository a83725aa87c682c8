"""
A model of a detector of balls, with the errors of a network that looks at a real table.

The detector loses balls, boxes a ball twice, takes a ball for another one, and sees balls at
pockets and on a hand. The hand passes over the table and hides the balls below it.
"""

from dataclasses import dataclass
import math

import numpy as np

from billiard_shot import predict, Scene, Stroke
from billiard_shot.perception.tracker import BallTracker, Detection
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.outline import outline_of

PERIOD = 1 / 30
"""Time between two pictures [s]."""

BEFORE = 2.0
"""Time of pictures before a stroke [s]."""


@dataclass(frozen=True)
class Detector:
    """Errors of a detector; shares are those of the detections, if nothing else is said."""

    noise: float = 0.7e-3  # standard deviation of a coordinate, m
    loss: float = 0.2
    doubled: float = 0.05
    second_box: float = 4e-3  # standard deviation of the place of a second box, m
    wrong_class: float = 0.1
    at_pocket: float = 0.03  # share of the pictures with a false ball, for each pocket
    on_hand: float = 0.3  # share of the pictures of a hand with a false ball
    hand: float = 0.12  # radius of the hand, m
    lost_before: float = 0.0  # distance from the edge of a hole within which no ball is seen, m


class Seen:
    """A shot as a detector sees it: a tracker takes the pictures."""

    def __init__(self, scene, stroke, seed, detector=None, after=3.0):
        self.scene, self.random = scene, np.random.default_rng(seed)
        self.detector = detector or Detector()
        self.run = predict(scene, stroke).run
        self.holes = outline_of(scene).holes
        self.tracker = BallTracker(scene.ball.radius, pockets=self.holes)
        self.end = self.run.duration + after
        self.hands = []  # begin, end [s], way of a hand
        self.times = np.arange(-BEFORE, self.end, PERIOD)
        at = np.clip(self.times, 0.0, self.run.duration)
        states = {name: motion.at(at) for name, motion in self.run.balls.items()}
        self.places = {name: state.position[:, :2] for name, state in states.items()}
        self.on_table = {
            name: ~np.isin(state.motion, (Motion.POCKETED, Motion.OFF_TABLE))
            for name, state in states.items()
        }

    def pass_hand(self, begin, end):
        """Let a hand pass over the table between two times [s]."""
        half = 0.5 * np.array([self.scene.table.length, self.scene.table.width])
        self.hands.append((begin, end, self.random.uniform(-half, half, (2, 2))))

    def watch(self, until=math.inf):
        """Take the next pictures; return the balls of the tracker after them."""
        seen = [k for k, time in enumerate(self.times) if time <= until]
        for k in seen:
            self.tracker.update(self.picture(k), 100.0 + self.times[k])
        self.now = self.times[seen[-1]]
        self.times = self.times[len(seen) :]
        for each in (self.places, self.on_table):
            each.update({name: values[len(seen) :] for name, values in each.items()})
        return self.tracker.balls(100.0 + self.now)

    def picture(self, k):
        detector, random = self.detector, self.random
        hand = self.hand_at(self.times[k])
        found = []
        for name, places in self.places.items():
            place = places[k]
            hidden = hand is not None and math.dist(hand, place) < detector.hand
            if self.on_table[name][k] and not (hidden or self.over_hole(place)):
                if random.random() >= detector.loss:
                    found.append(self.detection(name, place))
                if random.random() < detector.doubled:
                    found.append(self.detection(name, place, detector.second_box))
        for x, y, size in self.holes:
            if random.random() < detector.at_pocket:
                found.append(self.detection(self.any_name(), (x, y), 0.7 * size))
        if hand is not None and random.random() < detector.on_hand:
            found.append(self.detection(self.any_name(), hand, 0.02))
        random.shuffle(found)
        return found

    def any_name(self):
        return str(self.random.choice(list(self.places)))

    def over_hole(self, place):
        lost = self.detector.lost_before
        return lost > 0.0 and any(
            math.dist(place, (x, y)) < size + lost for x, y, size in self.holes
        )

    def detection(self, name, place, more=0.0):
        detector = self.detector
        if self.random.random() < detector.wrong_class:
            name = self.any_name()
        error = self.random.normal(0.0, math.hypot(detector.noise, more), 2)
        variance = detector.noise**2
        return Detection(name, tuple((place + error).tolist()), (variance, 0.0, variance))

    def hand_at(self, time):
        for begin, end, (start, goal) in self.hands:
            if begin <= time <= end:
                return start + (time - begin) / (end - begin) * (goal - start)
        return None

    def left(self):
        """Places of the balls that are on the table at the end [m]."""
        return {name: tuple(place) for name, place in self.run.places_left.items()}


def a_break(seed, **errors):
    """A break of eight-ball that a detector sees, with a hand that passes at a random time."""
    scene = Scene.load('eight_ball')
    random = np.random.default_rng(seed)
    a, b = random.uniform(-0.2, 0.2, 2)
    x, y = scene.balls['cue']
    azimuth = math.atan2(-y, scene.table.length / 4 - x) + random.normal(0.0, 0.01)
    speed = random.uniform(5.0, 9.0)
    stroke = Stroke.from_offsets(a, b, elevation_deg=3.0, azimuth=azimuth, speed=speed)
    seen = Seen(scene, stroke, seed, Detector(**errors))
    begin = random.uniform(0.5, seen.end - 3.5)
    seen.pass_hand(begin, begin + random.uniform(0.5, 1.5))
    return seen
