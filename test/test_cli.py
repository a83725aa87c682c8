from argparse import Namespace, SUPPRESS
from contextlib import contextmanager
import csv
from enum import EnumMeta
from functools import partial
import io
import json
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
from threading import Timer

import numpy as np
from programs import ran
import pytest

import billiard_shot
from billiard_shot import effects_of, lowest_elevation, plan, predict, predict_batch, Scene, Stroke
from billiard_shot.cli import COMMANDS, main, make_parser, STUDIES
from billiard_shot.cli.output import Column, DONE, EXIT_CODES, FAILED, INTERRUPTED, print_rows
from billiard_shot.game.rack import play
from billiard_shot.planning.targets import Pot
from billiard_shot.scene.player import OFFSETS

PAPER = Path(__file__).parents[1] / 'config' / 'strokes' / 'paper.yaml'


def test_json_is_what_predict_gives(capsys):
    assert main(['predict', '--scene', 'paper', '--strokes', str(PAPER), '--json']) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line['stroke'] for line in lines] == ['vertical', 'horizontal', 'jump', 'massé']
    shot = predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16)))
    assert lines[3]['velocity'] == shot.velocity.tolist()
    assert lines[3]['spin'] == shot.spin.tolist()
    assert lines[3]['rest'] == shot.trajectory.final_position.tolist()
    assert lines[3]['status'] == shot.status.name
    assert lines[3]['miscue'] == shot.miscue
    assert np.shape(lines[3]['dissipated']) == (2, 2)


def test_table(capsys):
    assert main(['predict', '--a', '0.2', '--elevation-deg', '10', '--speed', '1.5']) == 0
    said, stroke, *facts = capsys.readouterr().out.splitlines()
    assert said.startswith('OK: at rest after ')
    assert 'a +0.20, b +0.00 radii; elevation 10.0°' in stroke
    assert facts[-1].startswith('  numerical error at most')


def test_the_cue_is_raised_as_far_as_it_needs_unless_the_elevation_is_stated(capsys):
    assert main(['predict', 'pool_table', '--speed', '2', '--json']) == DONE
    out, err = capsys.readouterr()
    lowest = lowest_elevation('pool_table', [(0.0, 0.0, 0.0, 0.0, 2.0)])[0]
    assert json.loads(out)['elevation'] == pytest.approx(lowest)
    assert err.startswith(f'elevation {np.degrees(lowest):.4g}°: the lowest at which the cue has')
    assert main(['predict', 'pool_table', '--speed', '2', '--elevation-deg', '0']) == FAILED
    assert capsys.readouterr().err.startswith('CUE_THROUGH_CUSHION')
    assert main(['predict', 'pool', '--speed', '2']) == DONE  # an endless cloth
    assert capsys.readouterr().err == ''


def test_vectors_on_the_command_line(capsys):
    arguments = ['predict', '--scene', 'paper', '--normal', '-1', '-2', '1']
    assert main([*arguments, '--velocity', '0', '0', '-2', '--csv']) == 0
    (row,) = csv.DictReader(io.StringIO(capsys.readouterr().out))
    velocity = [float(row[f'velocity_{axis}']) for axis in 'xyz']
    assert velocity == pytest.approx([0.4291, 0.8582, 0.2831], abs=5e-5)


