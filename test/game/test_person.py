"""A person plays at the terminal: what is typed, and what is read then."""

from contextlib import suppress
from dataclasses import replace
import io
import math
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from hypothesis import example, given, strategies
import numpy as np
import pytest

from billiard_shot import aim, predict, Scene
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, INTERRUPTED, WRONG_INPUT
from billiard_shot.cli.person import Person
from billiard_shot.game import Pairing, play, start
from billiard_shot.game.rack import RackRecord
from billiard_shot.game.state import Call
from billiard_shot.game.strokes import listed_shots
from billiard_shot.game.typed import (
    read_choice,
    read_confirmation,
    read_outcome,
    read_place,
    read_shot,
    ShotReport,
)
from billiard_shot.shot.lowest_elevation import refusals_in
from billiard_shot.shot.stroke import vectors_of

PRACTICE = 'play practice --balls 2 --scene seven_foot --players person'
PLACED = '-0.4 0.1\n\n'  # with Enter
TABLE = Scene.load('seven_foot')


@pytest.fixture
def types(monkeypatch, capsys):
    """Return a function that runs a command and types a text: exit code, and both outputs."""

    def run(command, text):
        monkeypatch.setattr('sys.stdin', io.StringIO(text))
        code = main(command.split())
        return code, *capsys.readouterr()

    return run


def test_wrong_lines_are_asked_again_and_never_fouls(types, tmp_path):
    file = tmp_path / 'game.json'
    wrong = ['?', '', 'abc', '99', 'corner', '0 0 1 20 2', '0 0 - 20 99', 'aim 7 3', 'push 0', 'u']
    lines = ['?', 'x', '9 9', '-0.4 0.1', '', *wrong, '0', '']
    code, out, err = types(f'{PRACTICE} --state {file}', '\n'.join(lines) + '\n')
    assert code == INTERRUPTED
    for sentence in (
        'X Y                    place the cue ball (m)',
        "X Y must be 2 numbers, got 'x'",
        'the cue ball must be at x ',
        'N [SPEED [B [A]]]      play shot N of the list',
        'an empty line is not a shot; type ? for help',
        "'abc' is not a shot; type ? for help",
        "N must be 0 to 1 in the list, got '99'",
        "'corner' is not a shot",
        'ELEVATION must be at least ',
        'SPEED must be 0.1 to ',
        'BALL must be one of 1, 2, got ',
        'push is allowed only in the first shot',
    ):
        assert sentence in out
    record = RackRecord.load(file)
    assert [(shot.kept, shot.fouls) for shot in record.shots] == [(True, ())]
    assert 'Traceback' not in out + err


def test_a_typed_shot_and_a_place_are_taken_back(types, tmp_path):
    file = tmp_path / 'game.json'
    lines = '0.4 0.1\nu\n-0.4 0.1\n\naim 1 2\nu\n0 0.1 - 30 1.5\nno\n\n'
    code, out, _ = types(f'{PRACTICE} --state {file}', lines)
    assert (code, out.count('u takes it back')) == (0, 5)
    assert "'no' is neither Enter nor u" in out
    (shot,) = RackRecord.load(file).shots
    assert shot.state['balls']['cue'] == [-0.4, 0.1]
    assert shot.offsets[4] == pytest.approx(1.5)
    assert re.search(r'you \(0 0\.1 - 30 1\.5\): .*\nnobody wins\n$', out)


def test_a_game_goes_on_from_its_file_as_if_it_had_not_ended(types, tmp_path):
    one, two = tmp_path / 'one.json', tmp_path / 'two.json'
    shots = '0\n\n', 'aim 2 2\n\n'
    types(f'{PRACTICE} --state {one}', PLACED + ''.join(shots))
    code, _, err = types(f'{PRACTICE} --state {two}', PLACED + shots[0])
    assert code == INTERRUPTED
    assert f'to go on with this game: the same command with --state {two}\n' in err
    code, out, _ = types(f'{PRACTICE} --state {two} --pages {tmp_path / "pages"}', shots[1])
    assert code == 0
    assert out.startswith('you (1 to ')  # the last shot before
    whole, in_parts = (RackRecord.load(file) for file in (one, two))
    timeless = [[replace(shot, cpu=0.0, wall=0.0) for shot in r.shots] for r in (whole, in_parts)]
    assert timeless[0] == timeless[1]
    assert whole.state == in_parts.state
    assert len(list((tmp_path / 'pages').glob('shot-*.html'))) == 2
    assert 'person (1 to ' in (tmp_path / 'pages' / 'index.html').read_text()
    code, out, _ = types(f'{PRACTICE} --state {two}', '')  # is over
    assert (code, out.splitlines()[-1]) == (0, 'nobody wins')


