"""The page of a scene or a shot as a widget of notebooks, with Python behind it."""

from html import escape
from pathlib import Path
from typing import Any

from billiard_shot.embed.page_state import played, scene_in, start_of, stroke_in
from billiard_shot.pictures.view import page_of, page_of_scene
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(
        "the widget needs anywidget, an extra: pip install 'billiard_shot[notebook]'"
    ) from None

HEIGHT = 560  # px
# As in page/widget.js; it plays on in pages that are made of a notebook, without Python.
FRAME = (
    '<iframe srcdoc="{}" title="Billiard table" sandbox="allow-scripts allow-downloads"'
    ' loading="lazy" style="width: 100%; height: {}px; border: none"></iframe>'
)


class TableWidget(anywidget.AnyWidget):
    """
    A table to play on in a notebook.

    It follows the page, and `observe(function, names)` tells of changes. If a scene is given, the
    page chooses the first stroke: until it is shown, `stroke` and `shot` are None.

    Parameters
    ----------
    start : Scene, str, Path or Shot
    height : int
        Of the frame [pixels].

    Attributes
    ----------
    stroke : Stroke
        Another one that is assigned is shown in the page.
    scene : Scene
        With the balls, effects and numbers of the page.
    shot : Shot
        Of the stroke in the scene.
    estimate : dict
        The last chance that the page has found, of `n` strokes with errors: `chance`, `interval`
        (95 %) and `target`, if there is a target. None while the page counts.
    state : dict
        All that can be changed in the page, see page/state.js.

    """

    _esm = Path(__file__).with_name('page') / 'widget.js'
    page = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(HEIGHT).tag(sync=True)
    state = traitlets.Dict().tag(sync=True)
    estimate = traitlets.Dict(default_value=None, allow_none=True).tag(sync=True)
    scene = traitlets.Instance(Scene)
    stroke = traitlets.Instance(Stroke, allow_none=True)
    shot = traitlets.Instance(Shot, allow_none=True)

    def __init__(self, start: SceneLike | Shot, height: int = HEIGHT) -> None:
        shot = start if isinstance(start, Shot) else None
        self._given = start.scene if isinstance(start, Shot) else Scene.load(start)
        self._tolerance = shot.tolerance if shot else DEFAULT_SHOT_TOLERANCE
        super().__init__(page=_page(start, framed=True), height=height, scene=self._given)
        if shot:
            self.state = start_of(shot)

    @traitlets.observe('stroke')
    def _show_stroke(self, _: object) -> None:
        """Put a stroke that was assigned into the state."""
        if self.stroke and not (self.state and stroke_in(self.state) == self.stroke):
            self.state = {**self.state, **played(self.scene, self.stroke)}

    @traitlets.observe('state')
    def _play_state(self, _: object) -> None:
        """Predict the shot of a state, of the page or of an assigned stroke."""
        scene, stroke = scene_in(self.state, self._given), stroke_in(self.state)
        shot = predict(scene, stroke, tolerance=self._tolerance)
        with self.hold_trait_notifications():  # who is told of one finds all of them
            self.scene, self.stroke, self.shot = scene, stroke, shot

    def _repr_mimebundle_(self, **options: Any) -> Any:
        """Add a page for readers without widgets."""
        data, metadata = super()._repr_mimebundle_(**options) or ({}, {})
        page = _page(self.shot or self.scene, framed=False)
        return {**data, 'text/html': FRAME.format(escape(page), self.height)}, metadata


def _page(start: SceneLike | Shot, *, framed: bool) -> str:
    if isinstance(start, Shot):
        return page_of(start, framed=framed)
    return page_of_scene(start, framed=framed)
