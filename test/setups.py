"""Collisions that the tests share, as dictionaries: for `collide` and for the slow check alike."""

import numpy as np

from billiard_shot import Scene, Stroke
from billiard_shot.impact import Body, collide, Contact
from billiard_shot.impact.kernel import solve_in_contact_space
from billiard_shot.status import Status
from studies.problem import ContactProblem

BALL, CUE, RADIUS = 0.1673, 0.5018, 0.0286  # kg, kg, m: the paper's measured constants
TIP_FRICTION, CLOTH_FRICTION = 0.4, 0.152479
TIP_RESTITUTION, CLOTH_RESTITUTION = 0.656532, 0.51625
UP = (0.0, 0.0, 1.0)
TABLE = {'mass': np.inf}

ROOT = 2**-0.5
SHOTS = {  # the paper's table 1, with the sign of the jump's normal put right
    'vertical': ((-1, -2, 1), (0, 0, -2)),
    'horizontal': ((-ROOT, -ROOT, 0), (0.8, 0, 0)),
    'jump': ((-ROOT, 0, ROOT), (1, 0, -1)),
    'masse': ((-2, -1, 12), (4, 0, -16)),
}


# The ratio of the paper: with a tip of 1.3 ms the ball leaves the cloth only after 1.6 ms, so that
# many steep strikes hit twice.
SLOW_CLOTH = {'cue_ball': {'stiffness': 1.5}, 'ball_table': {'stiffness': 1.0}}


def run(setup, **options):
    """Call `collide` with a set-up."""
    bodies, contacts = setup
    made = [Body.fixed() if body['mass'] == np.inf else Body(**body) for body in bodies]
    return collide(made, [Contact(**contact) for contact in contacts], **options)


def two_balls(masses=(1.0, 1.0), restitution=(0.9**0.5, 0.4**0.5), ratio=10.0, speed=3.0):
    """A ball falls onto another one on a table (the paper's section 2); ratio: k2 / k1."""
    bodies = [{'mass': masses[0], 'velocity': (0, 0, -speed)}, {'mass': masses[1]}, TABLE]
    contacts = [
        {'a': 0, 'b': 1, 'point': (0, 0, 0.06), 'normal': UP, 'restitution': restitution[0]},
        {
            'a': 1, 'b': 2, 'point': (0, 0, 0), 'normal': UP, 'restitution': restitution[1],
            'stiffness': ratio,
        },
    ]  # fmt: skip
    return bodies, contacts


