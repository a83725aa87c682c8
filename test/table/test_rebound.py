"""
A ball against the nose of a cushion: published equations, a scheme of small steps, continuity.

The paper of Mathavan, Jackson and Parkin (2010) prints plots, no tables: so its equations 12 to 17
are integrated here as it says, with its parameters, over the rebounds that it plots. For a ball in
the air there is a scheme of small steps in time, in which the cloth takes the impulse of each step
that its restitution asks for (Moreau 1988).
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from tables import POOL, R, scene_with

from billiard_shot import BallState, EventKind, simulate, simulate_batch, Status
from billiard_shot.impact import Body, collide, Contact
from billiard_shot.scene.equipment import is_instant_beside
from billiard_shot.table.contacts.rebound import follow, VX, VY, VZ, WX, WY, WZ, Z
from billiard_shot.table.model.motion import BallRecord, Rebound, start_ball
from billiard_shot.table.motion.ball_impact import collide_fixed
from billiard_shot.table.run.effects import params_on_table

# Snooker (section 4): restitution, friction at cushion and cloth, height of the nose (eq. 1).
RESTITUTION, CUSHION, CLOTH, SINE = 0.98, 0.14, 0.212, 0.4
COSINE = np.sqrt(1 - SINE**2)
TURN = 2.5  # m r^2 / I of a solid ball
BOUNCE = 0.5, 0.2  # restitution and friction of the cloth, if a ball lands
STEPS = 20_000  # of the compression, about
PLANE, SPIN = (VX, VY, VZ), (WX, WY, WZ)


def rebounds(velocity, spin, height=0.0, sine=SINE, friction=CUSHION, tolerance=1e-8, **changes):
    """Velocity, spin, height and duration after a contact, in the units of rebound.py."""
    r = Rebound()
    scale = max(*np.abs(velocity), *np.abs(spin))
    for names, vector in ((PLANE, velocity), (SPIN, spin)):
        for name, value in zip(names, vector, strict=True):
            r.state[name] = value / scale
    r.state[Z], r.held = height / scale, height == 0.0
    r.sine, r.cosine, r.turn = sine, np.sqrt(1 - sine**2), TURN
    r.restitution, r.nose_friction, r.cloth_friction = RESTITUTION, friction, CLOTH
    r.bounce_restitution, r.bounce_friction = BOUNCE
    for name, value in changes.items():
        setattr(r, name, value)
    assert follow(r, tolerance)
    state = np.array(r.state) * scale
    return state[list(PLANE)], state[list(SPIN)], state[Z], r.time


def rates(state):
    """Change of (vx, vy, wx, wy, wz) per impulse, for unit mass and radius; equations 12 to 17."""
    vx, vy, wx, wy, wz = state
    at_cushion = np.arctan2(-vy * SINE + wx, vx + wy * SINE - wz * COSINE)
    at_cloth = np.arctan2(vy + wx, vx - wy)
    x, y = np.cos(at_cushion), np.sin(at_cushion)
    press = CLOTH * (SINE + CUSHION * y * COSINE)
    h, k = press * np.cos(at_cloth), press * np.sin(at_cloth)
    return np.array(
        [
            -CUSHION * x - h,
            -COSINE + CUSHION * SINE * y - k,
            -TURN * (CUSHION * y + k),
            -TURN * (CUSHION * x * SINE - h),
            TURN * CUSHION * x * COSINE,
        ]
    )


def mathavan(speed, angle, topspin, sidespin):
    """Rebounds (n, 5), by Heun's method; the work-energy restitution of section 3.3."""
    cos, sin = np.cos(angle), np.sin(angle)
    state = speed * np.array([cos, sin, -topspin * sin, topspin * cos, sidespin])
    step = state[1] / COSINE / STEPS
    work, goal = np.zeros_like(speed), np.full_like(speed, np.inf)
    active = np.full(speed.shape, True)
    while active.any():
        slope = rates(state)
        after = state + 0.5 * step * (slope + rates(state + step * slope))
        done = 0.5 * step * COSINE * np.abs(state[1] + after[1])
        turned = (state[1] > 0) & (after[1] <= 0)
        work = np.where(active, work + done, work)
        goal = np.where(turned & active, RESTITUTION**2 * work, goal)
        work = np.where(turned & active, 0.0, work)
        state = np.where(active, after, state)
        active = active & (work < goal)
    return state.T


