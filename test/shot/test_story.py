"""What people read of a shot: a sentence, facts, and attributes, the same in every scene."""

import dataclasses
import json
import math

import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, simulate, Status, Stroke
from billiard_shot.shot import shot as story
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.strike.placement import HOPS, HOPS_BEFORE_CUSHIONS

POOL = Scene.load('pool_table')
R = POOL.ball.radius
MISCUE = 'a miscue: the tip slid on the ball'


def scene_of(**balls):
    return dataclasses.replace(POOL, balls=balls)


def level(azimuth=0.0, speed=2.0, **offsets):
    return Stroke.from_offsets(**offsets, elevation_deg=6, azimuth=azimuth, speed=speed)


def straight_at_pocket(follow):
    """A pot into the corner at the foot, left; with follow, the cue ball goes after the ball."""
    place, pocket = np.array([1.0, 0.365]), np.array([1.27, 0.635])
    line = (pocket - place) / np.linalg.norm(pocket - place)
    scene = scene_of(cue=tuple(place - 0.3 * line), one=tuple(place))
    azimuth = math.atan2(line[1], line[0])
    return predict(scene, level(azimuth, 1.5, b=0.45 if follow else -0.4))


def test_a_pot_and_a_scratch_are_told():
    shot = straight_at_pocket(follow=True)
    assert shot.status == Status.OK
    assert shot.pocketed == {'one': 'foot_left', 'cue': 'foot_left'}
    assert shot.scratched
    assert shot.first_contact == 'one'
    assert shot.message == (
        'one into foot left; cue ball scratched into foot left; first contact one; at rest after '
        f'{shot.run.duration:.3g} s'
    )
    drawn = straight_at_pocket(follow=False)
    assert not drawn.scratched
    assert 'scratched' not in drawn.message
    assert drawn.message.startswith('one into foot left; first contact one; ')


def test_off_the_table_and_nothing_hit_are_told():
    jump = Stroke.from_offsets(elevation_deg=30, speed=8)
    shot = predict(scene_of(cue=(0.9, 0.0), one=(-0.5, 0.3)), jump)
    assert shot.off_table == ('cue',)
    assert shot.scratched
    assert shot.message.startswith('cue ball off the table; no ball hit; ')
    assert story.facts(shot)['first contact'] == 'none'


def test_a_touching_ball_is_the_first_contact():
    scene = scene_of(cue=(0.0, 0.0), near=(2.0 * R, 0.0), far=(0.6, 0.0))
    assert predict(scene, level()).first_contact == 'near'


def test_every_scene_has_every_attribute():
    """On an endless cloth they are those of the same ball on a table that it does not leave."""
    stroke = level(a=0.2, b=0.1, speed=0.5)
    cloth = predict('pool', stroke)
    wide = dataclasses.replace(
        Scene.load('pool'),
        table=dataclasses.replace(POOL.table, length=8.0, width=8.0, pockets=False),
    )
    # On a table smaller hops count: they matter at cushions.
    table = predict(wide, stroke, DEFAULT_SHOT_TOLERANCE * HOPS / HOPS_BEFORE_CUSHIONS)
    assert (cloth.pocketed, cloth.off_table, cloth.first_contact) == ({}, (), None)
    assert not cloth.scratched
    assert [e.kind for e in cloth.events] == [e.kind for e in table.events]
    for one, other in zip(cloth.events, table.events, strict=True):
        assert one.time == pytest.approx(other.time, abs=1e-9)
        assert one.balls == other.balls == ('cue',)
        # hops that are summed up lose a little between two events of the table's record
        assert one.energy_before == pytest.approx(other.energy_before, rel=1e-3, abs=1e-12)
        assert one.energy_after == pytest.approx(other.energy_after, rel=1e-3, abs=1e-12)
    assert cloth.final_position['cue'] == pytest.approx(table.final_position['cue'], abs=1e-9)
    assert cloth.events[-1].kind == EventKind.REST


def test_no_place_is_listed_if_all_balls_are_gone():
    shot = predict('pool_table', Stroke.from_offsets(0.1, 0.1, 0.1, 0.3, 2.0))
    assert shot.scratched
    assert 'rests at' not in str(shot)
    assert 'rests at' in str(predict('pool_table', level()))


