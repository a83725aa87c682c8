"""The set-up installs locked versions, and names what is missing or failed."""

from importlib.metadata import requires
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from programs import ran
import pytest

ROOT = Path(__file__).resolve().parents[1]
SETUP = ROOT / 'config' / 'setup.sh'

pytestmark = pytest.mark.skipif(not SETUP.exists(), reason='needs a source checkout')
needs_make = pytest.mark.skipif(not shutil.which('make'), reason='make is not installed')


def core(python, folder, **environment):
    done = ran([SETUP, 'core', python, folder / 'venv', 'pypi'], env={**os.environ, **environment})
    assert done.returncode == 1
    assert not (folder / 'venv').exists(), 'nothing is begun that cannot be finished'
    assert 'Traceback' not in done.stderr
    return done.stderr


@pytest.mark.parametrize(
    ('variable', 'words'), [('CC', 'a C compiler'), ('CXX', 'a C++ compiler')]
)
def test_missing_compiler(tmp_path, variable, words):
    said = core(sys.executable, tmp_path, **{variable: 'no_such_compiler'})
    assert f'missing: {words}' in said
    assert 'install' in said


@pytest.mark.parametrize(
    ('breaks', 'words'),
    [
        ('version_info < (3, 11)', 'Python >= 3.11'),
        ('ensurepip', 'venv module'),
        ('Python.h', 'Python.h'),
    ],
)
def test_missing_part_of_python(tmp_path, breaks, words):
    python = tmp_path / 'python'
    python.write_text(
        f'#!/bin/sh\ncase "$*" in *"{breaks}"*) exit 1;; esac\nexec {sys.executable} "$@"\n'
    )
    python.chmod(0o755)
    assert f'{words}' in core(python, tmp_path)


def test_environment_that_is_a_link_is_left_alone(tmp_path):
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    (elsewhere / 'kept').touch()
    (tmp_path / 'venv').symlink_to(elsewhere)
    done = ran([SETUP, 'core', sys.executable, tmp_path / 'venv', 'pypi'])
    assert done.returncode == 1
    assert f'is a link to {elsewhere}' in done.stderr
    assert (elsewhere / 'kept').exists()


def test_platform_without_wheels_gets_the_library_alone(tmp_path):
    python = tmp_path / 'python'
    python.write_text('#!/bin/sh\nexit 1\n')
    python.chmod(0o755)
    done = ran([SETUP, 'which', python], check=True)
    assert done.stdout == 'none\n'


def requirements(file):
    lines = (line.partition('#')[0].strip() for line in file.read_text().splitlines())
    return [Requirement(line) for line in lines if line]


@pytest.mark.parametrize(
    ('distro', 'python'),
    [
        ('', '3.11'),
        ('', '3.12'),
        ('', '3.13'),
        ('', '3.14'),
        ('-jazzy', '3.11'),
        ('-jazzy', '3.12'),
    ],
)
def test_every_requirement_is_locked_to_one_version(distro, python):
    """If not: `make lock`, `make DISTRO=jazzy lock`."""
    environment = default_environment() | {
        'python_version': python,
        'python_full_version': f'{python}.7',
    }
    pins = {}
    for pin in requirements(ROOT / 'config' / f'constraints{distro}.txt'):
        if pin.marker is None or pin.marker.evaluate(environment):
            assert pin.name not in pins
            pins[canonicalize_name(pin.name)] = str(pin.specifier)
    assert all(pin.startswith('==') for pin in pins.values())
    wanted = [
        *map(Requirement, requires('billiard_shot')),
        *requirements(ROOT / 'config' / f'requirements-ros{distro}.txt'),
    ]
    assert len(wanted) > 40
    for each in wanted:
        if each.name == 'pooltool-billiards':  # needs an index of its own, for a pre-release
            continue
        assert each.specifier.contains(pins[canonicalize_name(each.name)].removeprefix('==')), each


@pytest.fixture
def checkout(tmp_path):
    """Return a folder with all that the set-up reads; and a `sleep` a hundred times as fast."""
    for name in ('config', 'msg_defs', 'Makefile', 'setup.py', 'README.md'):
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, tmp_path / name)
    (tmp_path / 'bin').mkdir()
    sleep = tmp_path / 'bin' / 'sleep'
    sleep.write_text(f'#!/bin/sh\nexec {shutil.which("sleep")} 0.$(printf %02d "$1")\n')
    sleep.chmod(0o755)
    return tmp_path


def set_up(checkout, *arguments, **environment):
    return subprocess.run(
        ['make', f'PYTHON={sys.executable}', *arguments, 'setup'],
        cwd=checkout,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        env={
            **os.environ,
            'PATH': f'{checkout / "bin"}:{os.environ["PATH"]}',
            'MAKEFLAGS': '',
            **environment,
        },
    )


@needs_make
def test_failed_download_is_tried_again_and_ends_with_cause_and_log(checkout):
    failed = set_up(checkout, PIP_NO_INDEX='1', PIP_FIND_LINKS='/nowhere')
    assert failed.returncode != 0
    assert failed.stdout.count('next try in') == 2
    log = checkout / 'log' / 'setup-core.log'
    lines = failed.stdout.splitlines()
    cause = lines[lines.index(f'set-up: the whole output is in {log}') - 1]
    assert cause.strip().startswith('ERROR: ')
    assert log.read_text().count(cause.strip()) == 3

    again = set_up(checkout, PIP_NO_INDEX='1', PIP_FIND_LINKS='/nowhere')
    assert 'Python packages into .venv' in again.stdout, 'half of a set-up was taken for complete'


@needs_make
def test_interrupted_set_up_starts_over(checkout):
    """Even one that was to replace a complete one, with other versions."""
    stamp = checkout / '.venv' / '.tools-pypi'
    stamp.parent.mkdir()
    stamp.touch()
    python = checkout / 'bin' / 'python'
    python.write_text(
        f'#!/bin/sh\ncase "$*" in *"-m venv"*) kill -KILL $PPID;; esac\n'
        f'exec {sys.executable} "$@"\n'
    )
    python.chmod(0o755)
    interrupted = set_up(checkout, f'PYTHON={python}', 'LOCK=')
    assert interrupted.returncode != 0
    assert not stamp.exists()


@needs_make
def test_a_step_that_takes_long_says_how_far_it_is(checkout):
    python = checkout / 'bin' / 'python'
    python.write_text(
        '#!/bin/sh\ncase "$*" in *"-m venv"*) echo first half; sleep 50; exit 3;; esac\n'
        f'exec {sys.executable} "$@"\n'
    )
    python.chmod(0o755)
    output = set_up(checkout, f'PYTHON={python}').stdout
    assert re.search(r'^set-up: core: \d+ s: first half$', output, re.MULTILINE)
