import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import predict, Stroke
from billiard_shot.shot.stroke import axes, SPEED_RANGE, vectors_of

ANGLE = st.floats(-3.1, 3.1)
OFFSET = st.floats(-0.7, 0.7)


def test_any_length_of_normal():
    assert Stroke((-2, -1, 12), (4, 0, -16)) == Stroke((-200, -100, 1200), np.array([4.0, 0, -16]))
    assert np.linalg.norm(Stroke((1e300, 1e300, 0), (1, 0, 0)).normal) == pytest.approx(1)
    assert np.linalg.norm(Stroke((1e-300, 1e-300, 0), (1, 0, 0)).normal) == pytest.approx(1)


def test_offsets_are_as_the_player_sees_them():
    stroke = Stroke.from_offsets(a=0.3, b=0.2, elevation=0, azimuth=0, speed=2)
    assert stroke.normal == pytest.approx((-math.sqrt(1 - 0.13), -0.3, 0.2))  # right of +x is -y
    assert stroke.velocity == pytest.approx((2, 0, 0))
    steep = Stroke.from_offsets(a=0, b=0, elevation=math.radians(30), azimuth=math.pi / 2, speed=1)
    assert steep.velocity == pytest.approx((0, math.sqrt(0.75), -0.5))


@given(OFFSET, OFFSET, st.floats(0, 1.5), ANGLE, st.floats(0.01, 10))
def test_offsets_round_trip(a, b, elevation, azimuth, speed):
    stroke = Stroke.from_offsets(a, b, elevation, azimuth, speed)
    assert stroke.offsets == pytest.approx((a, b, elevation, azimuth, speed), abs=1e-12)
    again = Stroke(stroke.normal, stroke.velocity)
    assert again.normal == pytest.approx(stroke.normal, abs=1e-15)


@given(OFFSET, OFFSET, st.floats(0, 1.5), ANGLE, st.floats(0, 2), ANGLE, st.floats(0.1, 9))
def test_a_pose_finds_the_contact(a, b, elevation, azimuth, way, twist, scale):
    ball = np.array([0.3, -0.2, 0.0286])
    expected = Stroke.from_offsets(a, b, elevation, azimuth, 1.5)
    along = np.array(axes(elevation, azimuth)[2])
    tip = ball + ball[2] * np.array(expected.normal) - way * along
    # turned about z by the azimuth, then about the new y by the elevation, then about x
    half = np.array([twist, elevation, azimuth]) / 2
    (sx, sy, sz), (cx, cy, cz) = np.sin(half), np.cos(half)
    quaternion = scale * np.array(
        [
            sx * cy * cz - cx * sy * sz,
            cx * sy * cz + sx * cy * sz,
            cx * cy * sz - sx * sy * cz,
            cx * cy * cz + sx * sy * sz,
        ]
    )
    stroke = Stroke.from_pose(tip, quaternion, 1.5, ball)
    assert stroke.normal == pytest.approx(expected.normal, abs=1e-10)
    assert stroke.velocity == pytest.approx(expected.velocity, abs=1e-12)
    assert not stroke.miss


@pytest.mark.parametrize(
    ('arguments', 'text'),
    [
        (((0, 0, 0), (1, 0, 0)), r'normal must not be zero'),
        (((1, 0), (1, 0, 0)), 'normal must be 3 finite numbers'),
        (((1, 0, math.nan), (1, 0, 0)), 'normal must be a finite number, got nan'),
        (((1, 0, '0'), (1, 0, 0)), r"normal must be .*, got '0'"),
        (((1, 0, True), (1, 0, 0)), r'normal must be .*, got True'),
        (((1, 0, 0), (0, 0, 0)), 'velocity must be of length above 0, got'),
        (((1, 0, 0), (1e200, 0, 1e200)), 'velocity must be of length 1e-12 to'),
        (((1, 0, 0), (1, math.inf, 0)), r'velocity must be .*, got inf'),
        (((1, 0, 0), (1, 10**400, 0)), r'velocity must be .*, got 10+'),
        ((1, (1, 0, 0)), r'normal must be .*, got 1'),
        (('abc', (1, 0, 0)), r"normal must be .*, got 'abc'"),
    ],
)
def test_what_is_no_stroke_is_an_error(arguments, text):
    with pytest.raises(ValueError, match=text):
        Stroke(*arguments)


