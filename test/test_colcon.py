"""Both packages in a workspace of colcon's, as people who have a ROS 2 build and test them."""

import importlib.util
import os
from pathlib import Path
import re
import shutil
import sys

from node_process import starts_and_ends
from programs import ran
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
COLCON = shutil.which('colcon', path=f'{Path(sys.executable).parent}:{os.environ["PATH"]}')
ROOT = Path(__file__).resolve().parents[1]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group('colcon'),  # one workspace, by one worker
    pytest.mark.skipif(COLCON is None, reason='needs colcon'),
    pytest.mark.skipif(not (ROOT / 'package.xml').exists(), reason='needs a source checkout'),
]


@pytest.fixture(scope='module')
def environment():
    """Return an environment with the ROS 2 of this interpreter, and a ROS domain of its own."""
    from domain_coordinator import domain_id

    from billiard_shot.ros.robot import quiet_environment

    prefix = Path(sys.prefix)
    with domain_id() as domain:
        environment = quiet_environment(domain)
        environment['PATH'] = f'{prefix / "bin"}:{environment["PATH"]}'
        if (prefix / 'share' / 'rclpy').exists():  # from wheels: they come without a setup.bash
            environment['AMENT_PREFIX_PATH'] = str(prefix)
            environment['CMAKE_GENERATOR'] = 'Ninja'
        yield environment


@pytest.fixture(scope='module')
def workspace(tmp_path_factory, environment):
    """
    Return a workspace with a clean copy of the sources in it, built as docs/ros.md says.

    The messages are those of the virtual environment, which the set-up builds by the same file.
    """
    folder = make_workspace(tmp_path_factory.mktemp('workspace'))
    said = run(folder, environment, COLCON, 'build')
    assert '1 package finished' in said
    assert 'without machine code' not in said
    return folder


@pytest.mark.nightly
def test_a_workspace_has_its_own_messages(environment, tmp_path):
    """Not those of the virtual environment."""
    workspace = with_messages(tmp_path)
    options = '-DBUILD_TESTING=OFF', f'-DPython3_EXECUTABLE={sys.executable}'
    said = run(workspace, environment, COLCON, 'build', '--cmake-args', *options)
    assert '2 packages finished' in said
    program = 'import billiard_shot_msgs as m; print(m.__file__)'
    command = f'{sys.executable} -c "{program}"'
    said = run(workspace, sourced(environment), 'bash', '-c', command)
    assert said.startswith(str(workspace / 'install'))
    messages = workspace / 'install' / 'billiard_shot_msgs' / 'share' / 'billiard_shot_msgs'
    assert (messages / 'srv' / 'PredictShot.srv').is_file()


def make_workspace(folder):
    shutil.copytree(
        ROOT,
        folder / 'src' / 'billiard_shot',
        ignore=shutil.ignore_patterns(
            '.*', 'build', 'install', 'log', 'dist', '*.egg-info', '__pycache__'
        ),
    )
    return folder


def run(folder, environment, *command):
    done = ran(command, cwd=folder, env=environment)
    assert done.returncode == 0, f'{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}'
    return done.stdout + done.stderr


def sourced(environment, workspace='.'):
    """Return an environment in which bash sees what has been built in a workspace."""
    return environment | {'BASH_ENV': f'{workspace}/install/setup.bash'}


def with_messages(folder):
    """Make a workspace with both packages, as docs/ros.md says."""
    (make_workspace(folder) / 'src' / 'billiard_shot_msgs').symlink_to('billiard_shot/msg_defs')
    return folder


def test_rosdep_finds_both_packages(tmp_path):
    """As catkin_pkg, which rosdep asks, finds them below src."""
    catkin_pkg = pytest.importorskip('catkin_pkg.packages')
    found = catkin_pkg.find_packages(str(with_messages(tmp_path) / 'src'))
    assert {package.name for package in found.values()} == {'billiard_shot', 'billiard_shot_msgs'}


def test_the_workspace_has_machine_code(workspace, environment, tmp_path):
    """From the cache of the tests, which the build only reads, as it has the same sources."""
    assert loads_machine_code(workspace, environment, tmp_path)


def loads_machine_code(workspace, environment, cache):
    """Whether Python finds the library in the workspace, with a cache that has none."""
    program = 'from billiard_shot import machine_code; print(machine_code.is_loaded())'
    variables = sourced(environment) | {'BILLIARD_SHOT_CACHE': str(cache)}
    said = run(workspace, variables, 'bash', '-c', f"{sys.executable} -c '{program}'")
    return 'True' in said.split()


