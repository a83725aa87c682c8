import numpy as np
import pytest
from rolling import CLOTH, run

from billiard_shot import BallState, simulate, Status
from billiard_shot.table.model.geometry import GATE_OFF, GATE_ON
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import EventKind

G = 9.8


def bounced(velocity, spin, params=CLOTH):
    """Closed form of one bounce: the slip stops if friction suffices (for a solid ball, 2/7)."""
    velocity, spin = np.array(velocity, float), np.array(spin, float)
    r, m = params.radius, params.mass
    slip = velocity[:2] + r * np.array([-spin[1], spin[0]])
    push = m * (1 + params.cloth_restitution) * -velocity[2]
    most = 2 / 7 * m * np.linalg.norm(slip)
    drag = -min(params.cloth_friction * push, most) * slip / np.linalg.norm(slip)
    velocity += np.array([*drag, push]) / m
    spin += r / params.inertia * np.array([drag[1], -drag[0], 0.0])
    return velocity, spin


@pytest.mark.parametrize('spin', [(0, 0, 0), (10, -60, 5), (-3, 33, 0)])
def test_a_bounce_is_an_impact_with_friction(spin):
    path, _, _ = run((1, 0.2, 1), spin)
    hop, landed = path.segments[:2]
    assert landed.start == pytest.approx(2 / G, rel=1e-12)
    assert landed.position == pytest.approx([2 / G, 0.4 / G, 0.028], rel=1e-12)
    velocity, spin = bounced((1, 0.2, -1), hop.spin)
    assert landed.velocity == pytest.approx(velocity, rel=1e-10, abs=1e-12)
    assert landed.spin == pytest.approx(spin, rel=1e-10, abs=1e-10)


def test_hops_shrink_and_end():
    path, _, error = run((1, 0, 1), (0, -60, 0), tolerance=1e-4)
    hops = [s for s in path.segments if s.motion == Motion.FLIGHT]
    assert np.allclose([hop.velocity[2] for hop in hops[:-1]], 0.5 ** np.arange(len(hops) - 1))
    assert 0 < error <= 1e-4
    kinds = [event.kind for event in path.events]
    assert kinds[: len(hops)] == [EventKind.BOUNCE] * (len(hops) - 1) + [EventKind.LAND]
    assert path.at(0.1).position[2] == pytest.approx(0.028 + 0.1 - G * 0.005)


@pytest.mark.parametrize('restitution', [0.2, 0.5, 0.9])
@pytest.mark.parametrize('tolerance', [1e-3, 1e-4, 1e-5, 1e-6])
def test_leaving_out_bounces_keeps_the_tolerance(restitution, tolerance):
    params = CLOTH._replace(cloth_restitution=restitution)
    for velocity, spin in (
        ((1, 0.2, 1), (10, -60, 5)),
        ((3, 0, 0.2), (0, 0, 0)),
        ((0, 0, 2), (9, 0, 0)),
    ):
        rough, _, error = run(velocity, spin, params, tolerance)
        exact, _, _ = run(velocity, spin, params, 1e-12)
        assert error <= tolerance
        t = np.linspace(0, exact.duration, 2000)
        gap = np.abs(rough.at(t).position - exact.at(t).position).max()
        assert gap <= 1.5 * error + 1e-12  # largest component of a bound on each part


def test_a_jump_without_bounce_stops_hopping_at_once():
    path, _, _ = run((1, 0, 1), params=CLOTH._replace(cloth_restitution=0.0))
    assert [s.motion for s in path.segments][:2] == [Motion.FLIGHT, Motion.SLIDE]


def test_flight_off_keeps_the_horizontal_motion():
    off, _, error = run((1, 0, 1), (0, 9, 1), CLOTH._replace(flight_gate=GATE_OFF))
    level, _, _ = run((1, 0, 0), (0, 9, 1))
    assert error == 0
    assert (off.rows == level.rows).all()


def test_flight_on_flies_the_smallest_hop():
    path, _, _ = run((1, 0, 1e-5), params=CLOTH._replace(flight_gate=GATE_ON))
    assert path.segments[0].acceleration[2] == -G
    path, _, _ = run((1, 0, 1e-5))
    assert path.segments[0].acceleration[2] == 0


@pytest.mark.parametrize(
    ('place', 'velocity', 'spin'),
    [
        ((0.6, 0.633, 0.0749), (0, 0.3, 0), (0, 0, 0)),
        ((-0.1521, 0.598, 0.0839), (-2.555, -0.0206, 1.4355), (57.6, -105.9, 0.76)),
    ],
)
def test_a_ball_that_comes_down_behind_the_edge_of_a_cushion_is_pushed_outwards(
    place, velocity, spin
):
    played = simulate('pool_table', {'ball': BallState(place, velocity, spin)})
    assert EventKind.CUSHION in {event.kind for event in played.events}
    for event in played.events:
        assert event.dissipated >= 0.0
    assert played.status == Status.OFF_TABLE
    assert len(played.events) < 10
