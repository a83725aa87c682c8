"""
Draws docs/figures/foxglove.png: what Foxglove's 3D panel shows of a predicted shot.

    .venv/bin/python docs/_foxglove/draw.py

Starts `table_display` and `predictor`, asks for a shot, and hands the markers that they publish to
the 3D renderer of Foxglove Studio (npm @foxglove/studio-base, MPL-2.0), with the settings of
config/foxglove.json. Needs npm, its registry, and a Chromium.
"""

from array import array
import json
import math
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile
import time

from domain_coordinator import domain_id
from PIL import Image
import rclpy
from visualization_msgs.msg import MarkerArray

from billiard_shot import Scene, Stroke
from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.ros.predict_shot import request_of
from billiard_shot.ros.robot import quiet_environment

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SCENE = 'blocked'
STROKE = Stroke.from_offsets(
    a=-0.3, b=-0.2, elevation=math.radians(50), azimuth=math.radians(-20.5), speed=2
)
NODES = ('table_display', 'predictor')
TOPICS = ('/table_display/table', '/table_display/balls', '/predictor/markers')
BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
SIZE = 1200, 640
PAGE = """<!doctype html>
<style>html, body, canvas {{ margin: 0; width: 100%; height: 100%; display: block }}</style>
<canvas></canvas>
<script>window.picture = {}</script>
<script src="bundle.js"></script>
"""


def published_markers():
    """Markers on each of TOPICS, as the nodes publish them."""
    received = {}
    with domain_id() as domain:
        os.environ |= quiet_environment(domain)
        nodes = [
            subprocess.Popen(
                [
                    sys.executable,
                    '-m',
                    'billiard_shot.ros',
                    name,
                    '--ros-args',
                    '-p',
                    f'scene:={SCENE}',
                ]
            )
            for name in NODES
        ]
        rclpy.init()
        try:
            node = RobotClient('picture')
            for topic in TOPICS:
                node.create_subscription(
                    MarkerArray,
                    topic,
                    lambda message, topic=topic: received.update({topic: message}),
                    LATCHED,
                )
            node.wait_for_predictor()
            scene = Scene.load(SCENE)
            node.predict(request_of(STROKE, scene, scene.cue_ball[:2]))
            end = time.monotonic() + 30.0
            while len(received) < len(TOPICS) and time.monotonic() < end:
                rclpy.spin_once(node, timeout_sec=0.1)
        finally:
            rclpy.shutdown()
            for process in nodes:
                process.terminate()
                process.wait()
    if missing := set(TOPICS) - set(received):
        sys.exit(f'no message on {", ".join(missing)}')
    return received


def plain(value):
    """Value of a message as JSON has it, with the names that Foxglove gives to the fields."""
    if hasattr(value, 'get_fields_and_field_types'):
        return {
            name.replace('nanosec', 'nsec'): plain(getattr(value, name))
            for name in value.get_fields_and_field_types()
        }
    return [plain(each) for each in value] if isinstance(value, list | array) else value


def main():
    """Draw the picture."""
    layout = json.loads((ROOT / 'config' / 'foxglove.json').read_text())
    (settings,) = (each for name, each in layout['configById'].items() if name.startswith('3D!'))
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        sys.exit(f'none of {", ".join(BROWSERS)} is installed')
    messages = [
        {
            'topic': topic,
            'schemaName': 'visualization_msgs/msg/MarkerArray',
            'message': plain(message),
        }
        for topic, message in published_markers().items()
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in ('package.json', 'bundle.mjs', 'page.js'):
            shutil.copy(HERE / file, folder)
        for command in (
            ('npm', 'install', '--ignore-scripts', '--legacy-peer-deps', '--no-audit'),
            ('node', 'bundle.mjs'),
        ):
            subprocess.run(command, cwd=folder, check=True)
        (folder / 'page.html').write_text(
            PAGE.format(json.dumps({'settings': settings, 'messages': messages}))
        )
        subprocess.run(
            [
                browser,
                '--headless=new',
                '--no-sandbox',
                '--use-angle=swiftshader',
                '--enable-unsafe-swiftshader',
                '--hide-scrollbars',
                '--virtual-time-budget=10000',
                f'--user-data-dir={folder}/profile',
                '--window-size={},{}'.format(*SIZE),
                f'--screenshot={folder}/picture.png',
                (folder / 'page.html').as_uri(),
            ],
            check=True,
            stderr=subprocess.DEVNULL,
            timeout=300,
        )
        # 256 colours are enough, and a third of the size.
        Image.open(folder / 'picture.png').convert('RGB').quantize(256).save(
            ROOT / 'docs' / 'figures' / 'foxglove.png', optimize=True
        )


if __name__ == '__main__':
    main()