def test_spin_is_named_by_its_effect():
    """Right is the side on which the cue hits; massé turns the path to its side."""
    for a, b, named in (
        (0.3, 0.0, 'right'),
        (-0.3, 0.0, 'left'),
        (0.0, 0.4, 'top'),
        (0.0, -0.4, 'back'),
    ):
        said = story.facts(predict('pool', level(azimuth=1.0, a=a, b=b)))['spin'].removesuffix(
            ' rad/s'
        )
        assert {named} == {'top', 'back', 'left', 'right'} & {
            name
            for name, size in map(str.split, said.split(', massé')[0].split(', '))
            if float(size) > 10.0
        }, said
    for a, side in ((0.4, 'right'), (-0.4, 'left')):
        shot = predict('pool', Stroke.from_offsets(a, 0.0, elevation_deg=60, azimuth=1.0, speed=2))
        assert f'massé {side}' in story.facts(shot)['spin']
        before, after = shot.velocity, shot.trajectory.at(0.5 * shot.trajectory.duration).velocity
        turn = before[0] * after[1] - before[1] * after[0]
        assert (turn < 0.0) == (side == 'right')
    assert story.facts(predict('paper', Stroke((-1, 0, 0), (1, 0, 0))))['spin'].startswith(
        '0.0 rad/s'
    )


def test_a_refused_stroke_has_them_too():
    shot = predict('blocked', Stroke.from_offsets(speed=3))
    assert shot.status == Status.CUE_THROUGH_CUSHION
    assert shot.events == ()
    assert {name: tuple(place[:2]) for name, place in shot.final_position.items()} == dict(
        shot.scene.balls
    )
    assert story.facts(shot) == {}
    assert ', got 0 (degrees)' in shot.message


def test_the_elevation_that_a_refusal_names_has_room():
    shot = predict('blocked', Stroke.from_offsets(b=0.1, speed=3))
    said = float(shot.message.rsplit('at least ')[1].split(',')[0])
    again = predict('blocked', Stroke.from_offsets(b=0.1, elevation_deg=said, speed=3))
    assert again.status == Status.OK
    below = Stroke.from_offsets(b=0.1, elevation_deg=said - 0.25, speed=3)
    assert predict('blocked', below).status.refused


def test_the_elevation_is_for_the_place_of_the_ball():
    stroke = Stroke.from_offsets(b=0.1, speed=1)
    for x in (-0.9, -1.2):
        said = predict('pool_table', stroke, position=(x, 0.2)).message.rsplit('at least ')[1]
        steep = Stroke.from_offsets(b=0.1, elevation_deg=float(said.split(',')[0]), speed=1)
        assert predict('pool_table', steep, position=(x, 0.2)).status == Status.OK


def test_a_miscue_says_why():
    shot = predict('pool', Stroke.from_offsets(b=0.9, speed=2))
    assert shot.status == Status.OK
    assert shot.message.startswith(f'{MISCUE}; at rest after ')


def test_a_miscue_does_not_hide_how_the_run_ends():
    scene = Scene.from_dict({'like': 'pool', 'effects': {'roll': 'off'}})
    shot = predict(scene, Stroke.from_offsets(0.85, 0, 0.02, 0, 2))
    assert shot.status == Status.NEVER_RESTS
    assert shot.message.startswith('nothing stops the ball: ')
    assert shot.message.endswith(f'; {MISCUE}')
    assert f' mm until {shot.trajectory.duration:.3g} s' in str(shot).splitlines()[-1]


def test_a_number_keeps_its_unit():
    stroke = Stroke.from_offsets(-0.36, -0.11, elevation_deg=56, azimuth_deg=-30.4, speed=1.94)
    assert '1.94 m/s' in [line.strip() for line in str(predict('pool', stroke)).splitlines()]


def test_text_is_narrow_and_says_everything():
    shot = predict('eight_ball', level(math.radians(-6.1), 8.0, b=0.1))
    lines = str(shot).splitlines()
    assert max(map(len, lines)) <= 80
    text = ' '.join(line.strip() for line in lines)
    assert text.startswith(f'OK: {shot.message}')
    balls = [line.split()[1] for line in lines if line.startswith('  ball ')]
    assert balls == [str(number) for number in range(1, 16)]  # a line each, sorted
    assert lines.index(next(line for line in lines if line.startswith('  ball 1 '))) == 1 + (
        lines.index(next(line for line in lines if line.startswith('  cue ball  ')))
    )
    html = shot._repr_html_()
    assert shot.message in html
    assert html.count('<tr>') == len(story.facts(shot))


