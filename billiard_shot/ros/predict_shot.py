"""
Ask a running predictor for strokes, and print its answers; `billiard-shot predict` says more.

    ros2 run billiard_shot predict_shot --b 0.3 --speed 2
"""

from collections.abc import Sequence
from dataclasses import dataclass

from billiard_shot_msgs.srv import PredictShot

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cli.options import add_options
from billiard_shot.cli.shots import STROKE_OPTIONS, strokes_from_options
from billiard_shot.perception.sightings import Sighting
from billiard_shot.ros import conversions
from billiard_shot.ros.client import CLIENT_HELP, OfClient, RobotClient, run_client, say
from billiard_shot.ros.node_runner import own_arguments, parser_of
from billiard_shot.scene.placement import CUE_BALL


def request_of(
    stroke: Stroke, scene: Scene, ball: tuple[float, float] = (0.0, 0.0)
) -> PredictShot.Request:
    """Make the request for a stroke at the cue ball, which lies at (x, y) [m]."""
    plan = conversions.plan_of(stroke, {CUE_BALL: Sighting(ball)}, scene, 'request')
    request = PredictShot.Request(
        cue_pose=conversions.pose_of(plan.position, plan.quaternion), speed=plan.speed
    )
    request.ball_position.x, request.ball_position.y = ball
    return request


def response_text(response: PredictShot.Response) -> str:
    """Say the status, and how ball and cue move after the strike."""
    status = Status(response.status)
    text = f'  {status.name}' + (f': {response.message}' if response.message else '')
    if status.refused:
        return text
    v, w = response.velocity, response.spin
    return (
        f'{text}\n  ball velocity {v.x:.4f} {v.y:.4f} {v.z:.4f} m/s, '
        f'spin {w.x:.4f} {w.y:.4f} {w.z:.4f} rad/s\n  cue speed {response.cue_speed:.4f} m/s'
    )


@dataclass(frozen=True)
class OfRequest:
    """
    The request.

    Parameters
    ----------
    table : bool
        With the balls of table_state; otherwise with those of the scenes.

    """

    table: bool = False


def main(args: Sequence[str] | None = None) -> None:
    """Call `predict_shot` for every stroke; the exit code is 1 if a stroke is refused."""
    parser = parser_of('predict_shot', __doc__, CLIENT_HELP)
    add_options(parser, *STROKE_OPTIONS, OfClient(), OfRequest())
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
            request.use_table_state = options.table
            response = client.predict(request)
            say(f'{name}: {stroke}\n{response_text(response)}')
            refused |= Status(response.status).refused
        return not refused

    run_client('predict_shot', args, ask, timeout=options.wait)
