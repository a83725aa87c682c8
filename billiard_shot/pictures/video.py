"""A shot as a GIF or an MP4: the table from above, in real time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.canvas import BLACK, require_matplotlib
from billiard_shot.pictures.table import (
    draw_balls,
    draw_cue,
    MOVING_COLOURS,
    PALE_PATH,
    shot_title,
    table_axes,
)
from billiard_shot.pictures.trails import cue_motion, OFF_CLOTH, path_colours, Trails, trails_of
from billiard_shot.scene.errors import reason
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.table.model.motion import Motion

Draw = Callable[[NDArray[np.float64]], Iterator[NDArray[np.uint8]]]

RATE = 25  # images per second
VIDEO_DPI = 100.0
BLOCK = 16  # pixels: encoders of MP4 want multiples of it
END_SHOWN = 1.0  # s for which the end is shown
FOLLOW = 0.25  # s for which the cue is shown after the strike
SHADOW = 0.5  # m by which the shadow of a ball is displaced, per m of height
GIF_COLOURS = 64  # of a GIF


def write_video(
    shot: Shot,
    path: Path,
    title: str = '',
    report: Callable[[int], None] = lambda done: None,
) -> None:
    """
    Write a shot as a video, seen from above, in real time.

    Parameters
    ----------
    shot : Shot
    path : Path
        Ends with `.gif` or `.mp4`.
    title : str
        Title of the pictures; by default a summary of the shot.
    report : callable
        Called with the number of images written, of `len(image_times(shot))`.

    Raises
    ------
    ValueError
        If the shot was refused, if the file has another ending, if matplotlib (or imageio for an
        MP4) is missing, or if the file cannot be written.

    """
    require_encoder(path)
    if shot.status.refused:
        raise ValueError(f'{path}: not written: {shot.status.name}: {shot.message}')
    times = image_times(shot)

    def draw(times: NDArray[np.float64]) -> Iterator[NDArray[np.uint8]]:
        for done, image in enumerate(images(shot, times, title), 1):
            yield image
            report(done)

    try:
        WRITERS[path.suffix](path, times, draw)
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None


def _write_gif(path: Path, times: NDArray[np.float64], draw: Draw) -> None:
    """Write with one palette for all images, so that they differ only where something moves."""
    from PIL import Image

    palette = Image.fromarray(next(draw(times[-1:]))).quantize(GIF_COLOURS)  # all paths are in it
    pictures = (
        Image.fromarray(each).quantize(palette=palette, dither=Image.Dither.NONE)
        for each in draw(times)
    )
    next(pictures).save(path, save_all=True, append_images=pictures, duration=1000 // RATE, loop=0)


def _write_mp4(path: Path, times: NDArray[np.float64], draw: Draw) -> None:
    import imageio

    writer: Any
    with imageio.get_writer(path, fps=RATE) as writer:
        for image in draw(times):
            writer.append_data(image)


WRITERS = {'.gif': _write_gif, '.mp4': _write_mp4}


def require_encoder(path: Path) -> None:
    """Raise ValueError, with the command that installs it, if the encoder of a file is missing."""
    if path.suffix not in WRITERS:
        raise ValueError(f'video must be a file {" or ".join(WRITERS)}, got {path}')
    require_matplotlib()  # matplotlib depends on Pillow, which writes a GIF
    if path.suffix == '.mp4':
        try:
            import imageio  # noqa: F401
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            raise ValueError(
                "video: .mp4 needs imageio, an extra: pip install 'billiard_shot[video]'"
            ) from None


def images(shot: Shot, times: NDArray[np.float64], title: str = '') -> Iterator[NDArray[np.uint8]]:
    """
    Draw a shot at some times.

    Parameters
    ----------
    shot : Shot
    times : (n,) float array
        [s]; the strike is at 0.
    title : str
        Title of the pictures; by default a summary of the shot.

    Yields
    ------
    (height, width, 3) uint8 array
        Red, green and blue.

    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    trails = trails_of(shot)
    figure, axes = table_axes(shot.scene, trails.all_points(), title or shot_title(shot))
    block = BLOCK / VIDEO_DPI  # inches
    figure.set_size_inches(np.round(figure.get_size_inches() / block) * block)
    figure.set_dpi(VIDEO_DPI)
    canvas: Any = FigureCanvasAgg(figure)  # not typed
    moving = _Moving(axes, shot, trails)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)  # drawn once: the table does not change
    for time in times.tolist():
        canvas.restore_region(background)
        moving.draw(time)
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def image_times(shot: Shot) -> NDArray[np.float64]:
    """Choose times (n,) [s] from the beginning of the cue's motion until after the last motion."""
    trails = trails_of(shot)
    begin, end = -cue_motion(shot, trails).time, trails.until + END_SHOWN
    return begin + np.arange(math.ceil((end - begin) * RATE) + 1) / RATE


