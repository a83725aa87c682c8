"""Recordings from files: what is read, what is left out, and what is wrong in which line."""

from contextlib import suppress
from dataclasses import replace
import math
from pathlib import Path
import re

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from simulated import simulated_recording

from billiard_shot import InputError, Scene
from billiard_shot.calibration import reader
from billiard_shot.calibration.calibrate import calibrate
from billiard_shot.calibration.reader import read_csv, read_recording, read_recordings, write_csv
from billiard_shot.calibration.recording import (
    Frame,
    RecordedShot,
    Recording,
    StrokeErrors,
    Track,
    usable_shots,
)
from billiard_shot.scene import Noise

HEADER = 'shot,time,ball,x,y\n'


@pytest.fixture
def file(tmp_path):
    def write(text, name='seen.csv'):
        path = tmp_path / name
        path.write_text(text, encoding='utf-8')
        return path

    return write


def test_lines_of_any_order_and_rate_are_read(file):
    recording = read_recording(
        file(
            'ball,shot,time,x,y,sigma,z\ncue,1,0.5,1,2,,\n8,1,0,-1,0.25,0.002,0.03\ncue,1,0.13,1,3,,\n'
        )
    )
    (shot,) = recording.shots
    assert (shot.name, list(shot.tracks)) == ('1', ['cue', '8'])
    assert shot.tracks['cue'].time.tolist() == [0.13, 0.5]
    assert shot.tracks['cue'].place.tolist() == [[1.0, 3.0], [1.0, 2.0]]
    assert (shot.tracks['8'].sigma.tolist(), shot.struck, recording.ignored) == ([0.002], None, ())


def test_balls_that_were_not_detected_and_doubled_times_are_left_out_and_counted(file):
    recording = read_csv(file(HEADER + '1,0,cue,0,0\n1,1,cue,,\n1,2,cue,nan,0\n1,0,cue,1,1\n'))
    assert recording.shots[0].tracks['cue'].place.tolist() == [[0.0, 0.0]]
    assert recording.ignored == (
        '2 lines without x or y: the balls were not detected',
        "shot '1': 1 lines with the time of another one",
    )


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'shot is missing in the header'),
        ('shot,time,ball,x\n', 'line 1: y is missing in the header'),
        ('shot,time,ball,x,y,hue\n', 'line 1: hue is unknown; the nearest key is'),
        ('shot,time,ball,x,y,x\n', 'line 1: x is there twice'),
        (HEADER, 'must have a line for each sight of a ball'),
        (HEADER + '1,0,cue,0,0\n1,0,cue,0\n', 'line 3: a line must be 5 fields'),
        (HEADER + '1,0,cue,0,0,0\n', 'line 2: a line must be 5 fields'),
        (
            HEADER + '1,soon,cue,0,0\n',
            "line 2: time must be a number from -1e+07 to 1e+07, got 'soon' (s)",
        ),
        (HEADER + '1,nan,cue,0,0\n', 'line 2: time must be a number'),
        (HEADER + '1,0,cue,left,0\n', 'line 2: x must be a number'),
        (
            HEADER + '1,0,cue,710,0\n',
            'x and y must be in m, got values to 702.9; are they in mm or pixels?',
        ),
        (HEADER + '1,0,cue,inf,0\n', 'line 2: x must be a number from -10 to 10'),
        (HEADER + '1,0,,0,0\n', 'line 2: ball must be a name'),
        (
            HEADER + '1,0,cue,0,0\n1,9000,cue,0,0\n',
            "shot '1': time must be within 120 s of the first, got 9000 s; is it in ms?",
        ),
        ('shot,time,ball,x,y,sigma\n1,0,cue,0,0,0\n', 'line 2: sigma must be a number from 1e-06'),
    ],
)
def test_what_is_wrong_is_named_with_file_line_and_field(file, text, said):
    path = file(text)
    with pytest.raises(ValueError, match=r'seen\.csv') as caught:
        read_recording(path)
    assert said in str(caught.value)


def test_all_wrong_lines_are_named_at_once_but_no_more_than_a_message_holds(file):
    with pytest.raises(InputError) as caught:
        read_csv(file(HEADER + '1,x,cue,0,0\n' * 10_000))
    assert [each.line for each in caught.value.mistakes[:3]] == [2, 3, 4]
    assert len(caught.value.mistakes) < 100


