"""
Print a sealed goal of `execute_shot` as one line of YAML, for `ros2 action send_goal`.

    ros2 run billiard_shot seal_shot

Needs a planner that has made a plan.
"""

import array
from collections.abc import Sequence
import math
import sys
from typing import Any

from billiard_shot_msgs.srv import SealShot
from rclpy.node import Node
import yaml

from billiard_shot.ros.client import ServiceCaller
from billiard_shot.ros.node_runner import initialized
from billiard_shot.ros.player import own_arguments, parser_of
from billiard_shot.ros.sealing import DEFAULT_VALIDITY

TIMEOUT = 10.0
"""Time to wait for the planner [s]."""


def plain(message: Any) -> Any:
    """Convert a message to mappings, lists, numbers and strings."""
    if hasattr(message, 'get_fields_and_field_types'):
        return {
            name: plain(getattr(message, name)) for name in message.get_fields_and_field_types()
        }
    if isinstance(message, list | tuple | array.array):
        return [plain(each) for each in message]
    return message


def one_line(fields: dict[str, Any]) -> str:
    """Write YAML in one line; reading it gives exactly the same numbers."""
    return yaml.safe_dump(
        fields,
        default_flow_style=True,
        width=math.inf,
        sort_keys=False,
        allow_unicode=True,
    ).strip()


def main(args: Sequence[str] | None = None) -> None:
    """Ask the planner for a sealed goal and print it; the exit code is 1 if it refuses."""
    parser = parser_of('seal_shot', __doc__)
    parser.epilog = (
        'exit codes: 0 printed; 1 refused; 2 invalid arguments; 3 no answer from a planner'
    )
    parser.add_argument(
        '--plan-id',
        default='',
        metavar='ID',
        help='plan_id in the result of plan_shot; the last plan by default',
    )
    parser.add_argument(
        '--rank',
        type=int,
        default=1,
        metavar='N',
        help='rank of the stroke in the plan (1, the best)',
    )
    parser.add_argument('--shot-id', default='', metavar='NAME', help='name for the shot')
    parser.add_argument(
        '--valid-for',
        type=float,
        default=DEFAULT_VALIDITY,
        metavar='S',
        help=f'time in seconds within which the shot must be fired ({DEFAULT_VALIDITY:g})',
    )
    options = parser.parse_args(own_arguments(args))
    if not 1 <= options.rank < 2**32:
        parser.error(f'--rank: {options.rank} is not allowed; it must be at least 1')
    request = SealShot.Request(**vars(options))
    try:
        with initialized(args):
            node = Node('seal_shot')
            planner = ServiceCaller(node, SealShot, 'seal_shot')
            if not planner.wait_for_service(TIMEOUT):
                raise TimeoutError(
                    f'no service {planner.service_name} within {TIMEOUT:g} s: is '
                    'the planner running?'
                )
            sealed = planner.call(request, repeatable=True)
    except TimeoutError as error:
        print(f'seal_shot: {error}', file=sys.stderr)
        sys.exit(3)
    if sealed.status != SealShot.Response.OK:
        sys.exit(f'seal_shot: {sealed.message}')
    print(sealed.message, file=sys.stderr)
    print(one_line({name: plain(getattr(sealed, name)) for name in ('plan', 'nonce', 'expiry')}))


if __name__ == '__main__':
    main()
