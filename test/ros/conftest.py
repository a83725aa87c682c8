"""Real processes and the real middleware, in a ROS domain of their own."""

from collections.abc import Callable, Iterator
import contextlib
from functools import partial
import gc
import os
import signal
import subprocess
import sys
from typing import Any

import pytest

Start = Callable[..., subprocess.Popen[str]]

LONGEST = ('test_firing', 'test_cue', 'test_paused_processes', 'test_driver_safety', 'test_bags')
"""Files that begin first, so that the workers end together."""

STARVED_RUNS = 4
"""Runs of a test of which all but the last may end because a process was starved."""


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    order = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))
    for item in items:
        if item.path.is_relative_to(os.path.dirname(__file__)):
            item.add_marker(pytest.mark.ros)
            # One worker for a file, whose tests share nodes; a launch test has no fixtures.
            own = item.get_closest_marker('xdist_group')
            if 'domain' in getattr(item, 'fixturenames', ()) and not own:
                item.add_marker(pytest.mark.xdist_group(item.path.stem))


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """
    Repeat a failed test of nodes if a process of these was starved; else it has failed.

    The fixture of the nodes, `cell` or `shell`, tells whether one was, and brings them in order.
    A driver that did not run for a second, or heard nothing for two, ends the shot, as it should.
    `test_paused_processes` asserts that, with processes that do not run because it stops them.
    """
    cell = pyfuncitem.funcargs.get('cell') or pyfuncitem.funcargs.get('shell')
    if cell is None or pyfuncitem.get_closest_marker('pauses_processes'):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    for left in reversed(range(STARVED_RUNS)):
        try:
            pyfuncitem.obj(**arguments)
            return True
        except AssertionError as error:
            if not left or not cell.starved(error):
                raise
            pyfuncitem.warn(pytest.PytestWarning(f'repeated, because a process starved: {error}'))
            if 'launch_once' in arguments:
                arguments['launch_once'].close()
            cell.prepare()
    return None


@pytest.fixture(scope='session')
def domain() -> Iterator[None]:
    """Set a private ROS domain for this process and those that it starts."""
    from domain_coordinator import domain_id

    from billiard_shot.ros.robot import quiet_environment

    with domain_id() as number, pytest.MonkeyPatch.context() as patch:
        for name, value in quiet_environment(number).items():
            patch.setenv(name, value)
        yield


class Launch(contextlib.ExitStack):
    """Starts nodes; `close` stops them."""

    def __call__(self, name: str, *arguments: str, stdin: Any = None) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, '-m', 'billiard_shot.ros', name, '--ros-args', *arguments],
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.callback(stop, process)
        return process


@pytest.fixture(scope='module')
def launch(domain: None) -> Iterator[Launch]:
    """Start nodes: `launch('cue_sim', '-p', 'rate:=100.0')`; they end with the file's tests."""
    with Launch() as launch:
        yield launch


@pytest.fixture
def launch_once(domain: None) -> Iterator[Launch]:
    """Like `launch`, for nodes that end with the test: an idle node takes a fifth of a core."""
    with Launch() as launch:
        yield launch


@pytest.fixture(scope='module')
def start(launch: Start) -> Start:
    """Start predictors: `start('-p', 'scene:=paper')`."""
    return partial(launch, 'predictor')


def stop(process: subprocess.Popen[str]) -> None:
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
    try:
        process.wait(timeout=10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()


@pytest.fixture(scope='session')
def node(domain: None) -> Iterator[Any]:
    """Return a node of this process, to call and listen with."""
    import rclpy

    from billiard_shot.ros.node_runner import initialized

    with initialized():
        yield rclpy.create_node('tester')


@pytest.fixture(scope='session')
def predictor(domain: None) -> Iterator[subprocess.Popen[str]]:
    """Return the process of a predictor with its default parameters, for all tests."""
    with Launch() as launch:
        yield launch('predictor')


@pytest.fixture(scope='session')
def ask(node: Any, predictor: subprocess.Popen[str]) -> Callable[[Any], Any]:
    """Return a function that sends a request to the predictor and returns its answer."""
    from billiard_shot_msgs.srv import PredictShot
    from waiting import PatientCaller

    client = PatientCaller(node, PredictShot, 'predict_shot')
    assert client.wait_for_service(), 'the predictor did not come up'
    return lambda request: client.call(request, repeatable=True)


@pytest.fixture(scope='module')
def whole_cell(request: pytest.FixtureRequest, node: Any, launch: Start) -> Iterator[Any]:
    """Return the cell of a file, in the namespace SPACE and with the nodes NODES of that file."""
    from cell import Cell, PATIENT

    gc.freeze()  # a long look for garbage would be a silence
    cell = Cell(launch, request.module.SPACE, getattr(request.module, 'NODES', PATIENT))
    yield cell
    cell.close()


@pytest.fixture
def cell(whole_cell: Any) -> Any:
    """Return the cell in order: disarmed, ball in its place, every input heard."""
    whole_cell.prepare()
    return whole_cell
