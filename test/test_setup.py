"""The set-up names what is missing, and what installs it."""
import os
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[1]
SETUP = ROOT / 'config' / 'setup.sh'

pytestmark = pytest.mark.skipif(not SETUP.exists(), reason='needs a source checkout')


def packages(python, folder, **environment):
    done = subprocess.run(
        [SETUP, 'packages', python, folder / 'venv', 'pypi'],
        capture_output=True, text=True, env={**os.environ, **environment}, check=False)
    assert done.returncode == 1
    assert not (folder / 'venv').exists(), 'nothing is begun that cannot be finished'
    assert 'Traceback' not in done.stderr
    return done.stderr


@pytest.mark.parametrize(
    ('variable', 'words'), [('CC', 'a C compiler'), ('CXX', 'a C++ compiler')])
def test_missing_compiler(tmp_path, variable, words):
    said = packages(sys.executable, tmp_path, **{variable: 'no_such_compiler'})
    assert f'missing: {words}' in said
    assert 'install' in said


@pytest.mark.parametrize(('breaks', 'words'), [
    ('version_info < (3, 11)', 'Python >= 3.11'),
    ('ensurepip', 'venv module'),
    ('Python.h', 'Python.h'),
])
def test_missing_part_of_python(tmp_path, breaks, words):
    python = tmp_path / 'python'
    python.write_text(
        f'#!/bin/sh\ncase "$*" in *"{breaks}"*) exit 1;; esac\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    assert f'{words}' in packages(python, tmp_path)


def test_platform_without_wheels_gets_the_library_alone(tmp_path):
    python = tmp_path / 'python'
    python.write_text('#!/bin/sh\nexit 1\n')
    python.chmod(0o755)
    done = subprocess.run([SETUP, 'which', python], capture_output=True, text=True, check=True)
    assert done.stdout == 'none\n'
