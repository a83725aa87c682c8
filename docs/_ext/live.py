"""
Live tables in the pages as HTML.

    ```{live} SCENE
    :speed: 2
    ```

shows the page of a stroke, or without a stroke that of the scene. SCENE is a bundled scene, or a
file that the page shows.
"""

import html
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive
from pages import FILE
import yaml

from billiard_shot import predict, Scene, Stroke
from billiard_shot.embed.scenes import core_script
from billiard_shot.pictures.view import page_of, page_of_scene

FOLDER = '_live'
CORE = 'core.js'  # which all live tables share
STROKE = ('a', 'b', 'elevation_deg', 'azimuth_deg', 'speed')


class Live(Directive):
    """A frame with a live table."""

    required_arguments = 1
    option_spec: ClassVar = dict.fromkeys(STROKE, float)

    def run(self) -> list[nodes.Node]:
        """Write the page, and return its frame."""
        environment = self.state.document.settings.env
        folder = Path(environment.app.outdir, FOLDER)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / CORE).write_text(core_script(), encoding='utf-8')
        name = self.arguments[0]
        shown = dict(FILE.findall(Path(environment.doc2path(environment.docname)).read_text()))
        given: Any = yaml.safe_load(shown[name]) if name in shown else None
        scene = Scene.from_dict(given) if given else Scene.load(name)
        if self.options:
            shot = predict(scene, Stroke.from_offsets(**self.options))
            text = page_of(shot, name, core=CORE)
        else:
            text = page_of_scene(scene, name, core=CORE)
        page = f'{environment.docname}-{self.lineno}.html'
        (folder / page).write_text(text, encoding='utf-8')
        frame = f'<iframe class="live" src="{FOLDER}/{page}" title="{html.escape(name)}"></iframe>'
        return [nodes.raw('', frame, format='html')]


def setup(app: Any) -> dict[str, Any]:
    """Add the directive."""
    app.add_directive('live', Live)
    return {'parallel_read_safe': False}
