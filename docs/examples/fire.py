"""Plan a stroke, aim the cue, and fire when a person says so."""

from billiard_shot_msgs.action import ExecuteShot, PlanShot
from billiard_shot_msgs.msg import Target
from billiard_shot_msgs.srv import Arm
from geometry_msgs.msg import Point
import rclpy
from rclpy.action import ActionClient
from rclpy.duration import Duration

rclpy.init()
node = rclpy.create_node('fire')


def wait(future):
    rclpy.spin_until_future_complete(node, future)
    return future.result()


def begin(kind, name, goal, feedback=None):
    client = ActionClient(node, kind, name)
    client.wait_for_server()
    return wait(client.send_goal_async(goal, feedback)).get_result_async()


def call(kind, name, request):
    client = node.create_client(kind, name)
    client.wait_for_service()
    return client.call_async(request)


target = Target(kind=Target.REST, point=Point(x=0.3, y=0.2), radius=0.1)
result = wait(begin(PlanShot, 'plan_shot', PlanShot.Goal(target=target))).result
print(result.message)
plan = result.plans[0].plan
expiry = node.get_clock().now() + Duration(seconds=60)
goal = ExecuteShot.Goal(plan=plan, expiry=expiry.to_msg())
states = []
ended = begin(
    ExecuteShot, 'execute_shot', goal, lambda message: states.append(message.feedback.state)
)
while not ended.done() and not any(state.state == state.AIMED for state in states):
    rclpy.spin_once(node)
if not ended.done() and input('fire? ') == 'yes':
    print(wait(call(Arm, 'cue_driver/arm', Arm.Request(shot_id=plan.shot_id))).message)
print(wait(ended).result.message)
