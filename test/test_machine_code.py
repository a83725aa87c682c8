"""Answers before there is machine code, without numba, and whatever happens to the files."""

from ast import literal_eval
from contextlib import contextmanager
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
from time import monotonic, sleep

import pytest

from billiard_shot import machine_code

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.skipif(not machine_code.available(), reason='needs machine code')

PREDICT = """
import json, warnings
from billiard_shot import machine_code, predict, Scene, Stroke
stroke = Stroke.from_offsets(a=.2, b=-.1, elevation=.2, azimuth=.3, speed=2)
shots = [predict(Scene.load(name), stroke) for name in ('paper', 'pool_table')]
print(json.dumps([x for shot in shots
                  for x in (*shot.velocity, *shot.spin, *shot.trajectory.final_position)]))
print('machine code', machine_code.is_loaded())
"""


def run(program, cwd=ROOT, **environment):
    """Run a program in a fresh process; what it prints on stdout and stderr."""
    done = subprocess.run(
        [sys.executable, '-c', program],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines(), done.stderr


@pytest.fixture(scope='module')
def compiled():
    """Numbers that machine code gives."""
    (numbers, state), _ = run(
        'from billiard_shot import machine_code\nmachine_code.require()' + PREDICT
    )
    assert state == 'machine code True'
    return json.loads(numbers)


@pytest.fixture
def copied(tmp_path):
    """A copy of the machine code, in a cache of its own."""
    folder = tmp_path / 'billiard_shot' / machine_code.folder().name
    shutil.copytree(machine_code.folder(), folder)
    return folder


def test_a_short_program_interprets_and_compiles_nothing(compiled, tmp_path):
    (numbers, state), stderr = run(PREDICT, BILLIARD_SHOT_CACHE=str(tmp_path))
    assert json.loads(numbers) == compiled  # to the last bit
    assert state == 'machine code False'
    assert not stderr
    assert not [path for path in tmp_path.rglob('*') if path.is_file()]


def test_without_numba_everything_runs_and_one_warning_says_what_it_costs(compiled):
    program = (
        'import sys; sys.modules["numba"] = None'
        + PREDICT
        + 'from billiard_shot import predict_batch\n'
        'n, v = [[-1, 0, .1]] * 101, [[1, 0, -.1]] * 101\n'
        'out = predict_batch(Scene.load("paper"), n, v)\n'
        'print(set(out.status.tolist()))\n'
    )
    (numbers, state, statuses), stderr = run(program)
    assert json.loads(numbers) == pytest.approx(compiled, rel=1e-12, abs=1e-12)
    assert state == 'machine code False'
    assert statuses == '{0}'
    assert stderr.count('numba is not installed') == 1
    assert "pip install 'billiard_shot[fast]'" in stderr


def test_machine_code_on_disk_is_loaded_when_it_pays(copied):
    program = (
        'from billiard_shot import machine_code; machine_code.LOADING_PAYS = 0.0'
        + PREDICT
        + 'machine_code.require(); print(machine_code.is_loaded())\n'
        'predict(Scene.load("paper"), Stroke((-1, 0, .1), (1, 0, 0)))\n'
    )
    lines, stderr = run(program, BILLIARD_SHOT_CACHE=str(copied.parents[1]))
    assert lines[-1] == 'True'
    assert not stderr


def test_a_folder_that_cannot_be_written_is_named(compiled):
    (numbers, _), stderr = run(
        'from billiard_shot import machine_code; machine_code.folder()' + PREDICT,
        BILLIARD_SHOT_CACHE='/proc/nowhere',
    )
    assert json.loads(numbers) == compiled
    assert '/proc/nowhere/billiard_shot' in stderr
    assert 'Set BILLIARD_SHOT_CACHE to a folder that can be written' in stderr


def test_a_relative_folder_is_relative_to_the_process_that_asks(tmp_path):
    program = f"""
import os
from billiard_shot import machine_code
os.chdir({str(tmp_path)!r})
print(machine_code.folder().parents[1])
"""
    lines, stderr = run(program, BILLIARD_SHOT_CACHE='cache')
    assert (lines, stderr) == ([str(tmp_path / 'cache')], '')


def test_a_user_without_a_home_predicts(compiled):
    program = """
import pathlib
from billiard_shot import machine_code
def homeless(path):
    raise RuntimeError('Could not determine home directory.')
pathlib.Path.expanduser = homeless
machine_code.folder()
"""
    (numbers, _), stderr = run(program + PREDICT)
    assert json.loads(numbers) == compiled
    assert 'Could not determine home directory' in stderr


def test_damaged_machine_code_is_removed_and_the_process_interprets(copied, compiled):
    for path in copied.rglob('*.nbi'):
        path.write_bytes(path.read_bytes()[:40])
    program = 'from billiard_shot import machine_code\nprint(machine_code.require())' + PREDICT
    (loaded, numbers, _), stderr = run(program, BILLIARD_SHOT_CACHE=str(copied.parents[1]))
    assert loaded == 'False'
    assert json.loads(numbers) == compiled
    assert 'cannot be loaded' in stderr
    places = [copied / machine_code._place(name).name for name in machine_code.ENTRIES]
    assert not [place for place in places if place.exists()]


def warning_of(child, compiled, cache):
    """Let a function `child` compile, whose source is given; the warning. The answers stay."""
    program = (
        'from billiard_shot import machine_code\nimport shutil, subprocess\n'
        f'real = machine_code._child\n{child}'
        'machine_code._child = child\nprint(machine_code.require())' + PREDICT
    )
    (loaded, numbers, _), stderr = run(program, BILLIARD_SHOT_CACHE=str(cache))
    assert loaded == 'False'
    assert json.loads(numbers) == compiled
    assert 'could not be compiled' in stderr
    return stderr


def test_a_compiler_that_is_killed_leaves_a_warning_and_answers(compiled, tmp_path):
    child = 'child = lambda names, nice: subprocess.Popen(["sh", "-c", "kill -9 $$"])\n'
    assert 'its process was ended by signal 9' in warning_of(child, compiled, tmp_path)


def test_a_full_disk_is_a_warning(compiled, tmp_path):
    child = (
        'def child(names, nice):\n'
        '    place = machine_code._place(names[0])\n'
        '    place.mkdir()\n'
        '    (place / "log").write_text("OSError: No space left on device")\n'
        '    return subprocess.Popen(["false"])\n'
    )
    assert 'No space left on device' in warning_of(child, compiled, tmp_path)


def test_a_cache_that_vanishes_is_a_warning(compiled, tmp_path):
    child = (
        'def child(names, nice):\n'
        '    shutil.rmtree(machine_code.folder(), ignore_errors=True)\n'
        '    return real(names, nice)\n'
    )
    assert 'No such file or directory' in warning_of(child, compiled, tmp_path)


def waits_for_a_lock(pid):
    """Whether Linux lists a process among those that wait for a lock of a file."""
    lines = Path('/proc/locks').read_text().splitlines()
    return any('->' in line and f' {pid} ' in line for line in lines)


COMPILE = """
import os, sys
from pathlib import Path
from billiard_shot import machine_code
machine_code.compile_entry = lambda entry, place: print('compiles', flush=True) or input()
os.nice(int(sys.argv[2]))
machine_code.compile_one(machine_code.ENTRIES[-1], Path(sys.argv[1]))
"""


@contextmanager
def compiler(place, nice):
    """Start a process that compiles an entry, and whose compiler ends when it reads a line."""
    process = subprocess.Popen(
        [sys.executable, '-c', COMPILE, place, str(nice)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_until_locked(process):
    deadline = monotonic() + 60
    while not waits_for_a_lock(process.pid):
        assert process.poll() is None, 'it did not wait'
        assert monotonic() < deadline, 'it does not wait for a lock'
        sleep(0.05)


@pytest.mark.parametrize('nice', [1, 2])
def test_a_process_waits_for_a_compiler_of_its_priority_or_a_higher_one(tmp_path, nice):
    """It finds the work done."""
    pytest.importorskip('fcntl')
    with compiler(tmp_path, nice=1) as first:
        assert first.stdout.readline() == 'compiles\n'
        with compiler(tmp_path, nice) as second:
            wait_until_locked(second)
            first.stdin.write('\n')
            first.stdin.flush()
            assert second.wait(60) == 0
            assert second.stdout.read() == '', 'it compiled all the same'


def test_a_process_does_not_wait_for_a_compiler_of_lower_priority(tmp_path):
    """A second process of the higher priority waits for the first one of that priority."""
    pytest.importorskip('fcntl')
    with compiler(tmp_path, nice=2) as low:
        assert low.stdout.readline() == 'compiles\n'
        with compiler(tmp_path, nice=1) as high:
            assert high.stdout.readline() == 'compiles\n'
            with compiler(tmp_path, nice=1) as second:
                wait_until_locked(second)


def test_the_machine_code_that_was_used_last_is_kept(tmp_path):
    """Folders in which somebody still compiles stay, and so do those of other entries."""
    count = machine_code.KEPT + 3
    places = [tmp_path / f'module.entry.{i:016x}' for i in range(count)]
    other, unfinished = tmp_path / 'module.other.0', tmp_path / 'module.entry.compiles'
    for age, place in enumerate([*places, other]):
        place.mkdir()
        (place / 'done').touch()
        os.utime(place / 'done', (1e9 - age, 1e9 - age))
    unfinished.mkdir()
    machine_code.remove_old(places[0])
    kept = [place for place in places if place.exists()]
    assert kept == places[: machine_code.KEPT]
    assert other.exists()
    assert unfinished.exists()


def test_a_copy_of_the_sources_elsewhere_uses_the_same_machine_code(tmp_path, compiled):
    """Paths and times of files do not matter."""
    shutil.copytree(ROOT / 'billiard_shot', tmp_path / 'billiard_shot', copy_function=shutil.copy)
    shutil.copytree(ROOT / 'config', tmp_path / 'config')
    program = (
        'import billiard_shot; print(billiard_shot.__file__)\n'
        'from billiard_shot import compiled, machine_code\n'
        'machine_code._child = None  # nothing is compiled\n'
        'machine_code.require()' + PREDICT + 'entries = compiled.Entry.machine_code.values()\n'
        'print([sum(each.function.stats.cache_misses.values()) for each in entries])\n'
    )
    (file, numbers, state, misses), stderr = run(program, cwd=tmp_path)
    assert Path(file).is_relative_to(tmp_path)
    assert json.loads(numbers) == compiled
    assert state == 'machine code True'
    assert set(json.loads(misses)) == {0}
    assert not stderr


def test_a_change_of_a_layer_compiles_its_entries_and_those_of_later_layers(tmp_path):
    shutil.copytree(ROOT / 'billiard_shot', tmp_path / 'billiard_shot')
    with (tmp_path / 'billiard_shot' / 'table' / 'motion.py').open('a') as file:
        file.write('# a change')
    program = (
        'from billiard_shot import machine_code\n'
        'print([name for name in machine_code.ENTRIES if not machine_code._is_compiled(name)])\n'
    )
    (missing,), _ = run(program, cwd=tmp_path)
    layers = {name.split('.')[1] for name in literal_eval(missing)}
    assert layers == {'table', 'shot', 'planning'}


def test_command(capsys):
    from billiard_shot.cli import main

    assert main(['compile']) == 0
    assert str(machine_code.folder()) in capsys.readouterr().out