def test_an_interrupted_game_is_kept_without_a_file_and_has_its_pages(
    types, tmp_path, monkeypatch
):
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    code, out, err = types(f'{PRACTICE} --pages {tmp_path / "pages"}', PLACED + '0\n\n')
    assert code == INTERRUPTED
    file = Path(re.search('--state (.*)', err)[1])
    assert len(RackRecord.load(file).shots) == 1
    assert str(tmp_path / 'pages' / 'index.html') in out
    assert 'not finished' in (tmp_path / 'pages' / 'index.html').read_text()
    assert err.endswith('billiard-shot: interrupted\n')
    _, _, err = types(PRACTICE, PLACED)
    assert err == 'billiard-shot: interrupted\n'  # nothing to keep


@pytest.mark.parametrize(
    ('command', 'text'),
    [
        ('play nine_ball --scene seven_foot', 'is a game with game practice, not nine_ball'),
        ('play practice --players greedy --scene seven_foot', "with players ('person',), not"),
        ('play practice --players person', 'with length 1.9812, not 2.54'),
    ],
)
def test_a_file_of_another_game_is_refused(command, text, types, tmp_path):
    file = tmp_path / 'game.json'
    types(f'{PRACTICE} --state {file}', PLACED + '0\n\n')
    code, _, err = types(f'{command} --state {file}', '')
    assert (code, text in err) == (2, True)


@pytest.mark.parametrize('content', ['', '[]', '{"a": 1}', '{"shots": 3}', 'hello'])
def test_a_file_that_is_no_game_is_named(content, types, tmp_path):
    file = tmp_path / 'game.json'
    file.write_text(content)
    code, _, err = types(f'{PRACTICE} --state {file}', '')
    assert (code, err) == (2, f'billiard-shot: {file}: must be the record of a rack\n')


def test_a_wrong_place_of_the_file_is_refused_before_the_game(types, tmp_path):
    code, out, err = types(f'{PRACTICE} --state {tmp_path / "nowhere" / "game.json"}', '')
    assert (code, out) == (2, '')
    assert '--state must be in a folder that exists' in err


@pytest.mark.parametrize('word', ['quit', 'exit', 'q', 'SAVE'])
def test_a_word_ends_the_game_and_keeps_it(types, tmp_path, word):
    file = tmp_path / 'game.json'
    code, _, err = types(f'{PRACTICE} --state {file}', PLACED + f'0\n\n{word}\n')
    assert code == DONE
    assert err == f'\nto go on with this game: the same command with --state {file}\n'
    assert len(RackRecord.load(file).shots) == 1


def test_too_many_players_are_refused(types):
    code, _, err = types('play practice --players greedy random', '')
    assert code == WRONG_INPUT
    assert '--players must be 1 name for practice' in err
    code, _, err = types('play nine_ball --players greedy random player', '')
    assert '--players must be 2 names for nine_ball' in err


@pytest.mark.parametrize('written', ['shot-01.html', 'shot-01.png'])
def test_ctrl_c_while_pages_are_written_leaves_the_list(tmp_path, written):
    pages = tmp_path / 'pages'
    command = (
        f'-m billiard_shot play practice --balls 15 --seed 3 --players greedy --pages {pages}'
    )
    with subprocess.Popen([sys.executable, *command.split()], stdout=subprocess.PIPE) as game:
        while not (pages / written).exists():
            assert game.poll() is None
            time.sleep(0.005)
        game.send_signal(signal.SIGINT)
    assert game.returncode == INTERRUPTED
    listed = (pages / 'index.html').read_text()
    there = sorted(page.name for page in pages.glob('shot-*.html'))
    assert re.findall(r'<a href="(.*?)">', listed) == there


def test_you_are_you(types):
    command = 'play eight_ball --scene seven_foot --players person random --seed 5'
    code, out, _ = types(command, '-0.6 0.1\n\naim 1 4.5\n\n')
    assert code == INTERRUPTED
    assert 'you break\n' in out
    assert ': you (aim 1 4.5): ' in out
    assert not re.search('person|player [01]', out)