def test_objects_say_what_they_are():
    stroke = Stroke.from_offsets(a=0.2, elevation_deg=5, azimuth_deg=30, speed=2)
    assert repr(stroke) == 'Stroke(a=0.2, b=0, elevation_deg=5, azimuth_deg=30, speed=2)'
    assert eval(repr(stroke), {'Stroke': Stroke.from_offsets}).velocity == pytest.approx(
        stroke.velocity
    )
    assert repr(Stroke((1, 0, 0), (1, 0, 0))).endswith('misses the ball)')
    assert repr(POOL) == 'Scene(1 ball on a table of 2.54 x 1.27 m, law bistiffness)'
    shot = straight_at_pocket(follow=True)
    assert repr(shot) == f'Shot(OK: {shot.message})'
    assert 'one into foot left, cue into foot left' in repr(shot.run)
    run = simulate('pool_table', {'cue': BallState((0, 0, R), (1, 0, 0))})
    assert repr(run).startswith('TableRun(OK, 1 ball, ')
    assert repr(run.at(0.0)['cue']).startswith('BallState(position=(0, 0, 0.0286), velocity=(1')
    assert repr(run.at([0.0, 1.0])['cue']) == 'BallState(at (2,) times)'
    for thing in (POOL, stroke, shot, shot.run, shot.trajectory, shot.events[0]):
        assert len(repr(thing)) < 200


def test_a_shot_draws_itself(tmp_path, monkeypatch):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    shot = straight_at_pocket(follow=True)
    figure = shot.plot(tmp_path / 'shot.png')
    title = figure.axes[0].get_title('left').replace('\n', ' ')
    assert title.lower() == shot.message.lower()
    assert (tmp_path / 'shot.png').read_bytes()[:4] == b'\x89PNG'


def test_a_shot_opens_its_page(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr('webbrowser.open', opened.append)
    shot = straight_at_pocket(follow=True)
    velocity = json.dumps(list(shot.stroke.velocity))
    assert f'"velocity": {velocity}' in shot.view(tmp_path / 'shot.html').read_text()
    assert opened == []
    assert shot.view().as_uri() == opened[0]
    assert len(opened) == 1


def test_a_refused_shot_overwrites_no_page(tmp_path):
    page = tmp_path / 'shot.html'
    page.write_text('kept')
    with pytest.raises(ValueError, match='not written: CUE_THROUGH_CUSHION'):
        predict('blocked', Stroke.from_offsets(speed=3)).view(page)
    assert page.read_text() == 'kept'


def test_batches_count_and_list_miscues():
    pytest.importorskip('pandas')
    strokes = [(offset, 0.0, 0.02, 0.0, 2.0) for offset in (0.0, 0.8, 0.9)]
    batch = predict_batch('pool', offsets=strokes)
    assert repr(batch) == 'StrokeBatch(3 strokes: 3 OK; 2 miscues)'
    shots = [predict('pool', Stroke.from_offsets(*stroke)) for stroke in strokes]
    assert batch.miscue.tolist() == [shot.miscue for shot in shots] == [False, True, True]
    assert batch.to_frame()['miscue'].tolist() == batch.miscue.tolist()


def test_tables_for_pandas():
    pytest.importorskip('pandas', reason='needs pandas, an extra')
    shot = straight_at_pocket(follow=True)
    frame = shot.to_frame()
    assert frame['time'].tolist() == [event.time for event in shot.events]
    strokes = [level(), Stroke((1, 0, 0), (1, 0, 0))]
    batch = predict_batch(POOL, [s.normal for s in strokes], [s.velocity for s in strokes])
    assert repr(batch) == 'StrokeBatch(2 strokes: 1 OK, 1 MISS)'
    assert batch.to_frame()['status'].tolist() == ['OK', 'MISS']


def test_pandas_is_named_if_it_is_missing(monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'pandas', None)
    with pytest.raises(ValueError, match=r'billiard_shot\[frame\]'):
        predict('pool', level()).to_frame()


def test_a_sentence_is_in_the_record(tmp_path):
    from billiard_shot import load_shot, save_shot

    shot = straight_at_pocket(follow=True)
    save_shot(shot, tmp_path / 'shot.json')
    assert json.loads((tmp_path / 'shot.json').read_text())['message'] == shot.message
    assert load_shot(tmp_path / 'shot.json').message == shot.message


def test_a_ball_that_is_not_there_is_told_with_those_that_are():
    run = predict(scene_of(cue=(0, 0), one=(0.5, 0)), level()).run
    for balls in (run.balls, run.final_position, run.at(0.1)):
        with pytest.raises(KeyError, match="ball must be one of cue, one, got '9'"):
            balls['9']