def test_files_that_are_no_recording_are_refused(file, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r'none.csv: No such file'):
        read_recording(tmp_path / 'none.csv')
    with pytest.raises(ValueError, match=r'must be a file .csv or .json'):
        read_recording(file('', 'seen.txt'))
    (tmp_path / 'film.csv').write_bytes(b'\xff\xfe\x00film')
    with pytest.raises(ValueError, match=r'film.csv: must be a text in CSV'):
        read_recording(tmp_path / 'film.csv')
    with pytest.raises(ValueError, match=r'seen.json: must be a list of shots'):
        read_recording(file('{}', 'seen.json'))
    with pytest.raises(ValueError, match=r'seen.json: must be a text in JSON'):
        read_recording(file('[' * 100_000, 'seen.json'))
    nothing = '[{"id": 1, "balls": {"1": {"t": [0], "x": [NaN], "y": [0]}}}]'
    for text in ('[{"id": 1}]', nothing):
        with pytest.raises(ValueError, match=r'seen.json: shot 0: must have id, and t, x and y'):
            read_recording(file(text, 'seen.json'))
    monkeypatch.setattr(reader, 'MOST_BYTES', 10)
    with pytest.raises(ValueError, match=r'must have at most 10 bytes, got \d+; divide it'):
        read_recording(file(HEADER))


def test_the_description_names_balls_frame_scene_and_strokes(file):
    path = file(HEADER + '1,0,white,0,0\n1,0,red,1,0\n')
    file(
        'scene: carom\nstruck: cue\nsigma: 0.002\nballs: {white: cue}\n'
        'frame: {x: 0.1, angle_deg: 90, scale: 2, rate: 1.001}\nstrokes: {1: {speed: 2}}\n'
        'noise: {a: 0.001, speed: 0.05}\n',
        'seen.yaml',
    )
    recording = read_recording(path)
    (shot,) = recording.shots
    assert (list(shot.tracks), shot.struck, recording.scene) == (['cue', 'red'], 'cue', 'carom')
    assert shot.tracks['cue'].sigma.tolist() == [0.002]
    assert shot.stroke.offsets[4] == pytest.approx(2.0)
    assert shot.command == StrokeErrors(Noise(a=0.001, speed=0.05), measured=False)
    assert recording.frame == Frame(0.1, 0.0, math.pi / 2, 2.0, 1.001)


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('sigmas: 1', 'seen.yaml: line 1: sigmas is unknown; the nearest key is sigma'),
        ('frame:\n  scale: 0', 'seen.yaml: line 2: frame.scale must be a finite number above 0'),
        ('noise: {speed: -1}', 'seen.yaml: line 1: noise.speed must be a finite number'),
        ('strokes: {7: {speed: 2}}', "strokes: no shot '7'"),
        ('strokes: {1: {sped: 2}}', 'sped is unknown'),
        ('balls: {white: red}', "shot '1' has two balls with the same name"),
    ],
)
def test_mistakes_of_a_description_are_named(file, text, said):
    path = file(HEADER + '1,0,white,0,0\n1,0,red,1,0\n')
    file(text, 'seen.yaml')
    with pytest.raises(ValueError, match=r'yaml|balls') as caught:
        read_recording(path)
    assert said in str(caught.value)


NAMES = st.text('abc 8,"\'é', min_size=1, max_size=4).map(str.strip).filter(bool)
COORDINATES = st.floats(-9.9, 9.9).map(lambda value: float(f'{value:.5g}'))
TRACKS = st.lists(
    st.tuples(st.integers(0, 5000), COORDINATES, COORDINATES, st.sampled_from([1e-3, 2e-3])),
    min_size=1,
    max_size=6,
    unique_by=lambda row: row[0],
)


@given(st.dictionaries(NAMES, st.dictionaries(NAMES, TRACKS, min_size=1), min_size=1))
@settings(max_examples=25, deadline=None)
def test_what_is_written_is_read_again(tmp_path_factory, shots):
    def track(rows):
        columns = np.array(sorted(rows))
        return Track(columns[:, 0] / 100.0, columns[:, 1:3], columns[:, 3])

    made = tuple(
        RecordedShot(name, {ball: track(rows) for ball, rows in balls.items()})
        for name, balls in shots.items()
    )
    path = tmp_path_factory.mktemp('written') / 'seen.csv'
    write_csv(Recording('made', made), path)
    read = read_csv(path)
    assert [(each.name, list(each.tracks)) for each in read.shots] == [
        (each.name, list(each.tracks)) for each in made
    ]
    for one, other in zip(read.shots, made, strict=True):
        for ball, found in one.tracks.items():
            for field in ('time', 'place', 'sigma'):
                assert np.array_equal(getattr(found, field), getattr(other.tracks[ball], field))


@given(st.text('0123456789.,-+e"naif\n ', max_size=200))
@settings(max_examples=50, deadline=None)
def test_any_text_is_read_or_refused(tmp_path_factory, text):
    path = tmp_path_factory.mktemp('any') / 'any.csv'
    path.write_text(HEADER + text)
    with suppress(ValueError):  # any other exception is a bug
        for shot in read_csv(path).shots:
            for track in shot.tracks.values():
                assert np.isfinite(track.place).all()
                assert (np.diff(track.time) > 0.0).all()


