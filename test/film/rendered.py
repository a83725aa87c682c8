"""
Films of a table that is not there: their truth is known.

A camera with tangential terms and a sixth-order term, which no fit here has, looks at bed, noses,
rails with sights, and balls. The background is cast once, ray by ray; balls and their shadows are
cast for each picture, over the exposure, each row at its own time. Light is linear until the end.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
import math

import av
import cv2
import numpy as np

from billiard_shot import BallState, Scene, simulate
from billiard_shot.pictures.canvas import ball_colour, is_striped
from billiard_shot.table.model.motion import Motion as MotionCode
from billiard_shot.table.run.outline import outline_of

LAMPS = (-0.6, 0.1, 1.1), (0.7, -0.1, 1.2)  # m, above the table
CLOTHS = {'blue': (0.02, 0.10, 0.33), 'green': (0.02, 0.20, 0.09), 'pool': (0.004, 0.23, 0.49)}
WOOD, FLOOR, SIGHT = (0.10, 0.05, 0.03), (0.12, 0.11, 0.10), (0.8, 0.8, 0.75)
GONE = MotionCode.POCKETED, MotionCode.OFF_TABLE
GAMMA, FINE, DARK = 2.2, 2, 0.35
SIGHT_RADIUS, SIGHT_AWAY, RAIL_UP = 0.006, 0.094, 0.004  # m; the last: above the nose


@dataclass(frozen=True)
class View:
    """A camera: its place and what it looks at [m], focal length [px], and its lens."""

    place: tuple
    at: tuple = (0.02, -0.01, 0.0)
    size: tuple = (1280, 720)
    focal: float = 1093.0
    lens: tuple = (-0.06, 0.02, 5e-4, -4e-4, -0.004)
    up: tuple = (0.03, 1.0, 0.0)  # the direction of the table that is up in the picture

    @property
    def axes(self):
        """Rows: right, down, ahead."""
        ahead = np.subtract(self.at, self.place)
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, self.up)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(ahead, right), ahead])

    @lru_cache(4)  # noqa: B019
    def rays(self):
        """Directions (height, width, 3) of pixels, and their slopes along v and u."""
        points = np.stack(np.meshgrid(*map(np.arange, self.size)), -1).astype(np.float64)
        middle = 0.5 * (np.array(self.size) - 1.0)
        matrix = np.array([[self.focal, 0, middle[0]], [0, self.focal, middle[1]], [0, 0, 1]])
        flat = cv2.undistortPoints(
            points.reshape(-1, 1, 2), matrix, np.array(self.lens), criteria=(3, 20, 1e-9)
        ).reshape(points.shape)
        ahead = np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], -1) @ self.axes
        ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
        return ahead, *np.gradient(ahead, axis=(0, 1))

    def pixel(self, points):
        """Pixels (n, 2) of points (n, 3) [m]."""
        middle = 0.5 * (np.array(self.size) - 1.0)
        matrix = np.array([[self.focal, 0, middle[0]], [0, self.focal, middle[1]], [0, 0, 1]])
        seen = (np.atleast_2d(points) - self.place) @ self.axes.T
        zero = np.zeros(3)
        return cv2.projectPoints(seen, zero, zero, matrix, np.array(self.lens))[0].reshape(-1, 2)


OVERHEAD = View((0.05, -0.04, 2.75))
OBLIQUE = View((-0.3, -2.3, 1.9), (0.0, -0.12, 0.0), focal=1150.0)


@dataclass(frozen=True)
class Filming:
    """How a film is taken; times in s."""

    view: View = OVERHEAD
    rate: float = 60.0
    exposure: float = 1 / 250
    readout: float = 0.012
    cloth: str = 'blue'
    bit_rate: int = 8_000_000
    noise: float = 1.5  # of 255
    shake: float = 0.0  # px, of a hand
    hand: bool = True
    lamps: tuple = LAMPS


def dot(one, other):
    """Dot products of rows."""
    return np.einsum('...i,...i', one, other)


def length(rows):
    """Lengths of rows."""
    return np.sqrt(dot(rows, rows))


def unit(rows):
    """Rows of length 1."""
    return rows / length(rows)[..., np.newaxis]


class Motion:
    """Places (n, 3) [m] of each ball at times (n,) [s], of shots one after the other."""

    def __init__(self, scene, shots, seed=1, rest=0.8, longest=9.0, speed=(1.5, 3.5)):
        draw = np.random.default_rng(seed)
        radius = scene.ball.radius
        self.radius, self.starts, self.strikers = radius, [], []
        places = {name: (*place, radius) for name, place in scene.balls.items()}
        self.times, self.places, now = [0.0], {name: [at] for name, at in places.items()}, rest
        for _ in range(shots):
            others = [name for name in places if name != 'cue']
            to = np.subtract(places[others[draw.integers(len(others))]], places['cue'])[:2]
            angle = math.atan2(to[1], to[0]) + draw.normal(0, 0.03)
            fast = draw.uniform(*speed)
            ahead = np.array([math.cos(angle), math.sin(angle), 0.0])
            spin = fast / radius * draw.uniform(-0.3, 0.9)
            states = {name: BallState(position=place) for name, place in places.items()}
            states['cue'] = BallState(
                position=places['cue'],
                velocity=tuple(fast * ahead),
                spin=(-spin * ahead[1], spin * ahead[0], fast / radius * draw.uniform(-0.4, 0.4)),
            )
            run = simulate(scene, states)
            end = min(run.duration, longest)
            times = np.arange(0.0, end, 0.002)
            self.starts.append(now)
            self.strikers.append((now, np.array(places['cue']), ahead))
            at = run.at(times)
            self.times += (now + times).tolist()
            for name in places:
                here = at[name].position.copy()
                here[np.isin(at[name].motion, GONE), 2] = 0.0
                self.places[name] += here.tolist()
            now += end + rest
            places = {name: tuple(self.places[name][-1]) for name in places}
        self.end = now
        self.times = np.array(self.times)
        self.places = {name: np.array(way) for name, way in self.places.items()}

    def at(self, name, times):
        """Places (..., 3) of a ball."""
        way = self.places[name]
        return np.stack([np.interp(times, self.times, way[:, k]) for k in range(3)], -1)


def light(points, lamps):
    """Light on places (..., 3) of the table: lamps, and some from all around."""
    away = lamps - points[..., np.newaxis, :]
    far = length(away)
    return 0.35 + 0.55 * (away[..., 2] / far**3).sum(-1)


def background(scene, filming):
    """Cast the table without balls: linear (height, width, 3)."""
    return _background(replace(scene, balls={}), filming.view, filming.cloth, filming.lamps)


@lru_cache(8)
def _background(scene, view, cloth, lamps):
    outline, rays = outline_of(scene), view.rays()
    (width, height), up = view.size, outline.height
    fine = 2 * FINE
    grid = (np.arange(fine) + 0.5) / fine - 0.5
    total = np.zeros((height, width, 3), np.float32)
    half = 0.5 * np.array([scene.table.length, scene.table.width])
    cloth = np.array(CLOTHS[cloth])
    fractions = np.arange(-3, 4) / 4, np.arange(-1, 2) / 2
    sights = [(f * half[0], s * (half[1] + SIGHT_AWAY)) for f in fractions[0] for s in (-1, 1)]
    sights += [(s * (half[0] + SIGHT_AWAY), f * half[1]) for f in fractions[1] for s in (-1, 1)]
    if len(outline.holes):
        sights = [(x, y) for x, y in sights if abs(x) > 1e-9 or abs(y) < half[1]]
    for dv in grid:
        for du in grid:
            ray = rays[0] + dv * rays[1] + du * rays[2]
            top, bed, rail = (
                view.place + ray * ((z - view.place[2]) / ray[..., 2:])
                for z in (up, 0.0, up + RAIL_UP)
            )
            beyond = (np.abs(top[..., :2]) - half).max(-1)
            under = (np.abs(bed[..., :2]) - half).max(-1)
            shaded = light(bed, lamps) * np.clip(
                0.72 - under / 0.05, 0.72, 1.0
            )  # the nose's shadow
            shaded = np.where(under > 0, 0.45, shaded)  # its face
            brightness = np.where(beyond > 0, 1.25 * light(top, lamps), shaded)[..., np.newaxis]
            colour = brightness * cloth
            wooden = (np.abs(rail[..., :2]) > outline.back).any(-1)
            colour[wooden] = WOOD
            for x, y in sights:
                near = np.hypot(rail[..., 0] - x, rail[..., 1] - y) < SIGHT_RADIUS
                colour[near] = SIGHT
            for x, y, radius in outline.holes:
                colour[np.hypot(top[..., 0] - x, top[..., 1] - y) < radius] = 0.004
            colour[(np.abs(rail[..., :2]) > outline.frame).any(-1)] = FLOOR
            total += colour.astype(np.float32)
    return total / fine**2


class Painter:
    """Pictures (height, width, 3), RGB, of a motion at times."""

    def __init__(self, scene, motion, filming, seed=5):
        self.motion, self.filming, self._rays = motion, filming, filming.view.rays()
        self.behind = background(scene, filming)
        self._kept = {}
        draw = np.random.default_rng(seed)
        size = self.behind.shape
        self._draw, self._flat = draw, self._encoded(self.behind)
        larger = (size[0] + 64, size[1] + 64, 3)
        self._noise = draw.normal(0, filming.noise, larger).astype(np.float32)
        self._axes = {name: draw.normal(size=3) for name in motion.places}
        self._shake = np.zeros(2)

    def _encoded(self, linear):
        return 255.0 * np.clip(linear, 0, 1) ** (1 / GAMMA)

    def at(self, time):
        """Paint the picture whose first row is read at a time."""
        filming, motion = self.filming, self.motion
        picture = self._flat.copy()
        patches = []
        for name in motion.places:
            place = motion.at(name, time)
            if place[2] < 0.5 * motion.radius:
                continue  # in a pocket
            u, v = filming.view.pixel(place)[0]
            reach = filming.view.focal * motion.radius / np.linalg.norm(place - filming.view.place)
            step = filming.view.pixel(motion.at(name, time + 0.02))[0] - (u, v)
            patches.append((u, v, 3.5 * reach + 1.5 * np.abs(step).max()))
        for u, v, reach in patches:
            rows, columns = self._window(u, v, reach)
            if rows.stop > rows.start and columns.stop > columns.start:
                picture[rows, columns] = self._encoded(self._cast(rows, columns, time))
        if filming.hand:
            self._add_hand(picture, time)
        du, dv = self._draw.integers(0, 64, 2)
        picture += self._noise[dv : dv + picture.shape[0], du : du + picture.shape[1]]
        if filming.shake:
            self._shake = 0.97 * self._shake + self._draw.normal(0, 0.25 * filming.shake, 2)
            move = np.float64([[1, 0, self._shake[0]], [0, 1, self._shake[1]]])
            picture = cv2.warpAffine(picture, move, picture.shape[1::-1], flags=cv2.INTER_CUBIC)
        return np.clip(picture + 0.5, 0, 255).astype(np.uint8)

    def _window(self, u, v, reach):
        height, width = self.behind.shape[:2]
        rows = slice(max(int(v - reach), 0), max(min(int(v + reach) + 1, height), 0))
        return rows, slice(max(int(u - reach), 0), max(min(int(u + reach) + 1, width), 0))

    def _cast(self, rows, columns, time):
        """Cast a window: all balls that reach into it, over the exposure."""
        filming, motion, view = self.filming, self.motion, self.filming.view
        v = np.arange(rows.start, rows.stop, dtype=float)[:, np.newaxis]
        grid = (np.arange(FINE) + 0.5) / FINE - 0.5
        ray, down, right = (each[rows, columns] for each in self._rays)
        ray = np.stack([ray + a * down + b * right for a in grid for b in grid])
        behind = np.broadcast_to(self.behind[rows, columns], ray.shape)
        bed = view.place + ray * (-view.place[2] / ray[..., 2:])
        row_times = time + filming.readout * v / self.behind.shape[0]
        middle = time + filming.readout * v.mean() / self.behind.shape[0]
        near = []
        for name in motion.places:
            place = motion.at(name, middle)
            distance = length(bed[..., :2] - place[:2]).min()
            if distance < 8 * motion.radius and place[2] > 0.5 * motion.radius:
                near.append(name)
        moves = any(np.ptp(motion.at(n, middle + np.array([-0.02, 0.02])), 0).any() for n in near)
        key = rows.start, columns.start, *(x for n in near for x in motion.at(n, middle))
        if not moves and key in self._kept:
            return self._kept[key]
        steps = 7 if moves else 1
        total = np.zeros(behind.shape[1:])
        for part in (np.arange(steps) + 0.5) / steps:
            places = {n: motion.at(n, row_times + part * filming.exposure) for n in near}
            colour = behind.copy()
            for place in places.values():  # (rows, 1, 3)
                for lamp in np.array(filming.lamps):
                    foot = place[..., :2] + (place[..., :2] - lamp[:2]) * motion.radius / lamp[2]
                    far = length(bed[..., :2] - foot) / motion.radius
                    colour *= (1 - DARK * np.clip(1.8 - 1.3 * far, 0, 1))[..., np.newaxis]
            nearest = np.full(ray.shape[:-1], np.inf)
            for name, place in places.items():
                self._put_ball(colour, nearest, ray, name, place)
            total += colour.mean(0)
        if not moves:
            self._kept[key] = total
        return total / steps

    def _put_ball(self, colour, nearest, ray, name, place):
        radius, eye = self.motion.radius, np.array(self.filming.view.place)
        to = place - eye
        to = np.broadcast_to(to, ray.shape)
        along = dot(ray, to)
        under = along**2 - dot(to, to) + radius**2
        far = along - np.sqrt(np.maximum(under, 0))
        hit = (under > 0) & (far < nearest)
        nearest[hit] = far[hit]
        ray, far, place = ray[hit], far[hit], np.broadcast_to(place, ray.shape)[hit]
        normal = (eye + ray * far[:, np.newaxis] - place) / radius
        paint = np.tile(_linear(ball_colour(name)), (len(far), 1))
        if is_striped(name) and len(far):
            turned = self._axes[name] / np.linalg.norm(self._axes[name])
            spin = place[0].sum() / radius  # some turn that follows the way
            axis = turned * math.cos(spin) + np.roll(turned, 1) * math.sin(spin)
            white = np.abs(normal @ (axis / np.linalg.norm(axis))) > 0.5
            paint[white] = _linear('#fbfaf3')
        shade, shine = np.full(len(far), 0.25), np.zeros(len(far))
        for lamp in np.array(self.filming.lamps):
            away = unit(lamp - place)
            shade += 0.5 * np.clip(dot(normal, away), 0, 1)
            shine += 0.7 * np.clip(dot(normal, unit(away - ray)), 0, 1) ** 90
        colour[hit] = paint * shade[:, np.newaxis] + shine[:, np.newaxis]

    def _add_hand(self, picture, time):
        """Add a cue and a hand around each strike."""
        for start, place, ahead in self.motion.strikers:
            before = start - time
            if -0.6 < before < 0.7:
                back = (
                    0.02 + 0.25 * abs(math.sin(4 * before)) if before > 0 else 0.03 - 1.2 * before
                )
                tip = place - ahead * (self.motion.radius + back)
                end = tip - 1.3 * ahead
                bridge = tip - (0.16 + max(-before, 0)) * ahead
                points = self.filming.view.pixel(np.stack([tip, end, bridge]))
                a, b, c = [tuple(int(8 * x) for x in each) for each in points]
                cv2.line(picture, a, b, (205.0, 170.0, 120.0), 6, cv2.LINE_AA, 3)
                size = int(8 * self.filming.view.focal * 0.045 / self.filming.view.place[2])
                cv2.circle(picture, c, size, (190.0, 140.0, 115.0), -1, cv2.LINE_AA, 3)


def _linear(code):
    return (np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0) ** GAMMA


def write_film(path, painter, times, codec='libx264'):
    """Write a film; times [s] may be at any rate."""
    filming = painter.filming
    with av.open(str(path), 'w') as out:
        stream = out.add_stream(codec, rate=Fraction(filming.rate).limit_denominator(1000))
        stream.width, stream.height = filming.view.size
        stream.pix_fmt, stream.bit_rate = 'yuv420p', filming.bit_rate
        stream.time_base = stream.codec_context.time_base = Fraction(1, 90000)
        stream.options = {'preset': 'veryfast'}
        for time in times:
            frame = av.VideoFrame.from_ndarray(painter.at(time), 'rgb24')
            frame.pts, frame.time_base = round(time * 90000), Fraction(1, 90000)
            out.mux(stream.encode(frame))
        out.mux(stream.encode())


def filmed(path, scene, filming, shots=1, seed=1, **how):
    """Write a film of shots, and return their motion."""
    scene = Scene.load(scene) if isinstance(scene, str) else scene
    motion = Motion(scene, shots, seed, **how)
    times = np.arange(0.0, motion.end, 1.0 / filming.rate)
    write_film(path, Painter(scene, motion, filming), times)
    return motion


class Placed:
    """Balls that lie where `places` (x, y, z) [m] says; z = 0: not on the table."""

    def __init__(self, names, radius):
        self.radius, self.strikers, self.places = radius, [], dict.fromkeys(names, (0.0,) * 3)

    def put(self, places):
        """Take all balls away, and put some at places (x, y) [m]."""
        self.places = dict.fromkeys(self.places, (0.0,) * 3)
        self.places |= {name: (x, y, self.radius) for name, (x, y) in places.items()}

    def at(self, name, times):
        """Places (..., 3) of a ball."""
        return np.broadcast_to(self.places[name], (*np.shape(times), 3))