# Angles, topspins (1: it rolls) and sidespins of the paper's plots.
def test_rebounds_of_a_lying_ball_are_those_of_the_published_equations():
    angles, topspins = np.radians([5, 15, 30, 45, 60, 75, 85]), [-1.0, 0.0, 0.5, 1.0, 2.0]
    sidespins = [-2, -1, -0.3, 0.4, 1, 2]
    angle, topspin, sidespin = map(np.ravel, np.meshgrid(angles, topspins, sidespins))
    expected = mathavan(np.ones_like(angle), angle, topspin, sidespin)
    for i, (vx, vy, wx, wy, wz) in enumerate(expected):
        cos, sin = np.cos(angle[i]), np.sin(angle[i])
        velocity, spin, height, _ = rebounds(
            (cos, sin, 0.0),
            (-topspin[i] * sin, topspin[i] * cos, sidespin[i]),
            tolerance=1e-6,
        )
        # the scheme's own slip directions tremble about zero slip, by its step
        assert velocity == pytest.approx([vx, vy, 0.0], abs=1e-4)
        assert spin == pytest.approx([wx, wy, wz], abs=1e-4)
        assert height == 0.0


@dataclass
class Steps:
    """The same contact in small steps of time: the cloth takes its impulse at the end of each."""

    velocity: np.ndarray
    spin: np.ndarray
    height: float
    sine: float
    step: float = 2e-4
    stiffness: float = 0.0  # of the tangential spring; 0: none

    def run(self):
        """Return velocity, spin and height after the contact."""
        v, w, z = np.array(self.velocity), np.array(self.spin), self.height
        deflection = np.zeros(3)
        normal = np.array([0.0, -np.sqrt(1 - self.sine**2), -self.sine])
        y = 0.0
        while True:
            closing = -normal @ v
            y += self.step * (closing if closing > 0 else closing / RESTITUTION**2)
            if y < 0:
                return v, w, z
            push = self.step * y
            if self.stiffness:
                slip = v + np.cross(w, -normal)
                deflection += self.step * (slip - (slip @ normal) * normal)
                size = np.linalg.norm(deflection)
                deflection *= min(1.0, CUSHION * y / self.stiffness / max(size, 1e-300))
                friction = -self.step * self.stiffness * deflection
                v += friction
                w += TURN * np.cross(-normal, friction)
            else:
                self.rub(v, w, -normal, CUSHION * push)
            v += push * normal
            z += self.step * v[2]
            if z <= 0.0:
                if v[2] < 0.0:
                    press = -(1 + (BOUNCE[0] if v[2] < -0.02 * push else 0.0)) * v[2]
                    v[2] += press
                    friction = BOUNCE[1] if press > 1.1 * push else CLOTH
                    self.rub(v, w, np.array([0.0, 0.0, -1.0]), friction * press)
                z = 0.0

    @staticmethod
    def rub(v, w, lever, most):
        """Friction's impulse, at most so large, at a point of the ball."""
        slip = v + np.cross(w, lever)
        slip -= (slip @ lever) * lever
        size = np.linalg.norm(slip)
        if size > 0.0:
            impulse = -min(most, size / (1 + TURN)) / size * slip
            v += impulse
            w += TURN * np.cross(lever, impulse)


@pytest.mark.parametrize(
    ('height', 'topspin'),
    [(0.3, -0.7), (0.3, 1.0), (0.6, 0.0), (1.0, -0.7), (1.0, 1.0), (3.0, 0.0)],
)
def test_a_ball_in_the_air_agrees_with_small_steps(height, topspin):
    velocity, spin = np.array([0.5, 1.0, 0.1]), np.array([-topspin, 0.3, 0.4])
    one = Steps(velocity, spin, height, 0.25).run()
    other = rebounds(velocity, spin, height, 0.25)
    for found, expected in zip(other, one, strict=False):
        assert found == pytest.approx(expected, abs=3e-3)