@pytest.fixture
def colcon_without_tools(environment, tmp_path, tmp_path_factory):
    """Return a function that runs colcon with a Python that has no numba, and an empty cache."""
    bare = tmp_path_factory.mktemp('bare')  # not in the workspace, where colcon looks for packages
    run(bare, environment, sys.executable, '-m', 'venv', '--without-pip', '.')
    site = Path('lib', f'python{sys.version_info.major}.{sys.version_info.minor}', 'site-packages')
    for module in (Path(sys.prefix) / site).iterdir():
        if not module.name.startswith(('numba', 'ziglang')) and module.suffix != '.pth':
            (bare / site / module.name).symlink_to(module)
    program = 'import sys; from colcon_core.command import main; sys.exit(main())'
    colcon = bare / 'bin' / 'python', '-c', program
    variables = environment | {'BILLIARD_SHOT_CACHE': str(tmp_path / 'cache')}
    return lambda *options, **more: run(tmp_path, variables | more, *colcon, *options)


def test_without_tools_and_index_the_build_says_what_adds_machine_code(
    colcon_without_tools, environment, tmp_path
):
    """Nothing is left of the environment that it makes; strokes are interpreted."""
    folder = make_workspace(tmp_path)
    offline = {'PIP_NO_INDEX': '1', 'PIP_FIND_LINKS': '', 'PIP_CONFIG_FILE': os.devnull}
    said = colcon_without_tools('build', '--symlink-install', **offline)
    assert '1 package finished' in said
    assert said.count('built without machine code') == 1
    assert 'ros2 run billiard_shot billiard-shot compile' in said
    assert not list(tmp_path.rglob('tools/pyvenv.cfg'))
    assert not loads_machine_code(folder, environment, tmp_path / 'cache')


@pytest.mark.nightly
def test_from_nothing_a_workspace_gets_machine_code_and_the_robot_plays(
    colcon_without_tools, environment, tmp_path
):
    """With an index, which has the tools; a second build makes nothing."""
    folder = make_workspace(tmp_path)
    for _ in range(2):
        said = colcon_without_tools('build')
        assert 'without machine code' not in said
        assert loads_machine_code(folder, environment, tmp_path / 'cache')
    assert not list(tmp_path.rglob('tools/pyvenv.cfg'))
    select = '--packages-select', 'billiard_shot', '--pytest-args', 'test/ros/test_robot.py'
    run(folder, environment, COLCON, 'test', *select)
    said = run(folder, environment, COLCON, 'test-result', '--all')
    assert re.search(r'^Summary: [1-9]\d* tests, 0 errors, 0 failures', said, re.MULTILINE), said


def test_symlink_install_runs_the_sources(workspace, environment, tmp_path):
    """In a second workspace over the first one, which has the messages."""
    folder = make_workspace(tmp_path)
    run(folder, sourced(environment, workspace), 'bash', '-c', f'{COLCON} build --symlink-install')
    said = run(
        folder,
        sourced(environment),
        'bash',
        '-c',
        (
            f'{sys.executable} -c "import billiard_shot as b; print(b.__file__)" && '
            'install/billiard_shot/lib/billiard_shot/billiard-shot scene list'
        ),
    )
    module, *scenes = said.splitlines()
    assert Path(module).resolve() == folder / 'src/billiard_shot/billiard_shot/__init__.py'
    assert any(line.startswith('paper') for line in scenes)
    launch = folder / 'install/billiard_shot/share/billiard_shot/launch/shot.launch.py'
    assert launch.resolve() == folder / 'src/billiard_shot/launch/shot.launch.py'


def test_what_ros2_run_and_launch_look_for_is_there(workspace):
    install = workspace / 'install' / 'billiard_shot'
    nodes = {path.name for path in (install / 'lib' / 'billiard_shot').iterdir()}
    assert nodes >= {'predictor', 'cue_driver', 'cue_sim', 'table_sim', 'billiard-shot'}
    share = install / 'share'
    assert (share / 'ament_index/resource_index/packages/billiard_shot').exists()
    for file in (
        'package.xml',
        'launch/shot.launch.py',
        'config/predictor.yaml',
        'config/scenes/paper.yaml',
    ):
        assert (share / 'billiard_shot' / file).is_file()


def test_a_node_runs_from_the_workspace(workspace, environment):
    starts_and_ends(
        ['bash', '-c', 'exec install/billiard_shot/lib/billiard_shot/predictor'],
        'ready: service /predict_shot',
        cwd=workspace,
        env=sourced(environment) | {'BILLIARD_SHOT_INTERPRET': '1'},
    )


@pytest.mark.skipif(
    importlib.util.find_spec('colcon_test_result') is None, reason='needs colcon-test-result'
)
def test_colcon_test_finds_the_tests(workspace, environment):
    """A few of them: how they go is what all other files here say."""
    run(
        workspace,
        environment | {'BILLIARD_SHOT_INTERPRET': '1'},
        COLCON,
        'test',
        '--packages-select',
        'billiard_shot',
        '--pytest-args',
        'test/scene/test_rack.py',
    )
    said = run(workspace, environment, COLCON, 'test-result', '--all')
    assert re.search(r'^Summary: [1-9]\d* tests, 0 errors, 0 failures', said, re.MULTILINE), said
