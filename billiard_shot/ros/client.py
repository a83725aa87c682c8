"""
Ask a running predictor for the four shots of the paper, and print its answers.

    python -m billiard_shot.ros.client

The `ros2` command is not needed. The shots are those of Jia, Mason, Erdmann (WAFR 2008), Table 1;
the normal of the jump is corrected.
"""

from collections.abc import Sequence
import math
import sys
import time
from typing import Any, TYPE_CHECKING

from billiard_shot_msgs.srv import PredictShot
import numpy as np
import rclpy
from rclpy.client import Client
from rclpy.node import Node

from billiard_shot import Scene, Status
from billiard_shot.ros import conversions
from billiard_shot.ros.conversions import Triple
from billiard_shot.ros.node_runner import initialized
from billiard_shot.table.motion import Motion

if TYPE_CHECKING:
    from rclpy.task import Future

PAPER_SHOTS: dict[str, tuple[Triple, Triple]] = {
    'vertical': ((-1.0, -2.0, 1.0), (0.0, 0.0, -2.0)),
    'horizontal': ((-1.0, -1.0, 0.0), (0.8, 0.0, 0.0)),
    'jump': ((-1.0, 0.0, 1.0), (1.0, 0.0, -1.0)),
    'massé': ((-2.0, -1.0, 12.0), (4.0, 0.0, -16.0)),
}
"""Outward normal at the contact point (of any length), and velocity of the cue (m/s)."""

RETREAT = 0.05
"""Distance of the tip from the contact point in a request [m]."""

START_UP = 120.0
"""Time to wait for the service [s]; a predictor may have to compile the library first."""

RETRY_PERIOD = 2.0
"""Time without an answer after which a repeatable request is sent again [s]."""

RENEWAL_PERIOD = 20.0
"""
Time without an answer after which a new client replaces the one that asked [s].

On busy machines with Fast DDS 3.2, a server sometimes never discovers a client. A new client is
announced again.
"""


def request_for(normal: Triple, velocity: Triple, radius: float) -> PredictShot.Request:
    """Make the request for a stroke that meets the ball, at the origin, at `normal`."""
    n = np.asarray(normal) / np.linalg.norm(normal)
    speed = float(np.linalg.norm(velocity))
    direction = np.asarray(velocity) / speed
    contact = radius * n + (0.0, 0.0, radius)
    # Turn +x up or down to the elevation, about y, and then about z to the azimuth.
    azimuth = math.atan2(direction[1], direction[0]) / 2
    elevation = math.atan2(-direction[2], math.hypot(direction[0], direction[1])) / 2
    quaternion = (
        -math.sin(azimuth) * math.sin(elevation),
        math.cos(azimuth) * math.sin(elevation),
        math.sin(azimuth) * math.cos(elevation),
        math.cos(azimuth) * math.cos(elevation),
    )
    x, y, z = (contact - RETREAT * direction).tolist()
    return conversions.make_request((x, y, z), quaternion, speed)


class ServiceCaller:
    """
    Client of a service that waits for the answers.

    Parameters
    ----------
    node : Node
    kind
        Type of the service.
    name : str
        Name of the service.

    Attributes
    ----------
    client : Client
        Client in use.

    """

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        self._node, self._kind, self._name = node, kind, name
        self.client: Client[Any, Any] = node.create_client(kind, name)

    @property
    def service_name(self) -> str:
        """Name of the service, with its namespace."""
        return self.client.service_name

    def service_is_ready(self) -> bool:
        """Whether the service has been discovered."""
        return self.client.service_is_ready()

    def wait_for_service(self, timeout: float) -> bool:
        """Wait up to `timeout` seconds for the service; return whether it has been discovered."""
        return self.client.wait_for_service(timeout_sec=timeout)

    def call(self, request: Any, timeout: float = 10.0, repeatable: bool = False) -> Any:
        """
        Call the service, and return its answer.

        Parameters
        ----------
        request
            Request message.
        timeout : float
            Time to wait for an answer [s].
        repeatable : bool
            Whether the request may be executed twice. It is then sent again if there is no answer.
            The answer is lost if the server has not yet discovered the client, even if the client
            has discovered the server (github.com/ros2/rmw_fastrtps/issues/842). If the server
            does not discover the client at all, a new client replaces it.

        Raises
        ------
        TimeoutError
            If there is no answer within `timeout`.

        """
        begin = since = time.monotonic()
        while (left := begin + timeout - time.monotonic()) > 0.0:
            future = self.client.call_async(request)
            rclpy.spin_until_future_complete(
                self._node, future, timeout_sec=min(left, RETRY_PERIOD) if repeatable else left
            )
            if future.done():
                return result_of(future)
            self.client.remove_pending_request(future)
            if time.monotonic() - since >= RENEWAL_PERIOD:
                since = time.monotonic()
                self._renew()
        raise TimeoutError(f'no answer from {self.service_name} within {timeout} s')

    def destroy(self) -> None:
        """Remove the client from its node."""
        self._node.destroy_client(self.client)

    def _renew(self) -> None:
        self.destroy()
        self.client = self._node.create_client(self._kind, self._name)


def result_of(future: 'Future[Any]') -> Any:
    """Return the result of a future that is done."""
    result = future.result()
    assert result is not None
    return result


def report(response: PredictShot.Response) -> str:
    """Format a response as text: status, ball, cue, and the samples of the trajectory."""
    status = Status(response.status)
    lines = [f'  {status.name}' + (f': {response.message}' if response.message else '')]
    if status.refused:
        return lines[0]
    for name, vector, unit in (
        ('velocity', response.velocity, 'm/s'),
        ('spin', response.spin, 'rad/s'),
    ):
        lines.append(f'  ball {name:9}{vector.x:11.4f}{vector.y:11.4f}{vector.z:11.4f}  {unit}')
    lines.append(f'  cue speed     {response.cue_speed:11.4f}{"":24}m/s')
    lines.append('  trajectory     t (s)      x (m)      y (m)      z (m)    v (m/s)  motion')
    trajectory = response.trajectory
    positions = conversions.vectors(trajectory.positions)
    speeds = np.linalg.norm(conversions.vectors(trajectory.velocities), axis=1)
    for i, motion in enumerate(trajectory.motion):
        numbers = (trajectory.times[i], *positions[i], speeds[i])
        lines.append(
            f'{"":11}'
            + ''.join(f'{number:11.4f}' for number in numbers)
            + f'  {Motion(motion).name.lower()}'
        )
    return '\n'.join(lines)


def main(args: Sequence[str] | None = None) -> None:
    """Call `predict_shot` for every shot; exit with 1 if a shot is refused or not answered."""
    radius = Scene.load('paper').ball.radius
    with initialized(args):
        node = Node('paper_shots')
        predictor = ServiceCaller(node, PredictShot, 'predict_shot')
        if not predictor.wait_for_service(START_UP):
            sys.exit(f'no service {predictor.service_name}: is the predictor running?')
        for name, (normal, velocity) in PAPER_SHOTS.items():
            response = predictor.call(request_for(normal, velocity, radius), repeatable=True)
            print(f'{name}: cue velocity {velocity} m/s, meets the ball at normal {normal}')
            print(report(response), end='\n\n', flush=True)
            if Status(response.status).refused:
                sys.exit(1)


if __name__ == '__main__':
    main()
