"""The package as its users get it: wheel, source archive, and a fresh environment."""
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tarfile
import xml.etree.ElementTree as ET
import zipfile

import pytest

from billiard_shot.scene.bundled import scene_names, scene_path

ROOT = Path(__file__).resolve().parents[1]
pytestmark = pytest.mark.skipif(
    not (ROOT / 'setup.py').exists(), reason='needs a source checkout')


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f'{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}'
    return done.stdout


@pytest.fixture(scope='module')
def checkout(tmp_path_factory):
    """Return a clean copy of the sources, so that a build leaves nothing in the real ones."""
    copy = tmp_path_factory.mktemp('checkout') / 'billiard_shot'
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(
        '.*', 'build', 'install', 'log', 'dist', '*.egg-info', '__pycache__'))
    return copy


@pytest.fixture(scope='module')
def wheel(checkout):
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '-w', 'dist', '.', cwd=checkout)
    return next((checkout / 'dist').glob('*.whl'))


def test_scenes_are_found():
    assert 'paper' in scene_names()
    assert scene_path('paper').is_file()
    with pytest.raises(ValueError, match='paper'):
        scene_path('no_such_scene')


def test_versions_agree():
    versions = {
        ET.parse(ROOT / folder / 'package.xml').findtext('version')
        for folder in ('.', 'msg_defs')}
    assert len(versions) == 1
    assert f"version='{versions.pop()}'" in (ROOT / 'setup.py').read_text()


def test_wheel_has_scenes_and_what_ros_looks_for(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for scene in scene_names():
        assert f'billiard_shot/scenes/{scene}.yaml' in names
    shared = [name.split('/data/')[1] for name in names if '/data/' in name]
    for name in ('ament_index/resource_index/packages/billiard_shot', 'billiard_shot/package.xml',
                 'billiard_shot/config/predictor.yaml',
                 'billiard_shot/config/cue_driver.yaml', 'billiard_shot/config/mechanism.yaml',
                 'billiard_shot/launch/shot.launch.py'):
        assert f'share/{name}' in shared
    assert not [name for name in names if name.startswith(('test', 'benchmarks'))]


def test_source_archive_has_scenes(checkout):
    run(sys.executable, 'setup.py', '-q', 'sdist', cwd=checkout)
    archive = next((checkout / 'dist').glob('*.tar.gz'))
    with tarfile.open(archive) as opened:
        names = opened.getnames()
    assert any(name.endswith('config/scenes/paper.yaml') for name in names)
    assert any(name.endswith('/LICENSE') for name in names)


@pytest.mark.slow
def test_pip_install_into_an_empty_environment(wheel, tmp_path):
    """Without ROS, without the sources: the command works and finds its scenes."""
    run(sys.executable, '-m', 'venv', tmp_path / 'venv')
    scripts = tmp_path / 'venv' / 'bin'
    clean = {name: value for name, value in os.environ.items()
             if name not in ('PYTHONPATH', 'LD_LIBRARY_PATH', 'VIRTUAL_ENV')}
    run(scripts / 'python', '-m', 'pip', 'install', '-q', wheel, env=clean)
    strokes = tmp_path / 'strokes.yaml'
    strokes.write_text('- {normal: [-1, -1, 0], velocity: [0.8, 0, 0]}\n')
    said = run(scripts / 'billiard-shot', 'predict', '--scene', 'paper', '--strokes', strokes,
               '--json', env=clean, cwd=tmp_path)
    assert json.loads(said)['velocity'][0] == pytest.approx(.6335672927, abs=1e-4)


def test_ros_tests_are_skipped_visibly_without_ros():
    program = ('import sys, pytest\n'
               'sys.modules.update(rclpy=None, billiard_shot_msgs=None)\n'
               "sys.exit(pytest.main(['-q', '-p', 'no:cacheprovider', 'test/ros']))")
    done = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode in (0, 5), done.stdout
    assert done.stdout.count('needs ROS 2') == len(list((ROOT / 'test/ros').glob('test_*.py')))
