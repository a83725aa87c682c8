"""
The verbs of the `ros2` command that the pages use, for tests on machines without that command.

They fill in messages from YAML and print them as the real ones do.
"""

import argparse
import array
import contextlib
from importlib import import_module
import os
import sys
import time

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
import yaml


def load(name):
    """Class of an interface: std_msgs/msg/Bool."""
    package, kind, interface = name.split('/')
    return getattr(import_module(f'{package}.{kind}'), interface)


def fill(message, values):
    """Fill in a message from mappings, lists, numbers and strings; types are strict."""
    types = message.get_fields_and_field_types()
    for field, value in values.items():
        kind = types[field]  # KeyError: there is no such field
        if kind.startswith('sequence<') and '/' in kind:
            value = [fill(element_of(kind), each) for each in value]
        elif '/' in kind:
            value = fill(getattr(message, field), value)
        elif kind == 'double':
            value = float(value)
        setattr(message, field, value)
    return message


def element_of(kind):
    package, interface = kind.removeprefix('sequence<').removesuffix('>').split('/')
    return load(f'{package}/msg/{interface}')()


def plain(message):
    """Convert a message to mappings, lists, numbers and strings."""
    if hasattr(message, 'get_fields_and_field_types'):
        return {
            name: plain(getattr(message, name)) for name in message.get_fields_and_field_types()
        }
    if hasattr(message, 'tolist'):  # an array of numbers
        return plain(message.tolist())
    if isinstance(message, list | tuple | array.array):
        return [plain(each) for each in message]
    return message


def as_yaml(message):
    """Text as `ros2 action send_goal` and `ros2 topic echo` print it."""
    return yaml.safe_dump(plain(message), allow_unicode=True, width=sys.maxsize, sort_keys=False)


def publish(node, options):
    kind = load(options.type)
    publisher = node.create_publisher(kind, options.name, 10)
    while True:
        publisher.publish(fill(kind(), yaml.safe_load(options.values)))
        time.sleep(1.0 / options.rate)


def echo(node, options):
    """Print a field of one message."""
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    received = []
    node.create_subscription(load(options.type), options.name, received.append, qos)
    while not received:
        rclpy.spin_once(node)
    print(f'{as_yaml(getattr(received[0], options.field))}---')


def call_service(node, options):
    kind = load(options.type)
    client = node.create_client(kind, options.name)
    client.wait_for_service()
    time.sleep(1.0)  # the service has to discover this client, too
    future = client.call_async(fill(kind.Request(), yaml.safe_load(options.values)))
    rclpy.spin_until_future_complete(node, future)
    print(f'response:\n{future.result()!r}\n')


def send_goal(node, options):
    kind = load(options.type)
    client = ActionClient(node, kind, options.name)
    client.wait_for_server()
    time.sleep(1.0)
    sent = client.send_goal_async(
        fill(kind.Goal(), yaml.safe_load(options.values)),
        lambda message: (
            options.feedback and print(f'Feedback:\n{as_yaml(message.feedback)}', flush=True)
        ),
    )
    rclpy.spin_until_future_complete(node, sent)
    ended = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, ended)
    print(f'Result:\n{as_yaml(ended.result().result)}')
    print(f'Goal finished with status: {ended.result().status}')


def run(arguments):
    package, executable, *rest = arguments
    assert package == 'billiard_shot'
    os.execv(sys.executable, [sys.executable, '-m', 'billiard_shot.ros', executable, *rest])


def main():
    if sys.argv[1] == 'run':
        run(sys.argv[2:])
    parser = argparse.ArgumentParser()
    verbs = parser.add_subparsers(required=True)
    groups = {
        name: verbs.add_parser(name).add_subparsers() for name in ('topic', 'service', 'action')
    }
    for group, verb, action, default in (
        ('topic', 'pub', publish, None),
        ('topic', 'echo', echo, ''),
        ('service', 'call', call_service, '{}'),
        ('action', 'send_goal', send_goal, None),
    ):
        each = groups[group].add_parser(verb)
        each.add_argument('-r', '--rate', type=float)
        each.add_argument('-f', '--feedback', action='store_true')
        each.add_argument('--once', action='store_true')
        each.add_argument('--field')
        each.add_argument('--qos-durability')
        each.add_argument('name')
        each.add_argument('type')
        each.add_argument(
            'values', **({} if default is None else {'nargs': '?', 'default': default})
        )
        each.set_defaults(action=action)
    options = parser.parse_args()
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        options.action(rclpy.create_node(f'ros2cli_{os.getpid()}'), options)


if __name__ == '__main__':
    main()