@given(
    st.builds(
        Frame, COORDINATES, COORDINATES, st.floats(-4.0, 4.0), st.floats(0.5, 2.0), st.just(1.0)
    ),
    st.lists(st.tuples(COORDINATES, COORDINATES), min_size=1, max_size=3).map(np.array),
)
@settings(deadline=None)
def test_frames_lead_there_and_back(frame, places):
    assert frame.to_table(frame.to_recording(places)) == pytest.approx(places, abs=1e-9)
    turned = frame.to_recording(np.array([1.0, 0.0])) - np.array([frame.x, frame.y])
    assert turned == pytest.approx(
        frame.scale * np.array([math.cos(frame.angle), math.sin(frame.angle)])
    )


def test_a_converter_fills_the_time_in_which_a_ball_rests(tmp_path: Path):
    path = tmp_path / 'shots.json'
    path.write_text(
        '[{"id": 3, "balls": {"1": {"t": [0, 0.02, 0.02, 0.06], "x": [0, 0.02, 0.03, 0.06], '
        '"y": [0, 0, 0, 0]}, "2": {"t": [0, 0.5], "x": [1, 1.001], "y": [0.5, 0.5]}}}]'
    )
    (shot,) = read_recording(path).shots
    assert shot.tracks['1'].time.tolist() == [0.0, 0.02, 0.06]  # of two with one stamp, the first
    assert shot.tracks['2'].time == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert shot.tracks['2'].place[3].tolist() == [1.0, 0.5]


# --- damaged recordings: a message names the place, or the calibration says what it left out -----

CAROM = Scene.load('carom')


@pytest.fixture(scope='module')
def rows(tmp_path_factory):
    """The lines of a good file, split, the header first."""
    path = tmp_path_factory.mktemp('good') / 'good.csv'
    shots = simulated_recording(replace(CAROM, balls={}), 6, 2, longest=0.8)
    write_csv(shots, path)
    return [line.split(',') for line in path.read_text().splitlines()]


def examined(path):
    """Read a file as a calibration does; return the shots that can be used, what is ignored."""
    usable, ignored, _ = usable_shots(CAROM, read_recordings(path))
    return usable, ignored


def written(path, rows, delimiter=',', end='\n', encoding='utf-8'):
    text = end.join(delimiter.join(row) for row in rows) + end
    path.write_bytes(text.encode(encoding))
    return path


def changed(rows, change, where=lambda _: True):
    """Change the lines for which a condition holds; None leaves a line out."""
    header, *lines = rows
    new = [change(list(row)) if where(row) else row for row in lines]
    return [header, *(row for row in new if row is not None)]


def of(shot, ball=None, since=-9.0, until=99.0):
    """Return the condition that a line belongs to a shot and ball, and to a span of time."""
    return lambda row: row[0] == shot and ball in (None, row[2]) and since <= float(row[1]) < until


def scaled(factor, columns=(3, 4)):
    """Return the change that multiplies columns."""
    return lambda row: [
        f'{factor * float(each):.6g}' if k in columns else each for k, each in enumerate(row)
    ]


def moved(dx):
    return lambda row: [*row[:3], f'{float(row[3]) + dx:.6g}', *row[4:]]


def with_cell(column, text):
    return lambda row: [*row[:column], text, *row[column + 1 :]]


def without(_):
    return None


def first(rows):
    return lambda row: row is rows[1]


def other_ball(row):
    other = {'white': 'yellow', 'yellow': 'white'}
    return [*row[:2], other.get(row[2], row[2]), *row[3:]]


REFUSED = {
    'inches': (
        lambda r: changed(r, scaled(39.37)),
        r'must be in m, .*are they in cm or inches\? 5',
    ),
    'feet': (lambda r: changed(r, scaled(3.28)), 'places are outside of the table'),
    'centimetres': (lambda r: changed(r, scaled(1e2)), r'got values to 1\d\d.*; are they in cm'),
    'pixels': (
        lambda r: changed(changed(r, moved(1.42)), scaled(600.0)),
        r'got values to \d+; are they in mm or pixels',
    ),
    'from a corner': (lambda r: changed(r, moved(1.42)), 'outside of the table, x from .*frame'),
    'x and y exchanged': (
        lambda r: changed(r, lambda row: [*row[:3], row[4], row[3], *row[5:]]),
        'outside of the table',
    ),
    'a decimal comma': (
        lambda r: changed(r, lambda row: [each.replace('.', ',') for each in row]),
        'line 2: a line must be 6 fields',
    ),
    'an unprintable name': (lambda r: changed(r, with_cell(2, 'a\x07'), first(r)), 'line 2: ball'),
}


@pytest.mark.parametrize('kind', REFUSED)
def test_a_message_names_the_place(kind, rows, tmp_path):
    damage, said = REFUSED[kind]
    path = written(tmp_path / 'bad.csv', damage(rows))
    with pytest.raises(ValueError, match=r'bad\.csv') as caught:
        examined(path)
    assert re.search(said, str(caught.value)), caught.value


