"""The library of machine code: the same answers as interpreted, whatever happens to its file."""

from contextlib import contextmanager
import hashlib
import json
import math
import os
from pathlib import Path
import shutil
import subprocess
import sys
from time import monotonic, sleep

import numpy as np
from programs import ran
import pytest

from billiard_shot import (
    machine_code,
    predict_batch,
    predict_within_noise,
    Scene,
    shots,
    Stroke,
    TableStates,
)
from billiard_shot.compiler import build
from billiard_shot.compiler.build import ENTRIES

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')

PREDICT = """
import json, warnings
from billiard_shot import machine_code, predict, Scene, Stroke
stroke = Stroke.from_offsets(a=.2, b=-.1, elevation=.2, azimuth=.3, speed=2)
shots = [predict(Scene.load(name), stroke) for name in ('paper', 'pool_table')]
print(json.dumps([x for shot in shots
                  for x in (*shot.velocity, *shot.spin, *shot.trajectory.final_position)]))
print(machine_code.is_loaded())
"""


def run(program, cwd=ROOT, **environment):
    """Run a program in a fresh process; what it prints on stdout and stderr."""
    done = ran([sys.executable, '-c', program], cwd=cwd, env=os.environ | environment, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines(), done.stderr


@pytest.fixture(scope='module')
def numbers():
    """Numbers that the library gives."""
    (numbers, loaded), stderr = run(PREDICT)
    assert (loaded, stderr) == ('True', '')
    return json.loads(numbers)


@pytest.fixture
def copied(tmp_path):
    """A copy of the library, in a cache of its own."""
    folder = tmp_path / 'billiard_shot' / machine_code.sources()
    shutil.copytree(library().parent, folder)
    return folder


def library():
    """The file of the library that the tests run."""
    return Path(machine_code.library().functions._name)


def interprets(numbers, cwd=ROOT, **environment):
    """What a process says that interprets, and whose answers are right."""
    (given, loaded), stderr = run(PREDICT, cwd, **environment)
    assert loaded == 'False'
    assert json.loads(given) == pytest.approx(numbers, rel=1e-10, abs=1e-10)
    return stderr


def test_without_a_library_everything_runs_and_one_sentence_says_what_to_do(numbers, tmp_path):
    stderr = interprets(numbers, BILLIARD_SHOT_CACHE=str(tmp_path))
    assert stderr.count('RuntimeWarning') == 1
    assert 'To build it: billiard-shot compile' in stderr
    assert not list(tmp_path.iterdir())


def test_a_process_that_is_told_to_interpret_says_nothing(numbers):
    assert not interprets(numbers, BILLIARD_SHOT_INTERPRET='1')


def test_nothing_imports_the_tools_where_it_runs():
    program = PREDICT + 'import sys; print({"numba", "llvmlite", "ziglang"} & set(sys.modules))\n'
    assert run(program)[0][-1] == 'set()'


def test_a_library_is_named_by_a_variable(copied, numbers):
    file = copied / library().name
    for name, folder in ((str(file), ROOT), (file.name, copied)):
        (given, loaded), stderr = run(PREDICT, folder, BILLIARD_SHOT_LIBRARY=name)
        assert (loaded, stderr) == ('True', '')
        assert json.loads(given) == numbers
    assert 'No such file' in interprets(numbers, BILLIARD_SHOT_LIBRARY=str(copied / 'none.so'))


def truncate(folder, file):
    file.write_bytes(file.read_bytes()[:100_000])


def change_a_byte(folder, file):
    content = bytearray(file.read_bytes())
    content[5000] ^= 1
    file.write_bytes(content)


def foreign(folder, file):
    """A file of another system, which the description names."""
    file.write_bytes(b'MZ' + bytes(1000))
    describe(folder, files={file.name: hashlib.sha256(file.read_bytes()).hexdigest()})


def old(folder, file):
    describe(folder, sources='0123456789abcdef')


def other_layout(folder, file):
    name, layout = 'billiard_shot.table.model.cue:CueRecord', {'size': 8, 'fields': []}
    describe(folder, records={name: layout})


def no_description(folder, file):
    (folder / machine_code.DESCRIPTION).write_text('[')


def describe(folder, **changes):
    file = folder / machine_code.DESCRIPTION
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        (truncate, 'is damaged'),
        (change_a_byte, 'is damaged'),
        (foreign, 'invalid ELF header'),
        (old, 'was built from other sources'),
        (other_layout, 'has another layout of CueRecord'),
        (no_description, 'Expecting value'),
    ],
)
def test_a_library_that_does_not_fit_is_refused_with_a_sentence(copied, numbers, change, reason):
    change(copied, copied / library().name)
    stderr = interprets(numbers, BILLIARD_SHOT_CACHE=str(copied.parents[1]))
    assert reason in stderr
    assert stderr.count('RuntimeWarning') == 1