def test_a_ball_that_never_lands_bounces_as_if_there_were_no_cloth():
    params, _ = params_on_table(POOL)
    ball, sine = BallRecord(), 0.2
    start_ball(ball, [0, 0, 1], [0.4, 1.0, 0.1], [3.0 / R / 10, 0.2 / R, 0.5 / R])
    velocity, spin, _, lasting = rebounds(
        tuple(ball.velocity), tuple(R * x for x in ball.spin), 1e9, sine
    )
    approach = np.sqrt(1 - sine**2) * ball.velocity[1] + sine * ball.velocity[2]
    collide_fixed(params, ball, 0.0, -np.sqrt(1 - sine**2), -sine, RESTITUTION, CUSHION)
    assert approach > 0
    assert velocity == pytest.approx(ball.velocity, abs=1e-6)
    assert spin == pytest.approx(R * np.array(ball.spin), abs=1e-6)
    assert lasting == pytest.approx(np.pi / 2 * (1 + RESTITUTION), rel=1e-6)


def random_contacts(count):
    random = np.random.default_rng(11)
    for _ in range(count):
        velocity, spin = random.normal(size=3), 2 * random.normal(size=3)
        velocity[1] = abs(velocity[1])
        velocity[2] *= 0.3
        height = random.choice([0.0, 10 ** random.uniform(-6, 0.5)])
        sine = random.uniform(0.0, 0.5)
        if height == 0.0:
            velocity[2] = 0.0
        if velocity[1] * np.sqrt(1 - sine**2) + velocity[2] * sine > 0.01:
            yield velocity, spin, height, sine, random.choice([0.0, 0.14, 0.5])


def test_energy_is_never_gained():
    for velocity, spin, height, sine, friction in random_contacts(150):
        found, turned, _, _ = rebounds(velocity, spin, height, sine, friction, 1e-6)
        before = velocity @ velocity + spin @ spin / TURN
        assert found @ found + turned @ turned / TURN <= before * (1 + 1e-5)


def test_the_tolerance_holds():
    for velocity, spin, height, sine, friction in random_contacts(40):
        fine = rebounds(velocity, spin, height, sine, friction, 1e-9)
        for tolerance in (1e-4, 1e-6):
            coarse = rebounds(velocity, spin, height, sine, friction, tolerance)
            scale = max(*np.abs(velocity), *np.abs(spin))
            error = (300 if height else 5) * tolerance * scale
            for one, other in zip(coarse[:2], fine[:2], strict=True):
                assert one == pytest.approx(other, abs=error)


def test_a_ball_wedged_between_nose_and_cloth_is_a_status():
    scene = scene_with(cushion={'friction': 5.0, 'height': 0.9})
    scene = replace(scene, cloth=replace(scene.cloth, sliding_friction=3.0))
    run = simulate(scene, {'cue': BallState((1.0, 0.3, R), (2, 0, 0), (0, 2 / R, 0))})
    assert run.status == Status.BUDGET_EXCEEDED
    assert np.isfinite(run.final_position['cue']).all()


# -- on the table


def test_a_contact_takes_its_time_and_the_ball_goes_along_the_cushion():
    run = simulate(POOL, {'cue': BallState((1.2, 0.1, R), (1, 1, 0), (-1 / R, 1 / R, 0))})
    hit = next(event for event in run.events if event.kind == EventKind.CUSHION)
    ball = run.balls['cue']
    pressing = next(each for each in ball.segments if each.start == hit.time)
    lasting = pressing.end - pressing.start
    # the nose holds the ball longer than one in the air, because friction takes part of the push
    assert 4e-3 < lasting < 6e-3
    before, after = ball.at(hit.time - 1e-9), ball.at(pressing.end)
    assert after.position[0] == pytest.approx(before.position[0], abs=1e-8)
    along = after.position[1] - before.position[1]
    assert along == pytest.approx(
        0.5 * lasting * (before.velocity[1] + after.velocity[1]), rel=0.03
    )
    kinetic = 0.5 * (
        POOL.ball.mass * after.velocity @ after.velocity
        + POOL.ball.inertia * after.spin @ after.spin
    )
    assert hit.energy_after == pytest.approx(kinetic)


def test_cushions_without_duration_keep_the_ball_where_it_is():
    scene = scene_with(cushion={'duration': 0.0})
    start = {'cue': BallState((1.2, 0.1, R), (1, 1, 0), (-1 / R, 1 / R, 0))}
    run, slow = simulate(scene, start), simulate(POOL, start)
    hit = next(event for event in run.events if event.kind == EventKind.CUSHION)
    at_once = run.balls['cue'].at(hit.time)
    pressing = next(each for each in slow.balls['cue'].segments if each.start == hit.time)
    later = slow.balls['cue'].at(pressing.end)
    assert at_once.position == pytest.approx(hit.position)
    assert at_once.velocity == pytest.approx(later.velocity, abs=1e-4)
    assert at_once.spin == pytest.approx(later.spin, abs=1e-4 / R)


