import dataclasses
import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.spatial.distance import pdist

from billiard_shot import aim, lowest_elevation, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.cli import main
from billiard_shot.shot.ghost_ball import cut_of_path, grazing, path_of_cut, path_of_line
from billiard_shot.shot.lowest_elevation import refusals_in
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


# --- aiming: the ball goes where the cut says, into the pocket, and the cue ball along the line

PLAIN = {'ball_ball': {'restitution': 1.0, 'friction_fast': 0, 'friction_slow': 0}}
TABLE = Scene.from_dict(
    {'like': 'pool_table', 'contacts': PLAIN, 'balls': {'cue': [-0.4, 0.1], '8': [0.2, 0.3]}}
)


def heading(vector):
    return math.degrees(math.atan2(vector[1], vector[0]))


@pytest.mark.parametrize('cut', [-75.0, -30.0, 0.0, 10.0, 60.0, 85.0])
def test_the_ball_leaves_at_the_cut_angle(cut):
    """Balls without friction: the ball goes along the line of centres. Positive is right."""
    stroke = aim(TABLE, '8', speed=2.0, cut_deg=cut)
    shot = predict(TABLE, stroke)
    assert shot.first_contact == '8'
    met = next(event for event in shot.events if '8' in event.balls)
    line = heading(shot.run.at(met.time)['8'].velocity)
    assert heading(stroke.velocity) - line == pytest.approx(cut, abs=0.05)
    assert aim(TABLE, '8', speed=2.0, cut=math.radians(cut)) == stroke


@pytest.mark.parametrize(
    ('pocket', 'place'),
    [('foot_left', (0.6, 0.0)), ('foot_right', (0.6, 0.0)), ('side_left', (0.1, 0.2))],
)
def test_the_pocket_is_reached(pocket, place):
    scene = dataclasses.replace(TABLE, balls={'cue': (-0.4, -0.2), '8': place})
    shot = predict(scene, aim(scene, '8', speed=2.0, pocket=pocket, b=-0.2))
    assert shot.pocketed['8'] == pocket


def test_squirt_is_corrected_on_request():
    place = (0.6, -0.3)
    line = heading(np.subtract(place, TABLE.cue_ball[:2]))
    plain = aim(TABLE, place, speed=2.0, a=0.4)
    assert heading(plain.velocity) == pytest.approx(line)
    assert abs(heading(predict(TABLE, plain).velocity) - line) > 1.0
    turned = aim(TABLE, place, speed=2.0, a=0.4, correct_squirt=True)
    assert heading(predict(TABLE, turned).velocity) == pytest.approx(line, abs=1e-6)


def test_the_cue_is_as_low_as_it_can_be():
    scene = dataclasses.replace(TABLE, balls={'cue': (-1.2, 0.0), '8': (0.2, 0.0)})
    stroke = aim(scene, '8', speed=1.0, margin=0.0)
    assert not predict(scene, stroke).status.refused
    _, _, elevation, azimuth, _ = stroke.offsets
    lower = Stroke.from_offsets(0.0, 0.0, elevation - math.radians(0.26), azimuth, 1.0)
    assert predict(scene, lower).status.refused
    assert aim(scene, '8', speed=1.0, elevation_deg=20).offsets[2] == pytest.approx(
        math.radians(20)
    )


@pytest.mark.parametrize('margin_deg', [0.0, 0.6, 3.0])
def test_the_cue_can_be_lower_by_the_margin(margin_deg):
    stroke = aim(TABLE, '8', speed=1.0, margin_deg=margin_deg)
    assert stroke == aim(TABLE, '8', speed=1.0, margin=math.radians(margin_deg))
    elevation = stroke.offsets[2]
    lowest = lowest_elevation(TABLE, [stroke.offsets])[0]
    assert abs(math.degrees(elevation - lowest) - margin_deg) < 0.051
    level = aim('pool', (1.0, 0.0), speed=1.0, margin_deg=margin_deg).offsets[2]
    assert math.degrees(level) == pytest.approx(margin_deg)  # it does not point up