@pytest.fixture
def package(tmp_path):
    """A copy of the sources elsewhere."""
    shutil.copytree(ROOT / 'billiard_shot', tmp_path / 'billiard_shot', copy_function=shutil.copy)
    shutil.copytree(ROOT / 'config', tmp_path / 'config')
    return tmp_path


def test_copies_of_sources_share_a_library_until_one_is_changed(package, numbers):
    """It belongs to the content of the sources: their paths and times do not matter."""
    (given, loaded), stderr = run(PREDICT, package)
    assert (json.loads(given), loaded, stderr) == (numbers, 'True', '')
    changed = package / 'billiard_shot' / 'table' / 'model' / 'motion.py'
    before = changed.read_bytes()
    changed.write_bytes(before + b'# a change\n')
    assert 'there is no library of machine code for these sources' in interprets(numbers, package)
    changed.write_bytes(before)
    assert run(PREDICT, package)[0][1] == 'True'


def test_a_user_without_a_home_predicts(numbers):
    program = """
import pathlib
def homeless(path):
    raise RuntimeError('Could not determine home directory.')
pathlib.Path.expanduser = homeless
"""
    (given, _), _ = run(program + PREDICT)
    assert json.loads(given) == pytest.approx(numbers, rel=1e-10, abs=1e-10)


def test_the_command_names_the_folder(capsys):
    from billiard_shot.cli import main

    for targets in ([], [machine_code.LIBRARY]):
        assert main(['compile', *targets]) == 0
        assert capsys.readouterr().out == f'compiled, in {machine_code.built()}\n'