@pytest.mark.parametrize(
    ('form', 'said'),
    [
        ({'delimiter': ';'}, 'line 1: fields must be separated by commas, got semicolons'),
        ({'encoding': 'utf-16'}, 'must be a text in CSV'),
    ],
)
def test_another_form_is_refused(form, said, rows, tmp_path):
    with pytest.raises(ValueError, match=said):
        examined(written(tmp_path / 'bad.csv', rows, **form))


@pytest.mark.parametrize('suffix', ['csv', 'json'])
def test_a_file_that_is_too_large_is_not_read(suffix, tmp_path):
    path = tmp_path / f'bad.{suffix}'
    with path.open('wb') as file:
        file.truncate(2 * 1024**3)  # takes no room on the disk
    with pytest.raises(ValueError, match=f'at most {reader.MOST_BYTES} bytes, got 2147483648'):
        examined(path)


IGNORED = {  # the damage, the shots that can be used, and what is said
    'a ball that takes the place of another': (
        lambda r: changed(r, other_ball, of('2', since=0.8)),
        6,
        r"shot '2': ball 'white' jumps at 0\.[78]\d* s",
    ),
    'doubled stamps': (lambda r: [*r, *r[1:9]], 6, "shot '0': 8 lines with the time of another"),
    'two shots with one name': (
        lambda r: changed(r, with_cell(0, '1'), of('2')),
        5,
        r"shot '1': \d+ lines with the time of another",
    ),
    'places that are no numbers': (
        lambda r: changed(r, with_cell(3, 'NaN'), of('3', 'red')),
        6,
        r'\d+ lines without x or y: the balls were not detected',
    ),
    'a shot of one sample': (
        lambda r: changed(r, without, of('4', since=0.03)),
        5,
        "shot '4': no ball moves",
    ),
    'a ball that no camera saw after the strike': (
        lambda r: changed(r, without, of('5', 'white', since=0.36)),
        5,
        "shot '5': ",
    ),
    'a shot in which nothing moves': (
        lambda r: changed(r, without, of('0', since=0.3)),
        5,
        "shot '0': no ball moves",
    ),
}


@pytest.mark.parametrize('kind', IGNORED)
def test_what_is_left_out_is_said(kind, rows, tmp_path):
    damage, count, said = IGNORED[kind]
    usable, ignored = examined(written(tmp_path / 'bad.csv', damage(rows)))
    assert len(usable) == count
    assert any(re.search(said, each) for each in ignored), ignored
    assert all('bad.csv' in each for each in ignored)


HARMLESS = {
    'shuffled': (lambda r: [r[0], *sorted(r[1:], key=lambda row: row[::-1])], {}),
    'backwards': (lambda r: [r[0], *r[:0:-1]], {}),
    'with empty lines': (lambda r: [r[0], [''], *r[1:], ['']], {}),
    'with times below zero': (
        lambda r: changed(r, lambda row: [row[0], f'{float(row[1]) - 5.0:.6g}', *row[2:]]),
        {},
    ),
    'with a byte order mark': (lambda r: r, {'encoding': 'utf-8-sig'}),
    'with lines of Windows': (lambda r: r, {'end': '\r\n'}),
    'with odd names': (lambda r: changed(r, with_cell(0, '7 / №'), of('1')), {}),
    'with a sample elsewhere': (
        lambda r: changed(r, moved(0.4), of('1', 'white', 0.795, 0.805)),
        {},
    ),
    'half of the table': (
        lambda r: changed(r, without, lambda row: row[2] != 'white' and float(row[3]) > 0.0),
        {},
    ),
}


@pytest.mark.parametrize('kind', HARMLESS)
def test_what_does_no_harm_is_read(kind, rows, tmp_path):
    change, form = HARMLESS[kind]
    usable, ignored = examined(written(tmp_path / 'good.csv', change(rows), **form))
    assert len(usable) == 6
    assert not ignored
    good, _ = examined(written(tmp_path / 'as_it_was.csv', rows))
    for one, other in zip(sorted(usable, key=place), sorted(good, key=place), strict=True):
        assert one.velocity == pytest.approx(other.velocity, rel=0.1)


def place(usable):
    return tuple(usable.rest[0])


def test_a_calibration_says_what_it_left_out(rows, tmp_path):
    damage, _, said = IGNORED['a ball that takes the place of another']
    path = written(tmp_path / 'bad.csv', damage(rows))
    found = calibrate(path, CAROM, names=['cloth.sliding_friction'], horizon=0.5, held_out=0.0)
    assert any(re.search(said, each) for each in found.ignored)
    low, high = found.estimates[0].interval
    assert low < CAROM.cloth.sliding_friction < high