def shot(
    normal,
    velocity,
    ratio=1.5,
    end_mass=None,
    masses=(CUE, BALL),
    friction=(TIP_FRICTION, CLOTH_FRICTION),
    restitution=(TIP_RESTITUTION, CLOTH_RESTITUTION),
):
    """A guided cue strikes a ball on a table (section 3); ratio: k_cb / k_bt."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    centre = np.array([0.0, 0.0, RADIUS])
    cue = {'mass': masses[0], 'velocity': velocity, 'guide': np.asarray(velocity, float)}
    cue['guide'] = cue['guide'] / np.linalg.norm(cue['guide'])
    if end_mass is not None:
        cue['end_mass'] = end_mass
    ball = {'mass': masses[1], 'inertia': 0.4 * masses[1] * RADIUS**2, 'position': centre}
    contacts = [
        {
            'a': 0, 'b': 1, 'point': centre + RADIUS * n, 'normal': n, 'stiffness': ratio,
            'friction': friction[0], 'restitution': restitution[0],
        },
        {
            'a': 1, 'b': 2, 'point': (0, 0, 0), 'normal': UP, 'friction': friction[1],
            'restitution': restitution[1],
        },
    ]  # fmt: skip
    return [cue, ball, TABLE], contacts


def chain(count, speed=1.0, stiffness=None):
    """Equal balls in a row, the first one moving along x; no friction, nothing lost."""
    bodies = [{'mass': 1.0, 'velocity': (speed if i == 0 else 0.0, 0, 0)} for i in range(count)]
    contacts = [
        {
            'a': i, 'b': i + 1, 'point': (i + 0.5, 0, 0), 'normal': (-1, 0, 0), 'restitution': 1.0,
            'stiffness': 1.0 if stiffness is None else stiffness[i],
        }
        for i in range(count - 1)
    ]  # fmt: skip
    return bodies, contacts


def touching(places, within, restitution, friction):
    """Balls of radius 1 at places (n, 3), and contacts where gaps are less than `within`."""
    bodies = [{'mass': 1.0, 'inertia': 0.4, 'position': place} for place in places]
    contacts = []
    for j in range(len(places)):
        for i in range(j):
            apart = places[j] - places[i]
            distance = np.linalg.norm(apart)
            if distance < 2 + within:
                contacts.append({
                    'a': j, 'b': i, 'point': places[i] + apart / 2, 'normal': apart / distance,
                    'restitution': restitution, 'friction': friction,
                })  # fmt: skip
    return bodies, contacts


def cluster(rng, count=6, restitution=0.95, friction=0.1, speed=1.8):
    """Balls on a plane that touch as they come, and one more that strikes the last of them."""

    def beside(place):
        angle = rng.uniform(0, 2 * np.pi)
        return place + 2 * np.array([np.cos(angle), np.sin(angle), 0.0])

    places = [np.zeros(3)]
    while len(places) <= count:
        place = beside(places[-1] if len(places) == count else places[rng.integers(len(places))])
        if all(np.linalg.norm(place - other) > 2 - 1e-9 for other in places):
            places.append(place)
    bodies, contacts = touching(places, 1e-9, restitution, friction)
    normal = (places[-1] - places[-2]) / 2
    bodies[-1]['velocity'] = speed * (0.6 * np.cross(normal, (0, 0, 1)) - 0.8 * normal)
    return bodies, contacts


def block(velocity, spin=(0.0, 0.0, 0.0), friction=0.3, restitution=0.5, order=(0, 1, 2, 3)):
    """A flat block on its four lower corners: more contacts than it has freedom."""
    mass, (a, b, c) = 1.3, (0.3, 0.2, 0.1)
    inertia = mass / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    body = {
        'mass': mass, 'inertia': inertia, 'position': (0.0, 0.0, c / 2), 'velocity': velocity,
        'spin': spin,
    }  # fmt: skip
    corners = [(x * a / 2, y * b / 2, 0.0) for x in (-1, 1) for y in (-1, 1)]
    contacts = [
        {
            'a': 0, 'b': 1, 'point': corners[i], 'normal': UP, 'friction': friction,
            'restitution': restitution,
        }
        for i in order
    ]  # fmt: skip
    return [body, TABLE], contacts


def states(result):
    """Active contacts of each phase."""
    return [tuple(phase.active) for phase in result.phases]


def paper_states(result):
    """The phases by the paper's names."""
    names = {(0, 1): 'S1', (1,): 'S2', (0,): 'S3'}
    return ' '.join(names[active] for active in states(result))


def kinetic_energy(setup, velocities, spins):
    """Kinetic energy of all bodies that move freely or along their guides [J]."""
    total = 0.0
    for body, v, w in zip(setup[0], velocities, spins, strict=True):
        if body['mass'] == np.inf:
            continue
        guide = body.get('guide')
        if guide is None:
            total += 0.5 * body['mass'] * np.dot(v, v)
        else:
            along = np.dot(v, guide) / np.linalg.norm(guide)
            total += 0.5 * body['mass'] * along**2
            if body.get('end_mass') is not None:
                total += 0.5 * body['end_mass'] * (np.dot(v, v) - along**2)
        inertia = body.get('inertia')
        if inertia is not None:
            total += 0.5 * np.dot(w, world_inertia(body) @ w)
    return total