@pytest.mark.parametrize(
    ('changes', 'text'),
    [
        ({'a': math.nan}, r'a must .*, got nan'),
        ({'b': None}, r'b must .*, got None'),
        ({'elevation': math.inf}, r'elevation must .*, got inf'),
        ({'azimuth': 'x'}, r"azimuth must .*, got 'x'"),
        ({'speed': 0}, r'speed must be above 0, got 0 \(m/s\); the cue of a player'),
        ({'speed': -1.0}, 'speed must be .*, got -1.0'),
        ({'speed': 1e-300}, 'speed must be 1e-12 to .*, got 1e-300'),
        ({'speed': 1e300}, r'speed must be 1e-12 to .*, got 1e\+300'),
        ({'speed': math.nan}, 'speed must be a finite number, got nan'),
    ],
)
def test_wrong_offsets_are_an_error(changes, text):
    with pytest.raises(ValueError, match=text):
        Stroke.from_offsets(
            **{**dict.fromkeys(('a', 'b', 'elevation', 'azimuth'), 0), 'speed': 1, **changes}
        )


@pytest.mark.parametrize(
    ('changes', 'text'),
    [
        ({'quaternion': (0, 0, 0, 0)}, r'quaternion must not be zero'),
        ({'quaternion': (0, 0, 1)}, 'quaternion must be 4 finite numbers'),
        ({'position': (0, 0, math.nan)}, r'position must .*, got nan'),
        ({'ball': (0, 0, 0)}, 'ball must be finite and above 0, got 0.0'),
        ({'speed': 0.0}, 'speed must be .*, got 0.0'),
        ({'speed': 1e16}, r'speed must be .*, got 1e\+16'),
    ],
)
def test_wrong_poses_are_an_error(changes, text):
    pose = {
        'position': (-1, 0, 0.03),
        'quaternion': (0, 0, 0, 1),
        'speed': 1,
        'ball': (0, 0, 0.03),
    }
    with pytest.raises(ValueError, match=text):
        Stroke.from_pose(**{**pose, **changes})


@pytest.mark.parametrize('speed', SPEED_RANGE)
@pytest.mark.parametrize('turn', np.linspace(0.0, 1.5, 20))
def test_the_slowest_and_the_fastest_stroke(speed, turn):
    shot = predict('pool', Stroke.from_offsets(0.1, 0.2, turn, turn, speed))
    assert not shot.status.refused
    assert np.isfinite(shot.trajectory.final_position).all()


def test_degrees_are_accepted_and_recognised():
    one = Stroke.from_offsets(a=0.1, elevation=math.radians(5), azimuth=math.radians(-30), speed=2)
    other = Stroke.from_offsets(a=0.1, elevation_deg=5, azimuth_deg=-30, speed=2)
    assert one == other
    for name, largest in (('elevation', math.pi / 2), ('azimuth', 2 * math.pi)):
        for sign in (-1, 1):
            Stroke.from_offsets(**{name: sign * largest}, speed=1)
            with pytest.raises(ValueError, match=f'for degrees, give {name}_deg=') as refused:
                Stroke.from_offsets(**{name: sign * 1.001 * largest}, speed=1)
            assert f'{name} must be ' in str(refused.value)
            Stroke.from_offsets(**{f'{name}_deg': sign * math.degrees(largest)}, speed=1)
            with pytest.raises(ValueError, match=f'{name}_deg must .* \\(degrees\\)'):
                Stroke.from_offsets(
                    **{f'{name}_deg': sign * 1.001 * math.degrees(largest)}, speed=1
                )
        with pytest.raises(ValueError, match=f'{name} must not be given together with {name}_deg'):
            Stroke.from_offsets(**{name: 0.1, f'{name}_deg': 5}, speed=1)
    with pytest.raises(ValueError, match='speed is missing'):
        Stroke.from_offsets(a=0.1)


def test_level_is_not_minus_zero():
    assert math.copysign(1.0, Stroke((-1, 0, 0), (2, 0, 0)).offsets[2]) == 1.0


def test_strokes_have_the_same_bits_however_they_are_made():
    """By offsets, in rows, and by the vectors that a file keeps."""
    draw = np.random.default_rng(5)
    rows = draw.uniform((-0.6, -0.6, 0.0, -3.0, 0.1), (0.6, 0.6, 1.5, 3.0, 9.0), (500, 5))
    strokes = [Stroke.from_offsets(*row) for row in rows.tolist()]
    normals, velocities = vectors_of(rows)
    assert [stroke.normal for stroke in strokes] == list(map(tuple, normals.tolist()))
    assert [stroke.velocity for stroke in strokes] == list(map(tuple, velocities.tolist()))
    assert [Stroke(stroke.normal, stroke.velocity) for stroke in strokes] == strokes