def test_two_persons_are_told_who_is_next(types):
    command = 'play nine_ball --scene seven_foot --players person person --seed 5'
    _, out, _ = types(command, '-0.6 0.1\n\naim 1 0.3\n\n')
    assert out.startswith('player 0 is next\n')
    assert ': player 0 (aim 1 0.3): foul ' in out
    assert '\nplayer 1 is next\n' in out


@pytest.mark.parametrize(
    ('game', 'fields', 'words'),
    [
        ('eight_ball', {'phase': 'break'}, 'you break'),
        ('eight_ball', {}, 'you play any ball but the 8'),
        ('eight_ball', {'groups': ('stripes', 'solids')}, 'you play the stripes: 9, 10, 11, 12, '),
        ('nine_ball', {}, 'you play the 1'),
        ('straight_pool', {'scores': (3, 5)}, 'you play any ball; 3 : 5 of 150 points'),
    ],
)
def test_balls_are_named_in_the_words_of_the_game(game, fields, words, monkeypatch, capsys):
    state = start(game, TABLE, seed=5).with_cue_ball(-0.6, 0.1)
    state = replace(state, **{'phase': 'play', 'in_hand': ''} | fields)
    monkeypatch.setattr('sys.stdin', io.StringIO(''))
    with pytest.raises(KeyboardInterrupt):
        Person(TABLE, 0).decide(state)
    assert f'\n{words}' in capsys.readouterr().out


def test_the_eight_comes_after_the_group(monkeypatch, capsys):
    state = start('eight_ball', TABLE).with_cue_ball(-0.6, 0.1)
    left = {ball: state.balls[ball] for ball in ('cue', '8', '9', '10')}
    state = replace(state, balls=left, phase='play', in_hand='', groups=('solids', 'stripes'))
    monkeypatch.setattr('sys.stdin', io.StringIO(''))
    with pytest.raises(KeyboardInterrupt):
        Person(TABLE, 0).decide(state)
    assert '\nyou play the 8\n' in capsys.readouterr().out


def test_choices_are_explained(monkeypatch, capsys):
    state = replace(start('nine_ball', TABLE), choices=('accept', 'pass'), in_hand='')
    monkeypatch.setattr('sys.stdin', io.StringIO('?\nresign\npass\n'))
    assert Person(TABLE, 0).decide(state).choice == 'pass'
    out = capsys.readouterr().out
    assert out.count('pass       let the other player shoot') == 2  # at first, and after ?
    assert "choice must be one of accept, pass, got 'resign'" in out


def test_a_table_without_pockets_is_played(types):
    command = 'play three_cushion --scene carom --players person random --seed 2'
    _, out, _ = types(command, 'aim red 2\n\n')
    assert 'R red' in out
    assert ': you (aim red 2): no point\n' in out
    assert 'pocket' not in out
    assert 'side_left' not in out


def test_each_shot_is_shown_in_the_browser_if_that_is_wished(types, monkeypatch, tmp_path):
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    shown = []
    monkeypatch.setattr('webbrowser.open', shown.append)
    types(f'{PRACTICE} --browser', PLACED + '0\n\n')
    assert len(shown) == 1
    assert shown[0].endswith('shot.html')
    types(PRACTICE, PLACED + '0\n\n')
    assert len(shown) == 1


def test_ctrl_c_ends_the_game_and_keeps_it(tmp_path):
    command = [sys.executable, '-m', 'billiard_shot', *PRACTICE.split()]
    environment = os.environ | {'TMPDIR': str(tmp_path)}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, env=environment) as game:
        game.stdin.write(f'{PLACED}0\n\n'.encode())
        game.stdin.flush()
        seen = b''
        while seen.count(b'your shot, or ? for help: ') < 2:
            seen += os.read(game.stdout.fileno(), 4096)
        game.send_signal(signal.SIGINT)
        _, err = game.communicate()
    assert game.returncode == INTERRUPTED
    assert len(RackRecord.load(Path(re.search('--state (.*)', err.decode())[1])).shots) == 1