def test_a_ball_frozen_to_a_cushion_gets_what_two_impacts_give_it():
    """The cushion's contact is twenty times as long: the other ball has left before it answers."""
    edge = 0.5 * POOL.table.length - np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)
    states = {
        'cue': BallState((edge - 2 * R - 0.2, 0.0, R), (2, 0, 0)),
        'frozen': BallState((edge, 0.0, R)),
    }
    run = simulate(POOL, states)
    kinds = [(event.kind, event.balls) for event in run.events]
    met = kinds.index((EventKind.BALL, ('cue', 'frozen')))
    assert (EventKind.CUSHION, ('frozen',)) in kinds[met:]
    assert all(event.dissipated >= -1e-12 for event in run.events)


def test_a_ball_is_met_while_it_presses_a_cushion():
    edge = 0.5 * POOL.table.length - np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)
    for behind in np.linspace(1e-4, 8e-3, 17):
        states = {
            'first': BallState((edge - 1e-3, 0.0, R), (2, 0, 0), (0, 2 / R, 0)),
            'second': BallState((edge - 1e-3 - 2 * R - behind, 0.0, R), (2, 0, 0), (0, 2 / R, 0)),
        }
        run = simulate(POOL, states)
        assert [event.kind for event in run.events[:2]] == [EventKind.CUSHION, EventKind.BALL]
        assert run.events[1].time < run.events[0].time + 5.5e-3
        assert all(event.dissipated >= -1e-9 for event in run.events if len(event.balls) > 1)
        total = sum(
            0.5 * POOL.ball.mass * float(state.velocity @ state.velocity)
            for state in run.at(run.events[1].time + 0.02).values()
        )
        assert 0.3 < total / (POOL.ball.mass * 4.0) < 1.0


@pytest.mark.parametrize(('ratio', 'error'), [(20.0, 0.001), (10.0, 0.0025), (4.0, 0.015)])
def test_a_contact_of_a_tenth_of_the_duration_acts_at_once(ratio, error):
    """A ball hits one that touches a cushion: as if the cushion were met after that."""
    contacts = [
        Contact(0, 1, (0, 0, 1), (0, 0, 1), 0.95, 0.0, 2.0 * ratio**2),
        Contact(1, 2, (0, 0, 0), (0, 0, 1), 0.8, 0.0, 4.0),
    ]
    bodies = [Body(1.0, velocity=(0, 0, -1.0)), Body(1.0), Body.fixed()]
    found = met_again(*collide(bodies, contacts, reactivation='distance').velocities[:2, 2])
    expected = met_again(-0.5 * (1 - 0.95), 0.8 * 0.5 * (1 + 0.95))
    assert found == pytest.approx(expected, abs=error)
    assert is_instant_beside(1.0, ratio) == (error < 0.005)


def met_again(first, second):
    """Velocities of two balls after the second one, that comes from the cushion, met the first."""
    if second <= first:
        return first, second
    apart = 0.5 * 0.95 * (second - first)
    return 0.5 * (first + second) + apart, 0.5 * (first + second) - apart


def test_corners_without_pockets_let_nothing_through():
    scene = replace(POOL, table=replace(POOL.table, pockets=False))
    random = np.random.default_rng(3)
    corner = np.array([1.27, 0.635]) - 0.03
    for _ in range(200):
        velocity = (*random.uniform(0.2, 5, 2), 0.0)
        spin = random.normal(size=3) * 50
        place = corner - random.uniform(0, 0.02, 2)
        run = simulate(scene, {'cue': BallState((*place, R), velocity, spin)})
        assert (np.abs(run.final_position['cue'][:2]) <= (1.27 - 0.02, 0.635 - 0.02)).all()


