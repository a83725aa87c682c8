"""A node as a process of its own, from its start to its end."""

import signal
import subprocess


def starts_and_ends(command, ready='ready', **options):
    """Start a node, wait until it says that it is ready, and interrupt it: it ends with code 0."""
    node = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options
    )
    try:
        assert any(ready in line for line in node.stdout), f'it never said {ready!r}'
    finally:
        node.send_signal(signal.SIGINT)
        assert node.wait(timeout=60) == 0
        node.stdout.close()