def test_a_game_of_your_own_is_found_in_the_current_folder(tmp_path):
    """By the command as it is installed, whose path has not the current folder; not by nodes."""
    (tmp_path / 'my_games').mkdir()
    (tmp_path / 'my_games' / 'three_ball.py').write_text(
        'from dataclasses import replace\n'
        'from billiard_shot.game import find_game\n'
        "practice = find_game('practice')\n"
        "GAME = replace(practice, name='my_games.three_ball', balls=('1', '2', '3'))\n"
    )
    script = """
from billiard_shot.cli import main
from billiard_shot.game import find_game
try:
    find_game('my_games.three_ball')  # as a node does
except ValueError as error:
    print(error)
words = ['my_games.three_ball', '--players', 'random']
print(main(['play', *words]), main(['tournament', *words, '--racks', '1', '--workers', '1']))
"""
    command = [sys.executable, '-P', '-c', script]
    out = subprocess.run(command, cwd=tmp_path, check=True, stdout=subprocess.PIPE).stdout.decode()
    assert out.startswith("game: 'my_games.three_ball' is not a module with GAME: No module named")
    assert out.endswith('\n0 0\n')


def test_a_stray_byte_is_a_wrong_line(tmp_path):
    """It ended the game, and nothing was saved."""
    command = [sys.executable, '-m', 'billiard_shot', 'play', 'practice', '--balls', '1']
    done = subprocess.run(
        [*command, '--players', 'person'],
        input=b'\xe9\n',
        capture_output=True,
        cwd=tmp_path,
        check=False,
        env={**os.environ, 'PYTHONIOENCODING': 'utf-8'},
    )
    assert done.returncode == INTERRUPTED
    assert b'decode' not in done.stderr
    assert b'Traceback' not in done.stderr


def test_files_and_streams_are_checked_before_the_game(tmp_path, capsys, monkeypatch):
    file = tmp_path / 'file'
    file.write_text('')
    words = ['play', 'practice', '--players', 'random']
    assert main([*words, '--pages', str(file)]) == WRONG_INPUT
    assert f'--pages must be a folder, got the file {file}' in capsys.readouterr().err
    assert main([*words, '--state', '/dev/null']) == WRONG_INPUT
    assert '--state must be a file, got /dev/null' in capsys.readouterr().err
    monkeypatch.setattr('sys.stdin', None)
    assert main(['play', 'practice', '--players', 'person']) == WRONG_INPUT
    assert 'needs the standard input, which is closed' in capsys.readouterr().err


LOST = '-0.6 0.1\n\naim 1 4.5\n\n0 0.1\n\naim 1 0.3\n\n'  # a break, the cue ball placed, a foul