@pytest.mark.parametrize('balls', [1, 6])
def test_a_player_with_errors_has_room(balls):
    """Of 10,000 strokes with errors fewer than 50 are refused; without a margin, 2000."""
    draw = np.random.default_rng(4)
    half = 0.5 * np.array([TABLE.table.length, TABLE.table.width]) - 1.1 * TABLE.ball.radius
    refused = {None: 0, 0.0: 0}
    for _ in range(100):
        places = draw.uniform(-half, half, (1 + balls, 2))
        while pdist(places).min() < 2.1 * TABLE.ball.radius:
            places = draw.uniform(-half, half, (1 + balls, 2))
        names = ['cue', *map(str, range(1, 1 + balls))]
        scene = dataclasses.replace(TABLE, balls=dict(zip(names, places.tolist(), strict=True)))
        a, b = draw.uniform(-0.3, 0.3, 2)
        for margin in refused:
            stroke = aim(scene, '1', speed=2.0, a=a, b=b, margin=margin)
            played = vectors_of(scene.noise.sample(stroke, 100, draw))
            refused[margin] += np.count_nonzero(refusals_in(scene, *played))
    assert refused[0.0] > 1500
    assert refused[None] < 50


@pytest.mark.parametrize(
    ('target', 'options', 'text'),
    [
        ('9', {}, "target must be one of 8, got '9'"),
        ('8', {'cut_deg': 90}, r'cut must be .*, got 90 \(degrees\)'),
        ('8', {'cut_deg': 95}, 'cut_deg must be .*, got 95'),
        (
            '8',
            {'pocket': 'head_left'},
            'pocket must be one that ball .8. reaches .*, got head_left',
        ),
        ('8', {'pocket': 'left'}, "pocket must be one of foot_left, .*, got 'left'"),
        ('8', {'pocket': 'foot_left', 'cut': 0.1}, 'pocket must not be given together with a cut'),
        ((0.1, 0.2), {'pocket': 'foot_left'}, 'pocket must not be given for a point'),
        ((0.1, 0.2), {'cut': 0.1}, 'cut must not be given for a point'),
        ((-0.4, 0.1), {}, r'target must be a point other than .*, got \(-0.4, 0.1\)'),
        ((0.1, math.nan), {}, r'target must .*, got nan'),
        ('8', {'margin_deg': 95}, 'margin_deg must be 0 to 90, got 95'),
        ('8', {'margin': -0.1}, 'margin must be 0 to 1.571, got -0.1'),
        ('8', {'margin': 0.1, 'elevation': 0.1}, 'margin must not be given together with'),
    ],
)
def test_what_cannot_be_aimed_at(target, options, text):
    with pytest.raises(ValueError, match=text):
        aim(TABLE, target, speed=2.0, **options)


def test_commands_aim(capsys, tmp_path):
    (tmp_path / 'cut.yaml').write_text(
        "like: pool_table\nballs: {cue: [0.4, 0.1], '8': [0.9, 0.265]}\n"
    )
    scene = str(tmp_path / 'cut.yaml')
    assert main(['predict', scene, '--aim', '8', '--pocket', 'foot_left', '-s', '2']) == 0
    assert '8 into foot left' in capsys.readouterr().out
    assert main(['predict', scene, '--aim', '8', '--cut', '20', '--pot', '8', '-s', '2']) == 0
    assert 'missed          8 beside' in capsys.readouterr().out
    assert main(['predict', scene, '--aim', '-0.5', '0.2', '-s', '2']) == 0
    assert 'azimuth 173.66°' in capsys.readouterr().out
    for wrong, text in (
        (['--aim', '8'], '--speed is missing'),
        (['--aim', '8', '-s', '2', '-z', '3'], '--aim must not be given together with --azimuth'),
        (['--aim', 'x', 'y', '-s', '2'], '--aim must be a ball, or X Y, got x y'),
        (['--cut', '3', '-s', '2'], '--cut needs --aim BALL'),
        (['--aim', '9', '-s', '2'], '--aim must be a ball, or X Y, got 9 (m); the balls are: 8'),
        (['--aim', '0.1', '-s', '2'], 'or X Y, got 0.1 (m)'),
        (['--aim', '8', '--cut', '95', '-s', '2'], '--cut must be -90 to 90, got 95.0 (degrees)'),
        (['--aim', '1', '0', '--cut', '0', '-s', '2'], '--cut must not be given for a point'),
    ):
        assert main(['predict', scene, *wrong]) == 2
        assert text in capsys.readouterr().err