def outcomes(heights, velocity, spin, ratio):
    """Place 60 ms after a ball in the air met the cushion (n, 2), and motion 2 s later (n, 6)."""
    ahead = 1.27 - 0.031
    states = [
        {'cue': BallState((ahead, 0.1, R + height), velocity, spin)} for height in heights.tolist()
    ]
    scene = scene_with(cushion={'frequency_ratio': ratio})
    scene = replace(scene, table=replace(scene.table, pockets=False))
    runs = [simulate(scene, state, tolerance=1e-8) for state in states]
    soon, late = [run.at(0.06)['cue'] for run in runs], [run.at(0.4)['cue'] for run in runs]
    speed = np.linalg.norm(velocity)
    return np.array(
        [
            np.hstack(
                [one.position[:2], 0.1 * other.velocity / speed, 0.1 * R * other.spin / speed]
            )
            for one, other in zip(soon, late, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ('velocity', 'spin', 'ratio'),
    [
        ((2, 0, 0), (0, 0, 0), 0.0),
        ((1, 0.5, 0), (-0.5 / R, 1 / R, 20), 0.0),
        ((0.5, 0, 0), (0, -0.5 / R, 0), 0.0),
        ((1, 0.5, 0), (-0.5 / R, 1 / R, 20), 1.8),
    ],
    ids=['stun', 'rolling', 'draw', 'rolling, tangential spring'],
)
def test_no_hop_makes_a_jump(velocity, spin, ratio):
    """Steps of 1 % are bisected: a smooth one gets smaller with its interval."""
    heights = np.concatenate([[0.0], np.geomspace(1e-9, 3e-3, 300)])
    found = outcomes(heights, velocity, spin, ratio)
    steps = np.abs(np.diff(found, axis=0)).max(axis=1)
    for low in np.flatnonzero(steps > 1e-3):
        a, b = heights[low], heights[low + 1]
        one, other = found[low], found[low + 1]
        while np.abs(other - one).max() > 5e-4 and b - a > 1e-9:
            middle = 0.5 * (a + b)
            between = outcomes(np.array([middle]), velocity, spin, ratio)[0]
            if np.abs(between - one).max() > np.abs(other - between).max():
                b, other = middle, between
            else:
                a, one = middle, between
        assert np.abs(other - one).max() <= 1e-3, (a, b)


def test_batches_press_cushions_as_single_tables_do():
    states = {'cue': BallState((1.2, 0.1, R), (2, 0.3, 0), (-5, 70, 20))}
    one = simulate(POOL, states)
    many = simulate_batch(POOL, [states, states])
    assert (many.final_position == one.final_position['cue']).all()


@pytest.mark.parametrize(
    ('velocity', 'spin', 'height', 'sine'),
    [
        ((-0.152, 1.177, -0.04), (-1.046, 1.767, -0.333), 0.0002, 0.338),
        ((-2.324, 0.827, -0.204), (-2.817, -3.627, -3.237), 0.0747, 0.346),
    ],
)
def test_a_landing_within_a_step_is_found(velocity, spin, height, sine):
    """Friction at the nose lifts the ball at once: it is above the cloth at both ends."""
    coarse, fine = (
        np.concatenate(
            rebounds(velocity, spin, height, sine, friction=2.0, tolerance=tolerance)[:2]
        )
        for tolerance in (1e-5, 1e-8)
    )
    assert coarse == pytest.approx(fine, abs=1e-3)


def test_a_ball_that_grazes_a_nose_with_the_spin_of_its_way_is_solved():
    """At the first touch nothing slips and nothing pushes, but the ball is not wedged."""
    sine = 2 * POOL.table.cushion.height - 1
    cosine, along = np.sqrt(1 - sine**2), 3.0
    y = 0.5 * POOL.table.width - cosine * R - 1e-8
    for approach in (1.25e-3, 1.5e-3, 2e-3):
        spin = (-approach / R, along / R, along * (1 + sine) / (R * cosine))
        ball = BallState((0.2, y, R), (along, approach, 0.0), spin)
        run = simulate(POOL, {'cue': ball})
        assert run.status == Status.OK
        assert np.isfinite(run.final_position['cue']).all()


def test_smooth_cushions():
    smooth = scene_with(cushion={'friction': 0.0})
    sine = 2 * smooth.table.cushion.height - 1
    y = 0.5 * POOL.table.width - np.sqrt(1 - sine**2) * R - 1e-8
    for share in (-1.0, 0.0, 1.0):
        spin = (share * sine * 1.5 / R, 0.0, 0.0)
        run = simulate(smooth, {'cue': BallState((0.3, y, R), (0.0, 1.5, 0.0), spin)})
        assert run.status == Status.OK
        assert np.isfinite(run.final_position['cue']).all()