def test_ten_racks_against_the_ghost_are_kept_over_days(types, tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_DATA_HOME', str(tmp_path))
    command = 'play ghost --scene seven_foot --noise none'
    code, out, _ = types(command, f'{LOST}-0.6 0.1\n\naim 1 4.5\n\n')
    assert code == INTERRUPTED
    assert re.search(r'\nracks 1 to 1: 0 run out, \d of 10 balls\n.*professional from 71', out)
    folder = tmp_path / 'billiard_shot' / 'seven_foot-none-1'
    one, two = (RackRecord.load(folder / f'rack-000{number}.json') for number in (1, 2))
    assert (one.state['over'], two.state['over'], len(two.shots)) == (True, False, 1)
    assert one.shots[0].state['balls'] != two.shots[0].state['balls']
    listed = (folder / 'rack-0001' / 'index.html').read_text()
    assert 'person (aim 1 0.3)' in listed
    better = re.search(r'better: \d+ to \w+: wins in [^)]*', listed)[0]
    assert re.search(rf'{re.escape(better)} \(.*falls', out)  # without errors it does
    code, out, err = types(command, '0 0.1\n\nquit\n')  # the next day
    assert (code, err) == (DONE, '')
    assert out.startswith('racks 1 to 1: 0 run out')
    assert 'cue ball in hand, anywhere' in out


def test_the_eleventh_rack_begins_the_next_ten(types, tmp_path):
    record = play(Pairing('ten_ball_ghost', TABLE, ('random',)), 0)
    for number in range(1, 10):
        record.save(tmp_path / f'rack-{number:04d}.json')
    command = f'play ghost --scene seven_foot --players random --pages {tmp_path}'
    code, out, err = types(command, '')
    assert (code, err) == (DONE, '')
    assert out.splitlines()[-2].startswith('racks 1 to 10: 0 run out')
    assert (tmp_path / 'rack-0010' / 'shot-02.html').exists()


# --- what people type: it is read, or a sentence says what is wrong ------------------------------

BALLS = {'cue': (-0.3, 0.0), '1': (0.3, 0.1), '9': (0.6, -0.3), '8': (0.0, 0.4)}
SCENE = replace(Scene.load('pool_table'), balls=BALLS)
STATE = replace(start('practice', SCENE), in_hand='', balls=BALLS)
SECOND = replace(STATE, game='nine_ball', phase='second')
LISTED = listed_shots(SCENE, STATE)
CHOICES = replace(STATE, game='nine_ball', choices=('accept', 'pass'))


def shot(line, scene=SCENE, state=STATE):
    return read_shot(line, scene, state, LISTED)


def test_a_shot_of_the_list():
    chances = [each.chance for each in LISTED]
    assert chances == sorted(chances, reverse=True)
    chosen = LISTED[1]
    found = shot('1')
    assert shot('1e0').stroke == found.stroke
    assert found.call == chosen.call
    assert found.stroke.offsets[3:] == pytest.approx((chosen.azimuth, chosen.speed), abs=1e-9)
    assert found.reason == f'{chosen.call.ball} to {chosen.call.pocket}'
    found = shot('safe 1 2.5 0.3')
    assert found.call == replace(chosen.call, safety=True)
    assert found.stroke.offsets[1] == pytest.approx(0.3)
    assert found.stroke.speed == pytest.approx(2.5)


def test_a_ball_and_a_pocket_are_the_shot_of_the_list():
    ball, pocket = LISTED[1].call.ball, LISTED[1].call.pocket
    assert shot(f'aim {ball} {pocket}') == shot('1')
    assert shot(f'aim {ball} {pocket} 3 -0.2 0.1') == shot('1 3 -0.2 0.1')


def test_a_ball_is_aimed_at_whose_shot_is_not_in_the_list():
    """The line is that of the geometry then: without throw."""
    aimed = read_shot('aim 9 foot_right 3', SCENE, STATE, [])
    assert aimed.call == Call('9', 'foot_right')
    expected = aim(SCENE, '9', speed=3.0, pocket='foot_right')
    assert aimed.stroke.offsets[3] == pytest.approx(expected.offsets[3], abs=1e-9)
    full = shot('aim 9 3')
    assert full.call == Call()
    assert full.stroke.offsets[3] == pytest.approx(math.atan2(-0.3, 0.9), abs=1e-9)


def test_side_spin_does_not_turn_the_path_of_the_cue_ball():
    without, with_spin = (predict(SCENE, shot(f'aim 9 3 0 {a}').stroke) for a in (0, 0.4))
    heading = [math.atan2(each.velocity[1], each.velocity[0]) for each in (without, with_spin)]
    assert heading[0] == pytest.approx(heading[1], abs=1e-6)
    assert with_spin.stroke.offsets[3] != pytest.approx(without.stroke.offsets[3], abs=1e-3)


def test_any_stroke_with_a_call():
    found = shot('push 0 0.1 5 90 2 1 foot_left', state=SECOND)
    assert found.call == Call('1', 'foot_left', push_out=True)
    offsets = 0.0, 0.1, math.radians(5.0), math.radians(90.0), 2.0
    assert found.stroke.offsets == pytest.approx(offsets)
    assert shot('0 0 5 90 2').call == Call()


@pytest.mark.parametrize('x', [0.0, -1.2])
def test_the_cue_is_as_low_as_errors_allow(x):
    """Far from cushions and next to one, the noise makes no stroke unplayable."""
    scene = replace(SCENE, balls={'cue': (x, 0.0), '1': (0.3, 0.1)})
    state = replace(STATE, balls=scene.balls)
    free = shot('0 0 - 0 2', scene, state).stroke
    with pytest.raises(ValueError, match=r'ELEVATION must be at least .*, got 0') as caught:
        shot('0 0 0 0 2', scene, state)
    least = re.search('least ([0-9.]+), to leave room', str(caught.value))[1]
    stated = shot(f'0 0 {least} 0 2', scene, state).stroke
    degrees = [math.degrees(each.offsets[2]) for each in (free, stated)]
    assert degrees[1] == pytest.approx(float(least))
    assert degrees[1] - 0.2 < degrees[0] <= degrees[1]
    played = SCENE.noise.sample([free.offsets, stated.offsets], 300, np.random.default_rng(1))
    assert not refusals_in(scene, *vectors_of(played.reshape(-1, 5))).any()
    assert shot('aim 1 2 0 0 30', scene, state).stroke.offsets[2] == pytest.approx(np.pi / 6)


def test_a_cue_without_room_is_refused():
    ring = {str(i): (0.06 * math.cos(i), 0.06 * math.sin(i)) for i in range(1, 7)}
    low = replace(SCENE.robot, elevation_max_deg=20.0)
    scene = replace(SCENE, balls={'cue': (0.0, 0.0), **ring}, robot=low)
    with pytest.raises(ValueError, match='no room there at any elevation up to 20 degrees'):
        shot('0 0 - 30 2', scene, replace(STATE, balls=scene.balls))


def test_a_place_and_a_choice():
    in_hand = replace(STATE, in_hand='anywhere').without('cue')
    assert read_place(' -0.8 0.1 ', in_hand) == (-0.8, 0.1)
    with pytest.raises(ValueError, match=r'the cue ball must be at least .* got \(0\.3, 0\.1\)'):
        read_place('0.3 0.1', in_hand)
    assert read_choice(' pass ', CHOICES).choice == 'pass'
    with pytest.raises(ValueError, match="choice must be one of accept, pass, got 'abc'"):
        read_choice('abc', CHOICES)


def test_an_outcome():
    assert read_outcome('met 3, cushion 3 cue, 3 foot_left, double') == ShotReport(
        '3', ('3', 'cue'), {'3': 'foot_left'}, True
    )
    assert read_outcome('met none') == ShotReport()


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        ('', 'an empty line is not a shot; type \\? for help'),
        ('abc', "'abc' is not a shot"),
        ('99', 'N must be 0 to .* in the list, got .99'),
        ('1.5', 'N must be 0 to'),
        ('-1', 'N must be 0 to'),
        ('nan', 'N must be 0 to'),
        ('corner', "'corner' is not a shot"),
        ('0 fast', "SPEED must be a number, got 'fast'"),
        ('0 0', 'speed must be'),
        ('0 9', r'SPEED must be 0\.1 to 4\.5, got 9'),
        ('0 2 0.4 0.4', r'distance from the middle must be 0 to 0\.5, got 0\.56'),
        ('0 0 89 90 2', r'ELEVATION must be 0 to 85, got 89'),
        ('0 0 95 90 2', 'elevation_deg must be 0 to 90, got 95'),
        ('safe', "'safe' is not a shot"),
        ('push 0', 'push is allowed only in the first shot after a break'),
        ('0 0 5 90 2 1 corner', "pocket must be one of .*, side_right, '', got 'corner'"),
        ('0 0 5 90 2 99 foot_left', "BALL must be one of 1, 9, 8, got '99'"),
        ('0 0 5 90 2 1', 'is not a shot'),
        ('aim', "'aim' is not a shot"),
        ('aim 99 3', "BALL must be one of 1, 9, 8, got '99'"),
        ('aim 1', 'must be 1 to 4 numbers'),
        ('aim 1 2 0 0 0 0', 'must be 1 to 4 numbers'),
        ('aim 1 foot_lift 3', 'pocket must be .*; the nearest is foot_left'),
        ('aim 1 head_left 3', "pocket must be one that ball '1' reaches"),
        ('aim 1 3 up', "SPEED B must be 2 numbers, got '3 up'"),
    ],
)
def test_a_line_that_is_not_a_shot(line, words):
    with pytest.raises(ValueError, match=words):
        shot(line)