# --- the triangle of cue ball, ball and ghost ball -----------------------------------------------

DIAMETER = 0.05715


@pytest.mark.parametrize('distance', [0.06, 0.3, 2.0])
@pytest.mark.parametrize('cut', np.radians([-85.0, -30.0, 0.0, 10.0, 60.0]).tolist())
def test_the_ghost_ball_is_on_the_path_and_touches_the_ball(distance, cut):
    path = path_of_cut(distance, DIAMETER, cut)
    assert abs(path) < grazing(distance, DIAMETER)
    run = distance * math.cos(path) - DIAMETER * math.cos(cut)
    ghost = run * np.array([math.cos(path), math.sin(path)])
    across = np.array([distance, 0.0]) - ghost
    assert math.hypot(*across) == pytest.approx(DIAMETER, rel=1e-9)
    line = math.atan2(across[1], across[0])
    assert line - path == pytest.approx(cut, abs=1e-9)
    assert path_of_line(distance, DIAMETER, line) == pytest.approx(path, abs=1e-9)
    assert cut_of_path(distance, DIAMETER, path) == pytest.approx(cut, abs=1e-7)


def test_a_grazing_path_makes_a_cut_of_a_right_angle():
    assert abs(cut_of_path(0.3, DIAMETER, grazing(0.3, DIAMETER))) == pytest.approx(
        0.5 * math.pi, abs=1e-6
    )


# --- A stroke for which the cue has no room is refused, by name ----------------------------------

POOL = Scene.load('pool_table')
R = POOL.ball.radius


def scene_of(base=POOL, **balls):
    return dataclasses.replace(base, balls=balls)


def stroke(elevation_deg, azimuth=0.0, b=0.0):
    return Stroke.from_offsets(
        a=0, b=b, elevation=math.radians(elevation_deg), azimuth=azimuth, speed=1
    )


def test_a_level_cue_goes_through_the_cushion_behind_it():
    shot = predict(scene_of(cue=(-0.6, 0.0)), stroke(0))
    assert shot.status == Status.CUE_THROUGH_CUSHION
    assert 'the head cushion blocks the cue, by' in shot.message
    assert shot.trajectory.final_position == pytest.approx([-0.6, 0, R])
    assert shot.run.duration == 0.0
    assert predict(scene_of(cue=(-0.6, 0.0)), stroke(4)).status == Status.OK


def test_how_steep_it_has_to_be():
    # tip at the ball's middle height; a cone over the nose, 0.67 m - r behind the tip
    scene = scene_of(cue=(-0.6, 0.0))
    distance = 0.67 - R
    thick = 0.0065 + 0.008 * distance / 1.47
    lift = math.degrees(math.atan((0.635 * 2 * R - R + thick) / distance))
    assert predict(scene, stroke(lift - 0.3)).status == Status.CUE_THROUGH_CUSHION
    assert predict(scene, stroke(lift + 0.3)).status == Status.OK


