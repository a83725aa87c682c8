"""
MCAP bags, written and read as `ros2 bag` does, which cannot be installed from PyPI.

It subscribes with the QoS that the publishers offer. The bag has that QoS, and the hashes of the
types.
"""

import contextlib
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
import re
import shlex
import sys
import threading
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / 'docs' / 'examples'))

from check_bag import differences, share_of

PAGE = (ROOT / 'docs' / 'ros.md').read_text()
SHARED = ('/diagnostics', '/rosout', '/tf', '/tf_static')
"""Topics that are not in the namespace of the nodes."""
PACKAGES = ('billiard_shot_msgs', 'vision_msgs')
"""Packages of messages that rosbags does not know, if they are installed."""
FOREVER = QosTime(2147483647, 4294967295)


def topics_of(command, space):
    """Topics in the line of docs/ros.md that begins with a command, in a namespace."""
    (line,) = re.findall(rf'^{command} .*$', PAGE.replace('\\\n', ' '), re.MULTILINE)
    words = shlex.split(line)
    names = [word for word in words[words.index('--topics') + 1 :] if word.startswith('/')]
    return [name if name in SHARED else space + name for name in names]


def kind_of(name):
    """Class of a type such as `std_msgs/msg/Bool`."""
    package, folder, message = name.split('/')
    if folder == 'action':
        action, _, part = message.partition('_')
        return getattr(getattr(import_module(f'{package}.action'), action).Impl, part)
    return getattr(import_module(f'{package}.{folder}'), message)


def types():
    """Definitions of all message types; of an action they are in the folder of the messages."""
    store = get_typestore(Stores.ROS2_KILTED)
    texts = {}
    for package in filter(find_spec, PACKAGES):
        share = share_of(package)
        texts |= {
            f'{package}/msg/{file.stem}': file.read_text() for file in share.glob('msg/*.msg')
        }
        for file in share.glob('action/*.action'):
            name = f'{package}/msg/{file.stem}_Feedback'
            texts[name] = file.read_text().split('\n---\n')[2]
            texts[f'{name}Message'] = f'unique_identifier_msgs/UUID goal_id\n{name} feedback'
    for name, text in texts.items():
        store.register(get_types_from_msg(text, name))
    return store


@contextlib.contextmanager
def writing(bag):
    """Open a bag; the value adds a topic, and returns the function that writes its messages."""
    store = types()
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:

        def add(topic, kind, type_hash, durability='VOLATILE', reliability='RELIABLE'):
            definition, _ = store.generate_msgdef(kind.replace('/action/', '/msg/'), 2)
            connection = writer.add_connection(
                topic,
                kind,
                msgdef=definition,
                rihs01=type_hash,
                offered_qos_profiles=[
                    Qos(
                        QosHistory.KEEP_LAST,
                        1,
                        QosReliability[reliability],
                        QosDurability[durability],
                        FOREVER,
                        FOREVER,
                        QosLiveliness.AUTOMATIC,
                        FOREVER,
                        avoid_ros_namespace_conventions=False,
                    )
                ],
            )
            return lambda data: writer.write(connection, time.time_ns(), data)

        yield add


@contextlib.contextmanager
def recording(bag, topics):
    """Record topics that have publishers; the value is the last message of each."""
    latest = {}
    recorder = rclpy.create_node('recorder')
    executor = SingleThreadedExecutor()
    executor.add_node(recorder)
    with writing(bag) as add:
        for topic in topics:
            offers = recorder.get_publishers_info_by_topic(topic)
            (durability,) = {offer.qos_profile.durability for offer in offers}
            (reliability,) = {offer.qos_profile.reliability for offer in offers}
            (kind,) = {offer.topic_type for offer in offers}
            (type_hash,) = {str(offer.topic_type_hash) for offer in offers}
            write = add(topic, kind, type_hash, durability.name, reliability.name)

            def hear(data, write=write, topic=topic, kind=kind):
                write(data)
                latest[topic] = deserialize_message(data, kind_of(kind))

            recorder.create_subscription(
                kind_of(kind),
                topic,
                hear,
                QoSProfile(depth=1000, durability=durability, reliability=reliability),
                raw=True,
            )
        thread = threading.Thread(target=executor.spin)
        thread.start()
        try:
            yield latest
        finally:
            executor.shutdown()
            thread.join()
            recorder.destroy_node()


def messages(bag, *topics):
    """
    Messages on topics of a bag in their order, each with its topic and its time [ns].

    If a definition has changed, ValueError names the types: the bytes would be read wrongly.
    """
    if different := differences(bag):
        raise ValueError(f'{bag}: other definitions of {", ".join(sorted({*different.values()}))}')
    with Reader(bag) as reader:
        connections = [each for each in reader.connections if each.topic in topics]
        for each, stamp, data in reader.messages(connections):
            yield each.topic, stamp, deserialize_message(bytes(data), kind_of(each.msgtype))


def content(bag, topic):
    """Messages on a topic of a bag."""
    return [message for _, _, message in messages(bag, topic)]