def test_a_miscue_is_said_in_every_format(capsys):
    arguments = ['predict', '--a', '0.8', '--elevation-deg', '1', '--speed', '2']
    assert main([*arguments, '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said['status'], said['miscue']) == ('OK', True)
    assert main([*arguments, '--csv']) == 0
    (row,) = csv.DictReader(io.StringIO(capsys.readouterr().out))
    assert (row['status'], row['miscue']) == ('OK', 'True')
    assert main(arguments) == 0
    assert capsys.readouterr().out.startswith('OK: a miscue: the tip slid on the ball')


def test_refused_strokes_are_said_on_stderr(capsys):
    assert main(['predict', '--a', '0.9', '--b', '0.9', '--speed', '1', '--json']) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)['status'] == 'MISS'
    assert main(['predict', '--a', '0.9', '--b', '0.9', '--speed', '1']) == 1
    assert capsys.readouterr() == ('', err)  # in text, only there
    assert err.startswith(
        'MISS: a, b must have a² + b² below 1, got (0.9, 0.9)'
    )  # one stroke has no name


WRONG = [
    ('predict', 'stroke is missing'),
    ('predict --speed 1 --pocket foot_left', '--pocket needs --aim'),
    (
        'predict --speed -1',
        'speed must be above 0, got -1.0 (m/s); the cue of a player moves at 0.1',
    ),
    ('predict --speed 1 --tolerance 0', 'tolerance must be finite and above 0, got 0.0 (m)'),
    ('predict --speed 1 --scene papre', "got 'papre'; the nearest is paper"),
    (
        'predict masse.html --speed 1',
        "scene must be a bundled scene or a .yaml file, got 'masse.html'",
    ),
    ('predict none.yaml --speed 1', 'billiard-shot: none.yaml: No such file or directory\n'),
    ('predict --speed 1 --strokes x.yaml', '--strokes must not be given together'),
    ('predict --strokes x.yaml', 'No such file'),
    ('predict --normal -1 0 0 --a 1', 'must be those of one form'),
    ('predict -a 0.1', 'speed is missing; it must be above 0 (m/s); the cue of a player'),
    ('predict --normal -1 0 0', 'velocity is missing'),
    ('predict --speed 1 -t -1e-3', 'tolerance must be finite and above 0, got -0.001'),
    ('predict none.json', 'none.json: '),
    (
        'predict x.json --speed 1',
        'SCENE must be a scene together with a stroke, got the recorded shot x.json',
    ),
    ('predict x.json --scene pool', '--scene must not be given together with a recorded shot'),
    (
        'predict x.json --tolerance 1',
        '--tolerance must not be given together with a recorded shot',
    ),
    ('plan blocked --pot 9', "pot must be one of 1, 8, got '9'"),
    ('plan blocked --break 1 --pots 3', 'pots must be at most 2, the balls, got 3'),
    ('urdf --frame=', '--frame must be a name'),
    ('predict blocked --pot cue -s 2 -e 5', "--pot must be one of 1, 8, got 'cue'"),
    ('map pool_table --ball 8', 'ball must be in the scene, which has only the cue ball'),
    ('plan pool_table', 'target is missing; give one of --rest, --pass, --gate, --hit, --pot'),
    ('plan pool_table --pot 8', 'pot needs a ball; the scene has only the cue ball'),
    ('plan blocked --pot 8 --budget 0', 'budget must be a whole number, at least 1, got 0'),
    (
        'plan blocked --pot 8 --view no/a.html',
        '--view must be in a folder that exists, got no/a.html',
    ),
    ('plan blocked --pot 8 --speed-max -1', 'speed_max must be a finite number above 0, got -1'),
    (
        'plan blocked --pot 8 --noise-scale -1',
        '--noise-scale must be a finite number at least 0, got -1',
    ),
    ('study effects papre', 'scene must be one of '),
    ('study effects pool --scene paper', '--scene must not be given together with scene pool'),
    ('study effects pool --count 0', '--count must be a whole number, at least 1, got 0'),
    ('study effects pool --a 0.9 --b 0.9 --speed 1', 'none of them can be played'),
    (f'study effects {PAPER} --speed 1', '--strokes must not be given together with'),
    ('study accuracy papre', 'scene must be one of '),
    ('study accuracy --count 0', '--count must be a whole number, at least 1'),
]


@pytest.mark.parametrize(('words', 'text'), WRONG)
def test_wrong_input(words, text, capsys):
    assert main(words.split()) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('billiard-shot: ')
    assert text in err


@pytest.mark.parametrize('option', ['output', 'picture', 'history', 'close-up'])
def test_files_are_checked_before_the_work(option, capsys, monkeypatch):
    monkeypatch.setattr('billiard_shot.cli.predict.shots_of', None)
    for path, text in (
        ('no/a.x', 'must be in a folder that exists, got no/a.x'),
        ('.', 'must be a file'),
    ):
        assert main(['predict', '--speed', '1', f'--{option}', path]) == 2
        err = capsys.readouterr().err
        assert err.startswith(f'billiard-shot: --{option} must be ')
        assert text in err


@pytest.mark.parametrize(
    ('words', 'kinds'),
    [
        ('predict --speed 1 --picture a.xyz', '.png or .svg or .pdf or .jpg'),
        ('plan pool_table --pot 8 --view a.png', '.html'),
        ('view --speed 1 --output a.png', '.html'),
    ],
)
def test_a_file_of_another_kind_is_refused_before_the_work(words, kinds, capsys, tmp_path):
    assert main(words.replace('a.', f'{tmp_path}/a.').split()) == 2
    assert f'must be a file {kinds}, got {tmp_path}/a.' in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_video_is_not_also_a_page(capsys):
    assert main(['view', '--speed', '1', '--video', 'a.gif', '--output', 'a.html']) == 2
    assert '--output must not be given together with --video' in capsys.readouterr().err


def test_all_mistakes_of_a_file(tmp_path, capsys):
    path = tmp_path / 'strokes.yaml'
    path.write_text("""
- {name: good, a: 0.1, speed: 1}
- {name: typo, normal: [0, 0, 1], velocty: [0, 0, -1]}
- {name: zero, normal: [0, 0, 1], velocity: [0, 0, 0]}
- {name: pose, position: [-1, 0, 0.028575], quaternion: [0, 0, 0, 1], speed: 2}
- {name: angle, speed: 2, azimuth_deg: east}
- 7
""")
    assert main(['predict', '--strokes', str(path)]) == 2
    err = capsys.readouterr().err
    assert '4 wrong' in err
    assert 'stroke typo: velocty is unknown; the nearest key is velocity' in err
    assert 'stroke zero: velocity must be of length above 0, got [0, 0, 0] (m/s)' in err
    assert "stroke angle: azimuth_deg must be a finite number, got 'east'" in err
    assert 'stroke 6 must be a mapping, got 7' in err


def test_importing_the_package_is_light():
    heavy = 'numba', 'numpy', 'scipy', 'matplotlib', 'yaml'
    code = f'import sys, billiard_shot; print([m for m in {heavy} if m in sys.modules])'
    done = ran([sys.executable, '-c', code], check=True)
    assert done.stdout.strip() == '[]'


def test_public_names_exist():
    import billiard_shot

    assert all(getattr(billiard_shot, name) for name in billiard_shot.__all__)
    assert set(billiard_shot.__all__) <= set(dir(billiard_shot))
    with pytest.raises(AttributeError, match="no attribute 'predictt'"):
        _ = billiard_shot.predictt


def test_pictures_of_strokes(tmp_path, capsys):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    options = ['predict', '--scene', 'paper', '--strokes', str(PAPER)]
    assert main([*options, '--picture', str(tmp_path / 'paper.png')]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f'paper-{name}.png' for name in ('horizontal', 'jump', 'massé', 'vertical')
    ]
    assert main(['predict', '--speed', '1', '--picture', str(tmp_path / 'one.png')]) == 0
    assert (tmp_path / 'one.png').stat().st_size > 10_000
    capsys.readouterr()


def test_a_recorded_shot_is_shown_as_it_was(tmp_path, capsys):
    file = tmp_path / 'shot.json'
    stroke = ['predict', '--scene', 'nine_ball', '--elevation-deg', '5', '--speed', '4']
    assert main([*stroke, '--json', '--output', str(file)]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main(['predict', str(file), '--json']) == 0
    again = json.loads(capsys.readouterr().out)
    assert again == {**first, 'stroke': 'shot'}
    assert main(['predict', str(PAPER), '--scene', 'paper', '-o', str(file)]) == 0
    assert {path.name for path in tmp_path.iterdir()} > {'shot-jump.json', 'shot-massé.json'}
    capsys.readouterr()


def test_json_has_every_ball(capsys):
    stroke = ['-b', '0.1', '-e', '4.6', '-z', '-6', '-s', '8']
    assert main(['predict', 'nine_ball', *stroke, '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    shot = predict(
        'nine_ball', Stroke.from_offsets(b=0.1, elevation_deg=4.6, azimuth_deg=-6, speed=8)
    )
    assert said['balls'] == {
        name: None if name in shot.pocketed else list(place)
        for name, place in shot.final_position.items()
    }
    assert said['pocketed'] == shot.pocketed
    assert said['first_contact'] == '1'
    assert len(said['events']) == len(shot.events)
    assert main(['predict', 'nine_ball', *stroke]) == 0
    assert capsys.readouterr().out == f'{shot}\n'


def test_the_scene_is_in_the_same_place(capsys):
    """SCENE first, or in its former place."""
    stroke = ['--speed', '1', '-e', '5', '--json']
    for first in (
        ['pool_table', *stroke],
        [*stroke, 'pool_table'],
        ['--scene', 'pool_table', *stroke],
    ):
        assert main(['predict', *first]) == 0
    one, two, three = map(json.loads, capsys.readouterr().out.splitlines())
    for said in (one, two, three):
        del said['wall_time']
    assert one == two == three
    for command in ('predict', 'view', 'plan', 'map', *STUDIES):
        words = ['study', command] if command in STUDIES else [command]
        words += ['--ball', '8'] if command == 'map' else []
        assert main([*words, 'papre']) == 2
        assert 'scene must be one of blocked, ' in capsys.readouterr().err
    assert main(['plan', '--pot', '8']) == 2
    assert 'SCENE is missing; it must be a YAML file or one of ' in capsys.readouterr().err


@pytest.mark.parametrize('command', [['predict', str(PAPER), '--scene', 'paper', '--csv']])
def test_several_processes_give_the_same(command, capsys):
    assert main(command) == main([*command, '--workers', '2']) == 0
    lines = capsys.readouterr().out.splitlines()
    half = len(lines) // 2
    assert half > 1
    assert lines[:half] == lines[half:]
    assert main([*command, '--workers', '0']) == 2
    assert '--workers must be a whole number, at least 1, got 0' in capsys.readouterr().err


def run(*words, **options):
    command = [sys.executable, '-m', 'billiard_shot', *words]
    return subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False, **options)


def test_version(capsys):
    with pytest.raises(SystemExit) as ended:
        main(['--version'])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f'billiard_shot {billiard_shot.__version__}\n'


def test_a_speed_beyond_all_cues_is_warned_of(capsys):
    assert main(['predict', '--speed', '50', '-e', '5']) == 0
    assert 'no cue reaches 50 m/s' in capsys.readouterr().out


def test_usage_is_one_line_and_names_the_help(capsys):
    for words in (
        ['predict', '--speed', 'x'],
        ['study', 'effects', '--bad'],
        ['plan', '--pot'],
        ['x'],
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2
        message, hint = capsys.readouterr().err.splitlines()
        assert message.startswith('billiard-shot')
        assert hint.startswith('see billiard-shot')
        assert hint.endswith(' --help')
    with pytest.raises(SystemExit):
        main(['predict', '--help'])
    assert capsys.readouterr().out.startswith('usage: billiard-shot predict [SCENE] [options]\n')


@pytest.mark.parametrize('words', ['predict --pott', 'study effects --pott', 'scene list pott'])
def test_a_command_refuses_its_unknown_options_itself(words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    message, hint = capsys.readouterr().err.splitlines()
    command = ' '.join(words.split()[:-1])
    assert message.startswith(f'billiard-shot {command}: unrecognized arguments: ')
    assert hint == f'see billiard-shot {command} --help'


@pytest.mark.parametrize(
    ('words', 'text'),
    [
        ('pridict', 'argument COMMAND: must be one of predict, .*; the nearest is predict'),
        ('study effect', 'argument STUDY: must be one of accuracy, .*; the nearest is effects'),
        ('plan --pot 8 --pocket footleft', "any, foot_left, .*, got 'footleft'; .* is foot_left"),
        ('predict --aim 8 --pocket sideright', "got 'sideright'; the nearest is side_right"),
        ('plan --pot 8 --noise turnament', 'tournament, none, .*; the nearest is tournament'),
        ('predict -s 2,5', "argument -s/--speed: must be a number, such as 2.5, got '2,5'"),
        ('plan --pot 8 --budget 1e4', "argument --budget: must be a whole number, got '1e4'"),
    ],
)
def test_a_wrong_word_is_answered_with_what_is_allowed(words, text, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    assert re.search(text, capsys.readouterr().err)


def test_numbers_of_strokes_may_have_an_exponent(capsys):
    assert main(['predict', '-a', '-1e-1', '-z', '-2E+1', '-s', '2']) == 0
    assert 'a -0.10, b +0.00 radii; elevation 0.0°, azimuth -20.00°' in capsys.readouterr().out


def test_the_end_of_the_input_ends_a_game(capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', io.StringIO('?\n'))
    words = ['play', 'practice', '--balls', '1', '--players', 'person']
    assert main(words) == INTERRUPTED
    assert capsys.readouterr().err.endswith('billiard-shot: interrupted\n')


def test_every_option_has_a_help_but_one_of_former_times():
    """An option that a docstring leaves out would be hidden."""
    parsers, hidden = [make_parser()], set()
    while parsers:
        for action in parsers.pop()._actions:
            if isinstance(action.choices, dict):
                parsers += action.choices.values()
            elif action.help == SUPPRESS:
                hidden.add(action.option_strings[0])
    assert hidden == {'--scene'}


def test_every_command_is_in_the_help(capsys):
    text = make_parser().format_help()
    assert all(f'\n    {name}' in text for name in COMMANDS)
    with pytest.raises(SystemExit):
        main(['study', '--help'])
    studies = capsys.readouterr().out
    assert all(f'\n    {name}' in studies for name in STUDIES)
    assert all(f'{code}: ' in text for code in EXIT_CODES)


@pytest.mark.parametrize(
    ('content', 'words', 'text'),
    [
        (b'hello', 'tournament practice -o FILE', "line 1 must be the record of a rack, got 'he"),
        (b'{"a": 1}', 'tournament practice -o FILE', 'line 1 must be the record of a rack, got'),
        (b'# M\xfcller', 'predict FILE -s 1', 'must be a text in UTF-8, got byte 0xfc at'),
        (None, 'predict FILE.json', 'FILE.json: No such file or directory'),
    ],
)
def test_a_file_that_cannot_be_read_is_named_once(content, words, text, tmp_path, capsys):
    file = tmp_path / 'file.yaml'
    if content is not None:
        file.write_bytes(content)
    assert main(words.replace('FILE', str(file)).split()) == 2
    said = capsys.readouterr().err
    assert text.replace('FILE', str(file)) in said
    assert said.count(str(file)) == 1
    assert 'Errno' not in said


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='needs /dev/full')
def test_a_full_disk_is_an_error_without_traceback():
    with open('/dev/full', 'w') as full:
        done = run('predict', '--speed', '1', stdout=full)
    assert done.returncode == FAILED
    assert done.stderr.startswith('billiard-shot: ')
    assert 'Traceback' not in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize('unbuffered', ['', '1'])
def test_a_closed_pipe_loses_no_file(unbuffered, tmp_path, monkeypatch):
    monkeypatch.setenv('PYTHONUNBUFFERED', unbuffered)
    read, write = os.pipe()
    os.close(read)
    files = tmp_path / 'shot.json', tmp_path / 'shot.png'
    options = ('-o', str(files[0]), '--picture', str(files[1]))
    with os.fdopen(write, 'w') as closed:
        done = run('predict', '--speed', '1', *options, stdout=closed)
    assert (done.returncode, done.stderr) == (DONE, '')
    assert all(file.stat().st_size for file in files)


def test_a_terminal_without_degrees_loses_no_result(monkeypatch):
    monkeypatch.setenv('PYTHONIOENCODING', 'ascii')
    words = ('predict', 'frozen_combination', '--aim', '1', '--cut', '30', '--speed', '2')
    plain = run(*words, stdout=subprocess.PIPE)
    monkeypatch.setenv('PYTHONIOENCODING', 'utf-8')
    full = run(*words, stdout=subprocess.PIPE)
    assert (plain.returncode, plain.stderr) == (DONE, '')
    assert '°' in full.stdout
    assert plain.stdout == full.stdout.replace('°', r'\xb0')


@pytest.mark.parametrize('form', ['--json', '--csv'])
def test_a_prediction_holds_the_stroke_that_was_aimed(form, capsys):
    words = f'predict frozen_combination --aim 1 --cut 20 --speed 2 --b 0.1 {form}'
    assert main(words.split()) == DONE
    text = capsys.readouterr().out
    said = json.loads(text) if form == '--json' else next(csv.DictReader(text.splitlines()))
    stroke = Stroke.from_offsets(*(float(said[name]) for name in OFFSETS))
    shot = predict(Scene.load('frozen_combination'), stroke)
    assert shot.first_contact == '1'
    velocity = said['velocity'] if form == '--json' else [said[f'velocity_{x}'] for x in 'xyz']
    assert shot.velocity == pytest.approx([float(each) for each in velocity], abs=1e-6)


@pytest.mark.parametrize(
    'words',
    [
        'tournament practice --balls 1 --players random --racks 5000',
        'map pool_table --ball 8 --ball-at 0.5 0.2 --grid 100x100 --budget 300',
    ],
)
def test_ctrl_c_ends_without_traceback(words):
    code, err = interrupted(words.split())
    assert code == INTERRUPTED
    assert 'Traceback' not in err
    assert 'interrupted' in err.splitlines()[-1]


def test_ctrl_c_ends_a_search_with_its_best_stroke(tmp_path, capsys, monkeypatch):
    pressed = []

    @contextmanager
    def press_ctrl_c_after_a_while(label, total):
        def report(done):
            if done > 2000 and not pressed:
                pressed.append(done)
                os.kill(os.getpid(), signal.SIGINT)

        yield report

    monkeypatch.setattr('billiard_shot.cli.output.reporting', press_ctrl_c_after_a_while)
    page = tmp_path / 'plan.html'
    words = ['plan', 'wall', '--pot', '9', '--budget', '100000000', '--view', str(page)]
    assert main(words) == INTERRUPTED
    out, err = capsys.readouterr()
    assert err == ''
    assert out.startswith('CANCELLED: cancelled after ')
    assert 'strokes simulated' in out.splitlines()[-1]
    assert page.stat().st_size


def test_ctrl_c_ends_a_tournament_with_its_racks_so_far(capsys, monkeypatch):
    def stop_after_a_rack(pairing, *_):
        yield play(pairing, 0)
        raise KeyboardInterrupt

    monkeypatch.setattr('billiard_shot.cli.tournament.play_racks', stop_after_a_rack)
    words = 'tournament practice --balls 1 --players random --racks 5 --workers 1'.split()  # noqa: SIM905
    assert main(words) == INTERRUPTED
    out, err = capsys.readouterr()
    assert out.startswith('1 racks, ')
    assert err.endswith('interrupted: 1 of 5 racks are played\n')


HAS_BEGUN = re.compile(r'\] [1-9]')  # a bar, and the number of parts that are done


def interrupted(words):
    """
    Exit code and errors of a command that Ctrl+C interrupts when a part of its work is done.

    Until then it still imports modules, and imports of NumPy lose Ctrl+C.
    """
    command = [sys.executable, '-m', 'billiard_shot', *words]
    terminal, errors = os.openpty()
    # A shell lets the children of its background jobs ignore Ctrl+C; this one does not.
    heeds = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    streams = {'stdout': subprocess.DEVNULL, 'stderr': errors}
    with subprocess.Popen(command, **streams, preexec_fn=heeds) as process:
        os.close(errors)
        deadline = Timer(600.0, process.kill)
        deadline.start()
        written = ''
        try:
            while part := os.read(terminal, 4096):
                had_begun = HAS_BEGUN.search(written)
                written += part.decode()
                if HAS_BEGUN.search(written) and not had_begun:
                    process.send_signal(signal.SIGINT)
        except OSError:  # Linux ends the output of a terminal with an error
            pass
        deadline.cancel()
        os.close(terminal)
    return process.returncode, written


def test_no_comparison_can_lose_ctrl_c(monkeypatch):
    """See `billiard_shot.status`: NumPy must not look for methods of arrays in an enumeration."""
    asked = []

    def note(kind, name):
        asked.append((kind, name))
        raise AttributeError(name)

    monkeypatch.setattr(EnumMeta, '__getattr__', note, raising=False)
    scene = Scene.load('eight_ball')
    offsets = [[0.0, 0.1, 0.1, 0.3, 2.0]]
    lowest_elevation(scene, offsets)
    effects_of(predict(scene, Stroke.from_offsets(*offsets[0])))
    predict_batch(scene, offsets=offsets)
    plan('wall', Pot('9'), budget=2000)
    assert not asked


@pytest.mark.parametrize('shell', ['bash', 'zsh'])
def test_completion(shell, capsys):
    pytest.importorskip('shtab', reason='needs shtab, an extra')
    assert main(['completion', shell]) == 0
    script = capsys.readouterr().out
    assert all(name in script for name in COMMANDS)
    assert '--elevation-deg' in script
    if shell == 'bash':
        subprocess.run(['bash', '-n'], input=script, text=True, check=True)


def test_completion_names_what_is_missing(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'shtab', None)
    assert main(['completion', 'bash']) == 2
    assert 'billiard_shot[completion]' in capsys.readouterr().err


@pytest.mark.parametrize(
    'words',
    [
        ['scene', 'list'],
        ['scene', 'show', 'snooker'],
        ['predict', 'eight_ball', '-e', '5', '-s', '8', '-z', '-6'],
    ],
)
def test_text_has_80_columns(words, capsys):
    assert main(words) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


def test_the_elevation_of_a_stroke_is_at_most_90_degrees(capsys):
    assert main(['predict', '-e', '95', '-s', '1']) == 2
    assert 'elevation_deg must be 0 to 90, got 95.0' in capsys.readouterr().err
    assert main(['predict', '-e', '-5', '-s', '1']) == 1
    assert 'elevation must be 0 to 90, got -5 (degrees)' in capsys.readouterr().err


def test_columns_for_text_alone_are_not_in_csv(capsys):
    print_rows([Column('a'), Column('both', 'a b')], [{'a': 1}], Namespace(csv=True, json=False))
    assert capsys.readouterr().out == 'a\n1\n'


def test_an_output_that_the_shell_has_closed_is_no_error():
    command = f'"{sys.executable}" -m billiard_shot scene list >&-'
    done = subprocess.run(command, shell=True, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, '')