def test_the_lowest_elevation_is_the_first_with_room():
    scene = scene_of(cue=(-0.6, 0.1), eight=(-0.9, 0.1))
    draw = np.random.default_rng(2)
    offsets = np.zeros((60, 5))
    offsets[:, :2] = draw.uniform(-0.35, 0.35, (60, 2))
    offsets[:, 3], offsets[:, 4] = draw.uniform(-math.pi, math.pi, 60), 1.0
    offsets[0] = 0.0, 0.1, 0.0, 0.0, 1.0
    lowest = lowest_elevation(scene, offsets)
    assert 0.0 < lowest[0] < math.radians(20.0)
    for row, least in zip(offsets, lowest, strict=True):
        a, b, _, azimuth, speed = row
        assert predict(scene, Stroke.from_offsets(a, b, least, azimuth, speed)).status < 100
        if least > math.radians(0.051):
            lower = Stroke.from_offsets(a, b, least - math.radians(0.051), azimuth, speed)
            assert predict(scene, lower).status.refused


def test_offsets_that_no_elevation_helps_have_none():
    scene = scene_of(cue=(-0.6, 0.1))
    rows = [(0.8, 0.8, 0, 0, 1), (0, 0, 0, 0, 0), (math.nan, 0, 0, 0, 1), (0, 0, 7, 0, 1)]
    lowest = lowest_elevation(scene, rows)
    assert np.isinf(lowest).tolist() == [True, True, True, False]
    elsewhere = lowest_elevation(scene, [(0, 0, 0, 0, 1)], position=(-1.2, 0.1, R))
    assert elsewhere[0] > lowest[3] + math.radians(1.0)
    with pytest.raises(ValueError, match=r'offsets must be of shape \(n, 5\), got \(5,\)'):
        lowest_elevation(scene, rows[0])


def test_far_from_all_cushions_level_is_level():
    wide = dataclasses.replace(POOL.table, length=6.0)
    assert predict(dataclasses.replace(POOL, table=wide, balls={}), stroke(0)).status == Status.OK


def test_a_ball_in_the_way_is_named():
    scene = scene_of(dataclasses.replace(POOL, table=None), cue=(0, 0), eight=(-0.3, 0.01))
    shot = predict(scene, stroke(0))
    assert shot.status == Status.CUE_THROUGH_BALL
    assert "ball 'eight' blocks the cue, by" in shot.message
    assert predict(scene, stroke(30)).status == Status.OK
    assert predict(scene, stroke(0, azimuth=0.5)).status == Status.OK
    ahead = scene_of(dataclasses.replace(POOL, table=None), cue=(0, 0), eight=(0.3, 0.0))
    assert predict(ahead, stroke(0)).status == Status.OK


def test_a_batch_refuses_the_same_rows():
    scene = scene_of(cue=(-0.6, 0.0), eight=(-0.6, -0.3))
    strokes = [stroke(e, a) for e in (0, 5, 30) for a in (0, math.pi / 2, math.pi)]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    single = [predict(scene, s).status for s in strokes]
    assert many.status.tolist() == single
    assert {Status.OK, Status.CUE_THROUGH_BALL, Status.CUE_THROUGH_CUSHION} == set(single)


def test_a_cue_of_unknown_shape_is_not_refused():
    paper = Scene.load('paper')
    assert paper.cue.length == 0
    blocked = dataclasses.replace(paper, balls={'cue': (0, 0), 'eight': (-0.2, 0)})
    assert predict(blocked, stroke(0)).status == Status.OK


@pytest.mark.parametrize('curvature', [0.0, 0.0105])
def test_the_elevation_in_the_message_is_allowed(curvature):
    cue = dataclasses.replace(POOL.cue, tip_curvature_radius=curvature)
    scene = dataclasses.replace(scene_of(cue=(-0.6, 0.0)), cue=cue)
    for b in (-0.8, -0.5, 0.0, 0.4):
        refused = predict(scene, stroke(0.0, b=b))
        if refused.status != Status.CUE_THROUGH_CUSHION:
            continue
        free = float(refused.message.split('at least ')[-1].split(',')[0])
        a, b_touching, _, azimuth, _ = refused.stroke.touching(curvature / R).offsets
        at = Stroke.from_offsets(a, b_touching, math.radians(free), azimuth, 1)
        assert not predict(scene, at).status.refused
