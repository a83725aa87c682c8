"""The command `export`: what it writes runs, as pages of the documentation show it."""

from pathlib import Path
import re
import shutil
import sys

from node_js import needs_node, NODE
from programs import ran
import pytest

from billiard_shot import machine_code, predict, Stroke
from billiard_shot.cli import main
from billiard_shot.embed.scenes import core_folder

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
EXAMPLES = Path(__file__).resolve().parents[2] / 'docs' / 'examples'
COMPILER = ['cc'] if shutil.which('cc') else [sys.executable, '-m', 'ziglang', 'cc']


def run(*command, folder):
    """What a program prints."""
    done = ran(command, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ''
    return done.stdout


@needs_node
def test_the_program_in_javascript(tmp_path):
    assert main(['export', 'blocked', '-o', str(tmp_path / 'scene.json'), '--core']) == 0
    shutil.copy(EXAMPLES / 'shot.mjs', tmp_path)
    said = run(NODE, 'shot.mjs', folder=tmp_path)
    assert said.startswith('8 into foot_left: 0.')
    assert '\nOK foot_left [' in said


def test_the_program_in_c(tmp_path):
    assert main(['export', 'blocked', '-o', str(tmp_path / 'scene.h'), '--core']) == 0
    shutil.copy(EXAMPLES / 'shoot.c', tmp_path)
    (library,) = tmp_path.glob(f'{machine_code.LIBRARY}.*')
    strict = '-std=c11', '-Wall', '-Wextra', '-Wpedantic', '-Wno-unused-variable'
    run(*COMPILER, *strict, 'shoot.c', f'./{library.name}', '-o', 'shoot', folder=tmp_path)
    end, *balls = run('./shoot', folder=tmp_path).splitlines()
    stroke = Stroke.from_offsets(0.0, 0.1, 0.05, 0.05, 4.0)
    shot = predict('blocked', stroke, position=(-0.4, 0.05))
    assert end == f'status 0 after {shot.run.duration:.17g} s'
    places = {name: line.split()[2:4] for name, line in zip(shot.run.names, balls, strict=True)}
    for name, place in shot.run.final_position.items():
        assert [float(each) for each in places[name]] == place[:2].tolist()


def test_the_headers_are_also_c_plus_plus(tmp_path):
    assert main(['export', 'paper', '-o', str(tmp_path / 'scene.h'), '--core']) == 0
    (tmp_path / 'play.cpp').write_text("""
        #include "scene.h"
        int main() {
            play_tables(&play_tables_arguments);
            return play_tables_arguments.tables.ends->status == STATUS_INVALID_STROKE ? 0 : 1;
        }""")
    compiler = ['c++'] if shutil.which('c++') else [*COMPILER[:-1], 'c++']
    (library,) = tmp_path.glob(f'{machine_code.LIBRARY}.*')
    strict = '-std=c++20', '-Wall', '-Wextra', '-Wno-unused-variable'
    run(*compiler, *strict, 'play.cpp', f'./{library.name}', '-o', 'play', folder=tmp_path)
    run('./play', folder=tmp_path)


def test_a_header_of_another_version_is_refused(tmp_path):
    assert main(['export', 'paper', '-o', str(tmp_path / 'scene.h')]) == 0
    header = (core_folder(machine_code.LIBRARY) / 'billiard_shot.h').read_text()
    (tmp_path / 'billiard_shot.h').write_text(re.sub('SOURCES .*', 'SOURCES 0x1', header))
    done = ran([*COMPILER, '-fsyntax-only', 'scene.h'], cwd=tmp_path)
    assert done.returncode != 0
    assert 'export the scene with that version' in done.stderr


def test_other_files_are_refused(tmp_path, capsys):
    assert main(['export', 'paper', '-o', str(tmp_path / 'scene.yaml')]) == 2
    assert '--output must be a file .json or .h, got ' in capsys.readouterr().err


def test_a_core_that_cannot_be_built_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('billiard_shot.machine_code.PACKAGED', tmp_path)
    monkeypatch.setattr('billiard_shot.machine_code.built', lambda: tmp_path / 'built')
    monkeypatch.setattr('billiard_shot.compiler.build.find_spec', lambda name: None)
    assert main(['export', 'paper', '-o', str(tmp_path / 'scene.json'), '--core']) == 2
    said = 'billiard-shot: the core for wasm32 cannot be built: numba is not installed'
    assert capsys.readouterr().err.startswith(said)