class _Moving:
    """All moving things, as animated artists: canvas.draw() leaves them out."""

    def __init__(self, axes: Any, shot: Shot, trails: Trails) -> None:
        from matplotlib.patches import Circle

        self.axes, self.trails = axes, trails
        starts = {name: trails.start(name) for name in trails.balls}
        self.starts = starts
        self.balls = draw_balls(axes, shot.scene, starts)
        for name in [name for name in starts if not trails.moved(name)]:
            del self.balls[name]  # drawn once, with the table
        radius = shot.scene.ball.radius
        self.shadows = {
            name: axes.add_patch(
                Circle(tuple(start[:2]), radius, color=BLACK, alpha=0.3, zorder=3.9)
            )
            for name, start in starts.items()
            if name in self.balls
        }
        self.cue = draw_cue(axes, shot.scene, shot.stroke, starts[CUE_BALL])
        self.cue_motion = cue_motion(shot, trails)
        self.paths = {
            name: axes.plot(
                [], [], color=colour, linewidth=0.6 if colour == PALE_PATH else 1.5, zorder=3
            )[0]
            for name, colour in path_colours(trails, MOVING_COLOURS, PALE_PATH).items()
        }
        pieces = {name: trails.pieces(name) for name in self.paths}
        self.points = {
            name: (
                np.concatenate([np.zeros(0), *(piece.times for piece in of_ball)]),
                np.concatenate([np.zeros((0, 3)), *(piece.points for piece in of_ball)]),
            )
            for name, of_ball in pieces.items()
        }
        self.clock = axes.text(
            0.995, 0.99, '', transform=axes.transAxes, ha='right', va='top', fontsize='small'
        )
        every = [*self.shadows.values(), *self.paths.values(), *self.cue, self.clock]
        for artist in [*every, *(part for ball in self.balls.values() for part in ball)]:
            artist.set_animated(True)

    def draw(self, time: float) -> None:
        """Draw all moving things at their places at a time [s]."""
        for name, line in self.paths.items():
            times, points = self.points[name]
            past = points[: int(np.searchsorted(times, time)), :2]
            if 0 < len(past) < len(points):  # between two points, the path ends at the ball
                past = np.vstack([past, self.trails.balls[name].at(time).position[:2]])
            line.set_data(past[:, 0], past[:, 1])
            self.axes.draw_artist(line)
        for name, artists in self.balls.items():
            state = self.trails.balls[name].at(max(time, 0.0))
            if Motion(int(state.motion)) in OFF_CLOTH:
                continue
            height = state.position[2] - self.starts[name][2]
            away = state.position - self.starts[name]
            self._draw(self.shadows[name], away[:2] + SHADOW * height * np.array([1.0, -1.0]))
            for artist in artists:
                self._draw(artist, away[:2])
        if time < FOLLOW:
            for artist in self.cue:
                self._draw(artist, self.cue_motion.way(time)[:2])
        self.clock.set_text(f'{max(time, 0.0):.2f} s')
        self.axes.draw_artist(self.clock)

    def _draw(self, artist: Any, away: NDArray[np.float64]) -> None:
        """Draw an artist that is displaced by (2,) [m]."""
        from matplotlib.transforms import Affine2D

        artist.set_transform(Affine2D().translate(*away) + self.axes.transData)
        self.axes.draw_artist(artist)