def test_the_list_may_be_empty():
    carom = start('three_cushion', 'carom')
    scene = replace(Scene.load('carom'), balls=carom.balls)
    assert listed_shots(scene, carom) == []
    with pytest.raises(ValueError, match='N must be a shot in the list'):
        read_shot('0', scene, carom, [])
    assert read_shot('aim red 3', scene, carom, []).stroke.speed == pytest.approx(3.0)


def test_enter_confirms():
    assert [read_confirmation(line) for line in ('', ' ', 'u')] == [True, True, False]
    with pytest.raises(ValueError, match="'yes' is neither Enter nor u"):
        read_confirmation('yes')


@pytest.mark.parametrize(
    'line', ['', '?', 'abc', '99', 'corner', 'met', 'cushion', 'met 1,,', ',']
)
def test_a_line_that_is_not_an_outcome(line):
    with pytest.raises(ValueError, match='type \\? for help'):
        read_outcome(line)


@given(strategies.text(max_size=30))
@example('1e999 0 0 0 0')
@example('nan nan')
@example('aim 1 1e999')
@example('0 0 - 1e999 2')
@example('9' * 5000)
def test_any_line_is_read_or_is_a_value_error(line):
    for read in (
        read_outcome,
        shot,
        read_confirmation,
        lambda line: read_place(line, STATE),
        lambda line: read_choice(line, CHOICES),
    ):
        with suppress(ValueError):
            read(line)