@pytest.mark.parametrize(
    ('variables', 'reason'),
    [
        ({'BILLIARD_SHOT_CACHE': '/proc/nowhere'}, "No such file or directory: '/proc/nowhere"),
        ({'PIP_NO_INDEX': '1', 'PIP_CONFIG_FILE': os.devnull}, 'No matching distribution found'),
    ],
)
def test_the_command_says_why_nothing_is_compiled(
    monkeypatch, capsys, tmp_path, variables, reason
):
    """And leaves nothing of the environment of its own that it makes without tools."""
    from billiard_shot.cli import main

    monkeypatch.setenv('BILLIARD_SHOT_CACHE', str(tmp_path))
    monkeypatch.delenv('PIP_FIND_LINKS', raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(build, 'find_spec', lambda tool: None)
    assert main(['compile']) == 1
    assert reason in capsys.readouterr().err
    assert {file.name for file in tmp_path.rglob('*') if file.is_file()} <= {'lock'}


def test_a_python_without_venv_is_named(monkeypatch, tmp_path):
    """As on Ubuntu without python3-venv. What an interrupted build has left is removed."""
    monkeypatch.setattr(sys, 'executable', 'false')
    (tmp_path / 'tools' / 'lib').mkdir(parents=True)
    with pytest.raises(RuntimeError, match='python3-venv is needed'):
        build.environment(tmp_path / 'tools').__enter__()
    assert not list(tmp_path.iterdir())


def test_an_index_that_does_not_answer_ends_the_build(monkeypatch, tmp_path):
    monkeypatch.setattr(build, 'PATIENCE', 0.01)
    with pytest.raises(OSError, match='the package index does not answer'):
        build.fetch_library(sys.executable, tmp_path)


BUILD = """
import shutil, sys
from pathlib import Path
from billiard_shot.compiler import build
def slow(python, folder, targets):
    print('builds', flush=True)
    input()
    for file in set(Path(sys.argv[1]).iterdir()) - {Path(sys.argv[1], 'lock')}:
        shutil.copy(file, folder)
build._build_apart = slow
build.provide()
"""


@contextmanager
def builder(cache):
    """Start a process that builds, and whose compiler ends when it reads a line."""
    process = subprocess.Popen(
        [sys.executable, '-c', BUILD, library().parent],
        cwd=ROOT,
        env=os.environ | {'BILLIARD_SHOT_CACHE': str(cache)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def waits_for_a_lock(pid):
    """Whether Linux lists a process among those that wait for a lock of a file."""
    lines = Path('/proc/locks').read_text().splitlines()
    return any('->' in line and f' {pid} ' in line for line in lines)


def test_two_processes_build_once(tmp_path, numbers):
    pytest.importorskip('fcntl')
    with builder(tmp_path) as first:
        assert first.stdout.readline() == 'builds\n'
        interprets(numbers, BILLIARD_SHOT_CACHE=str(tmp_path))  # it does not wait
        with builder(tmp_path) as second:
            deadline = monotonic() + 60
            while not waits_for_a_lock(second.pid):
                assert second.poll() is None, 'it did not wait'
                assert monotonic() < deadline, 'it does not wait for a lock'
                sleep(0.05)
            first.stdin.write('\n')
            first.stdin.flush()
            assert second.wait(60) == 0
            assert second.stdout.read() == '', 'it built all the same'
    assert run(PREDICT, BILLIARD_SHOT_CACHE=str(tmp_path))[0][1] == 'True'


def test_a_damaged_library_is_built_again(copied):
    truncate(copied, copied / library().name)
    with builder(copied.parents[1]) as process:
        assert process.stdout.readline() == 'builds\n'


def test_the_libraries_that_were_used_last_are_kept(tmp_path):
    folders = [tmp_path / str(i) for i in range(build.KEPT + 3)]
    for age, folder in enumerate(folders):
        folder.mkdir()
        (folder / 'lock').touch()
        os.utime(folder, (1e9 - age, 1e9 - age))
    build.remove_old(tmp_path)
    assert [folder for folder in folders if folder.exists()] == folders[: build.KEPT]


def test_a_library_that_is_loaded_counts_as_used(copied):
    os.utime(copied, (0, 0))
    assert run(PREDICT, BILLIARD_SHOT_CACHE=str(copied.parents[1]))[0][1] == 'True'
    assert copied.stat().st_mtime > 0


def test_an_unknown_target_is_named(capsys, tmp_path, monkeypatch):
    from billiard_shot.cli import main
    from billiard_shot.cli.exports import TARGETS

    monkeypatch.setenv('BILLIARD_SHOT_CACHE', str(tmp_path))
    assert main(['compile', 'vax']) == 2
    assert f'TARGET must be one of {", ".join(TARGETS)}, got ' in capsys.readouterr().err
    targets = pytest.importorskip('billiard_shot.compiler.targets')
    assert set(TARGETS) == set(targets.TARGETS)


@pytest.mark.skipif(shutil.which('nm') is None, reason='needs nm')
def test_the_library_exports_the_entries_and_needs_nothing():
    names = [line.split() for line in output('nm', '-D', library())]
    assert {name[-1] for name in names} == {entry.partition(':')[2] for entry in ENTRIES}
    assert {name[-2] for name in names} == {'T'}


@pytest.mark.nightly
@pytest.mark.parametrize(
    ('target', 'begin'), [('darwin-arm64', b'\xcf\xfa\xed\xfe'), ('windows-amd64', b'MZ')]
)
def test_libraries_for_other_systems_have_the_entries(target, begin):
    made = next(build.provide(target).glob(f'{target}.*')).read_bytes()
    assert made.startswith(begin)
    assert all(f'{entry.partition(":")[2]}\0'.encode() in made for entry in ENTRIES)
    assert b'.idata' not in made, 'a library for Windows needs no other one'


def output(*command):
    done = ran(command, check=True)
    return done.stdout.splitlines()


def interpreted(function, monkeypatch):
    """What a function gives with the library, and interpreted."""
    compiled = function()
    with monkeypatch.context() as context:
        context.setattr(machine_code, 'is_loaded', lambda: False)
        return compiled, function()


def offsets(count, seed):
    draw = np.random.default_rng(seed)
    return draw.uniform([-0.5, -0.5, 0, -3, 0.1], [0.5, 0.5, 1, 3, 6], (count, 5))


@pytest.mark.slow
@pytest.mark.parametrize('name', ['paper', 'pool', 'pool_table', 'carom'])
def test_random_shots_are_those_of_interpreted_code(name, monkeypatch):
    scene, rows = Scene.load(name), offsets(60, 1)
    one, other = interpreted(lambda: predict_batch(scene, offsets=rows), monkeypatch)
    assert list(one.status) == list(other.status)
    for field in ('velocity', 'spin'):
        assert getattr(one, field) == pytest.approx(getattr(other, field), rel=1e-8, abs=1e-7)
    # A jaw of a pocket magnifies what rounding differs by.
    apart = np.abs(one.final_position - other.final_position).max(axis=(1, 2))
    assert np.quantile(apart, 0.95) < 1e-8
    assert apart.max() < 1e-4


def test_strikes_of_plans_are_those_of_interpreted_code(monkeypatch):
    """They come from maps. Rebounds differ: interpreted code solves all of them."""
    scene, draw = Scene.load('blocked'), np.random.default_rng(4)
    rows = draw.normal([0, 0.2, 0.1, 0.2, 2.0], [0.01, 0.01, 0, 0.002, 0.05], (40, 5))
    one, other = interpreted(lambda: predict_within_noise(scene, rows), monkeypatch)
    assert list(one.status) == list(other.status)
    for field in ('velocity', 'spin', 'cue_speed'):
        assert getattr(one, field) == pytest.approx(getattr(other, field), rel=1e-8, abs=1e-7)


def test_direct_shots_are_those_of_interpreted_code(monkeypatch):
    scene, draw = Scene.load('pool_table'), np.random.default_rng(5)
    low, high = np.array([-1.0, -0.5, 0.0]), np.array([1.0, 0.5, 0.0])
    low[2] = high[2] = scene.ball.radius
    places = draw.uniform(low, high, (10, 4, 3))
    tables = TableStates(('cue', '1', '2', '3'), places)
    one, other = interpreted(lambda: shots(scene, tables), monkeypatch)
    assert len(one) > 20
    assert list(one.ball) == list(other.ball)
    assert one.chance == pytest.approx(other.chance, rel=1e-9, abs=1e-12)


def test_refusals_and_rows_without_numbers_have_the_same_status(monkeypatch):
    scene, rows = Scene.load('eight_ball'), offsets(40, 2)
    rows[:, :2] *= 2
    rows[3, 4] = rows[5, 0] = math.nan
    rows[7, 4] = math.inf
    strokes = [Stroke.from_offsets(*row) for row in offsets(40, 2)]
    normals = np.array([each.normal for each in strokes])
    velocities = np.array([each.velocity for each in strokes])
    normals[::7], velocities[3], velocities[4] = -normals[::7], math.nan, 0.0
    velocities[6, 2] = 5.0
    one, other = interpreted(lambda: predict_batch(scene, normals, velocities), monkeypatch)
    assert list(one.status) == list(other.status)
    assert len(set(one.status.tolist())) >= 4
