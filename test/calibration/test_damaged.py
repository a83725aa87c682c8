"""
Damaged recordings: a message names the place, or the calibration says what it left out.

Each kind of damage is done to a file of six good shots.
"""

from dataclasses import replace
import re

import pytest
from simulated import simulated_recording

from billiard_shot import Scene
from billiard_shot.calibration import reader
from billiard_shot.calibration.calibrate import calibrate
from billiard_shot.calibration.reader import read_recordings, write_csv
from billiard_shot.calibration.recording import usable_shots

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
    'millimetres': (lambda r: changed(r, scaled(1e3)), r'got values to 1\d+; are they in mm'),
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
    'milliseconds': (lambda r: changed(r, scaled(1e3, (1,))), "shot '0': time .*is it in ms"),
    'empty': (lambda _: [['']], 'line 1: shot is missing in the header'),
    'only a header': (lambda r: r[:1], 'must have a line for each sight'),
    'no header': (lambda r: r[1:], 'line 1: shot is missing in the header'),
    'a column of another kind': (
        lambda r: [[*r[0][:3], 'px', *r[0][4:]], *r[1:]],
        'line 1: x is missing',
    ),
    'a line too short': (lambda r: changed(r, lambda row: row[:3], first(r)), 'line 2: a line'),
    'a line too long': (lambda r: changed(r, lambda row: [*row, '1'], first(r)), 'line 2: a line'),
    'a decimal comma': (
        lambda r: changed(r, lambda row: [each.replace('.', ',') for each in row]),
        'line 2: a line must be 6 fields',
    ),
    'a word': (lambda r: changed(r, with_cell(3, 'left'), first(r)), "line 2: x .*got 'left'"),
    'a place without end': (lambda r: changed(r, with_cell(3, 'inf'), first(r)), 'line 2: x'),
    'a time that is none': (lambda r: changed(r, with_cell(1, 'nan'), first(r)), 'line 2: time'),
    'no name of a ball': (lambda r: changed(r, with_cell(2, ' '), first(r)), 'line 2: ball must'),
    'an unprintable name': (lambda r: changed(r, with_cell(2, 'a\x07'), first(r)), 'line 2: ball'),
    'a deviation of nothing': (lambda r: changed(r, with_cell(5, '0'), first(r)), 'line 2: sigma'),
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