def world_inertia(body):
    """Inertia matrix of a body as it is turned."""
    from slow_check import rotation

    inertia = np.asarray(body['inertia'], float)
    inertia = inertia if inertia.ndim == 2 else np.diag(np.broadcast_to(inertia, 3))
    turn = rotation(body.get('orientation', (0.0, 0.0, 0.0, 1.0)))
    return turn @ inertia @ turn.T


def start_of(setup):
    """Velocities and spins before the collision."""
    velocities = np.array([body.get('velocity', (0, 0, 0)) for body in setup[0]], float)
    spins = np.array([body.get('spin', (0, 0, 0)) for body in setup[0]], float)
    return velocities, spins


def difference(setup, result, other):
    """Largest difference of two results' contact velocities, relative to the approach speed."""
    from slow_check import jacobian

    rows = jacobian(*setup)
    flat = [np.hstack([r.velocities, r.spins]).ravel() for r in (result, other)]
    start = rows @ np.hstack(start_of(setup)).ravel()
    return np.abs(rows @ (flat[0] - flat[1])).max() / -start[::3].min()


def random_shot(rng, end_mass=False, hard=False):
    """An ordinary stroke, or one with wide parameters."""
    while True:
        n, c = rng.normal(size=(2, 3))
        n, c = n / np.linalg.norm(n), c / np.linalg.norm(c)
        if n @ c < -0.3 and c[2] <= 0.0 and n[2] > -0.5:
            break
    wide = 5.0 if hard else 2.3
    return shot(
        n,
        c * rng.uniform(0.3, 6.0),
        ratio=float(np.exp(rng.uniform(-wide, wide))),
        end_mass=float(rng.uniform(0.003, 0.02)) if end_mass else None,
        friction=tuple(rng.uniform((0.1, 0.05), (0.9, 0.5)).tolist()),
        restitution=tuple(rng.uniform((0.4, 0.3), (0.95, 0.9)).tolist()),
    )


def guided_scene(mass, ratio, law, friction, restitution):
    """A guided cue of so many ball masses; friction and restitution at tip and table."""
    ball = min(0.17, 99.0 / mass)  # kg; scenes take no cue above 100 kg
    return Scene.from_dict(
        {
            'ball': {'mass': ball, 'radius': 0.03},
            'cue': {'mass': mass * ball, 'guided': True},
            'law': law,
            'contacts': {
                'cue_ball': {
                    'restitution': restitution[0],
                    'friction': friction[0],
                    'stiffness': ratio,
                },
                'ball_table': {
                    'restitution': restitution[1],
                    'friction': friction[1],
                    'stiffness': 1.0,
                },
            },
        }
    )


def guided_strike(mass, ratio, law, friction, restitution, cosine, elevation, normal):
    """
    A guided cue strikes a ball on a table, as a problem of the kernel.

    Cue in balls, stiffness ratio, law; friction and restitution at tip and table; -n.c, the
    stroke's angle to the cloth [rad], and the normal, roughly.
    """
    scene = guided_scene(mass, ratio, law, friction, restitution)
    c = np.array([np.cos(elevation), 0.0, -np.sin(elevation)])
    across = np.array(normal) - (c @ normal) * c
    across /= np.linalg.norm(across)
    n = np.sqrt(1.0 - cosine**2) * across - cosine * c
    return ContactProblem.of(scene, Stroke(normal=tuple(n), velocity=tuple(c)))


def solved(problem, tolerance):
    """Impulses, status and steps of a problem that is solved, its energy ledger closed."""
    done = solve_in_contact_space(
        problem.properties, problem.response[np.newaxis], problem.velocity[np.newaxis], [tolerance]
    )
    impulse = done.contacts['impulse'].ravel()
    status, steps = done.outcomes['status'][0], done.outcomes['steps'][0]
    lost = sum(done.contacts[name].sum() for name in ('restitution_loss', 'friction_loss'))
    assert status in (Status.OK, Status.INFINITE_SEQUENCE)
    work = impulse @ (problem.velocity + 0.5 * problem.response @ impulse)
    assert abs(work + lost) < 1e-10 * 0.5 * problem.model.cue_mass
    return impulse, status, steps
