"""
Ask a running predictor for strokes, and print its answers.

    ros2 run billiard_shot predict_shot --b 0.3 --speed 2
"""

from collections.abc import Sequence

from billiard_shot_msgs.msg import BallTrajectory
from billiard_shot_msgs.srv import PredictShot
import numpy as np

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cli.stroke_options import strokes_from_options
from billiard_shot.perception.sightings import Sighting
from billiard_shot.ros import conversions, cue_conversions
from billiard_shot.ros.client import (
    add_client_arguments,
    CLIENT_HELP,
    RobotClient,
    run_client,
    say,
)
from billiard_shot.ros.node_runner import own_arguments, parser_of
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.model.motion import Motion


def request_of(
    stroke: Stroke, scene: Scene, ball: tuple[float, float] = (0.0, 0.0)
) -> PredictShot.Request:
    """Make the request for a stroke at the cue ball, which lies at (x, y) [m]."""
    plan = cue_conversions.plan_of(stroke, {CUE_BALL: Sighting(ball)}, scene, 'request')
    request = PredictShot.Request(
        cue_pose=cue_conversions.pose_of(plan.position, plan.quaternion), speed=plan.speed
    )
    request.ball_position.x, request.ball_position.y = ball
    return request


def response_text(response: PredictShot.Response, brief: bool = False) -> str:
    """Format a response: status and ball and, unless `brief`, the cue and the trajectories."""
    status = Status(response.status)
    lines = [f'  {status.name}' + (f': {response.message}' if response.message else '')]
    if not status.refused:
        v, w = response.velocity, response.spin
        lines.append(
            f'  ball velocity {v.x:.4f} {v.y:.4f} {v.z:.4f} m/s, '
            f'spin {w.x:.4f} {w.y:.4f} {w.z:.4f} rad/s'
        )
        if not brief:
            lines.append(f'  cue speed {response.cue_speed:.4f} m/s')
            for trajectory in (response.trajectory, *response.other_balls):
                lines += _samples(trajectory)
    return '\n'.join(lines)


def _samples(trajectory: BallTrajectory) -> list[str]:
    name = f'ball {trajectory.id}'
    lines = [f'  {name:14} t (s)      x (m)      y (m)      z (m)    v (m/s)  motion']
    positions = conversions.vectors(trajectory.positions)
    speeds = np.linalg.norm(conversions.vectors(trajectory.velocities), axis=1)
    for i, motion in enumerate(trajectory.motion):
        numbers = (trajectory.times[i], *positions[i], speeds[i])
        row = ''.join(f'{number:11.4f}' for number in numbers)
        lines.append(f'{"":11}{row}  {Motion(motion).name.lower()}')
    return lines


def main(args: Sequence[str] | None = None) -> None:
    """Call `predict_shot` for every stroke; the exit code is 1 if a stroke is refused."""
    parser = parser_of('predict_shot', __doc__, CLIENT_HELP)
    add_client_arguments(parser)
    add = parser.add_argument
    table = 'with the balls of table_state; otherwise with those of the scenes'
    add('--table', action='store_true', help=table)
    add('--brief', action='store_true', help='two lines for each stroke')
    options = parser.parse_args(own_arguments(args))
    try:
        scene = Scene.load(options.scene)
        strokes = strokes_from_options(options, scene)
    except (ValueError, OSError) as error:
        parser.error(str(error))

    def ask(client: RobotClient) -> bool:
        client.wait_for_predictor()
        ball = scene.cue_ball[:2]
        if options.table:
            client.wait_for_table()
            if seen := client.balls().get(CUE_BALL):
                ball = seen.position
        refused = False
        for name, stroke in strokes.items():
            request = request_of(stroke, scene, ball)
            request.use_table_state, request.all_balls = options.table, True
            response = client.predict(request)
            say(f'{name}: {stroke}\n{response_text(response, options.brief)}')
            refused |= Status(response.status).refused
        return not refused

    run_client('predict_shot', args, ask, timeout=options.wait)


if __name__ == '__main__':
    main()
