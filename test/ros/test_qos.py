"""Publishers whose quality of service does not match that of a node's subscription."""

from contextlib import suppress
from pathlib import Path
import re
import sys
import threading

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import TableState
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
VOLATILE = QoSProfile(depth=1)


@pytest.mark.parametrize(
    ('name', 'kind', 'topic', 'offered', 'policy'),
    [
        ('cue_driver', Bool, 'estop', BEST_EFFORT, 'RELIABILITY'),
        ('table_display', TableState, 'table_state', VOLATILE, 'DURABILITY'),
    ],
)
def test_a_node_logs_a_publisher_that_does_not_match(
    launch, node, name, kind, topic, offered, policy
):
    logged = threading.Event()

    def publish():
        """Offer the topic; again after a while, because discovery may miss a publisher."""
        while not logged.is_set():
            publisher = node.create_publisher(kind, f'/unheard/{topic}', offered)
            logged.wait(30.0)
            node.destroy_publisher(publisher)

    threading.Thread(target=publish, daemon=True).start()
    # A driver subscribes when it is configured; other nodes ignore the parameter.
    process = launch(name, '-r', '__ns:=/unheard', '-p', 'autostart:=true')
    watchdog = threading.Timer(240.0, process.kill)
    watchdog.start()
    lines = iter(process.stdout.readline, '')
    said = f"topic '{topic}', offering incompatible QoS"
    try:
        assert any(said in line and policy in line for line in lines)
    finally:
        logged.set()
        watchdog.cancel()
        process.terminate()


@pytest.mark.skipif(sys.platform != 'linux', reason='the names of threads are in /proc')
def test_nothing_is_received_through_shared_memory(node):
    """After a pause of a second a process could stay deaf to another one."""
    threads = set()
    for file in Path('/proc/self/task').glob('*/comm'):
        with suppress(FileNotFoundError, ProcessLookupError):  # of threads that have ended
            threads.add(file.read_text().strip())
    if not any(re.fullmatch(r'dds\.udp\.\d+', name) for name in threads):
        pytest.skip('needs Fast DDS, whose threads have the names of their ports')
    assert not [name for name in threads if re.fullmatch(r'dds\.shm\.\d+', name)]
