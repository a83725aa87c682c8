"""
The table from above: cushions and pockets, paths by kind of motion, events, ghost balls, the cue.

`table_axes`, `draw_table`, `draw_balls`, `draw_trails` and `draw_cue` draw one thing each onto
axes, for pictures with more on them; `draw_shot` is all of them in one file. `write_video` makes
a GIF or an MP4 of a shot, in real time.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
import math
from pathlib import Path
import textwrap
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.pictures.canvas import (
    add_legend,
    ball_colour,
    BLACK,
    BLUE,
    GREEN,
    GREY,
    is_striped,
    new_figure,
    ORANGE,
    PURPLE,
    require_matplotlib,
    save,
    VERMILION,
)
from billiard_shot.pictures.trails import cue_motion, OFF_CLOTH, path_colours, Trails, trails_of
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import reason
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import ball_in_words, EventKind

CLOTH_COLOUR, CUSHION_COLOUR, WOOD_COLOUR, HOLE_COLOUR = '#dfeae3', '#b7cfc0', '#c9ad8c', '#3b3b3b'
PICTURE_WIDTH = 9.0  # inches of a picture
MOTION_VERBS = {Motion.ROLL: 'rolls', Motion.SLIDE: 'slides', Motion.FLIGHT: 'flies'}
# As on the page of `view`.
DASHES = {Motion.ROLL: '-', Motion.SLIDE: (0, (3.5, 1.2)), Motion.FLIGHT: (0, (1.0, 1.0))}
# Colours of paths, that of the cue ball first. If more balls move, the rest is grey and thin.
MOVING_COLOURS = BLACK, VERMILION, BLUE, PURPLE, ORANGE, GREEN
PALE_PATH = '#9fb3a7'
MARKS = {  # marker, label
    EventKind.CUSHION: ('s', 'cushion'),
    EventKind.BALL: ('X', 'meets a ball'),
    EventKind.CLUSTER: ('X', 'meets a ball'),
    EventKind.POCKET: ('D', 'falls'),
    EventKind.OFF: ('^', 'leaves the table'),
    EventKind.CUE: ('*', 'is hit again'),
}
CUE_COLOUR = '#8a5a2b'
TITLE = 100  # characters of a line of the title
ENDLESS_CLOTH_MARGIN = 0.15  # m around the paths on an endless cloth


def table_axes(scene: Scene, points: ArrayLike = (), title: str = '') -> tuple[Any, Any]:
    """
    Make a figure of a scene's table, or of its endless cloth, to draw on.

    Parameters
    ----------
    scene : Scene
    points : (n, 2) array_like
        Points that have to be in view on an endless cloth [m], besides the scene's balls.
    title : str

    Returns
    -------
    figure, axes : matplotlib Figure, Axes

    Raises
    ------
    ValueError
        If matplotlib is missing, with the command that installs it.

    """
    if scene.table is not None:
        half = outline_of(scene).frame
        low, high = -half, half
    else:
        balls = np.array([scene.cue_ball[:2], *scene.balls.values()])
        seen = np.concatenate([balls, np.reshape(points, (-1, 2))])
        low, high = (
            seen.min(axis=0) - ENDLESS_CLOTH_MARGIN,
            seen.max(axis=0) + ENDLESS_CLOTH_MARGIN,
        )
        least = 0.3 * (high - low).max()  # a picture of a straight line has some height, too
        grow = np.maximum(least - (high - low), 0.0) / 2.0
        low, high = low - grow, high + grow
    size = high - low
    height = float(np.clip(PICTURE_WIDTH * size[1] / size[0], 2.0, PICTURE_WIDTH))
    figure = new_figure(PICTURE_WIDTH, height + 0.9)
    axes = figure.subplots()
    axes.set(
        xlim=(low[0], high[0]),
        ylim=(low[1], high[1]),
        aspect='equal',
        xlabel='x (m)',
        ylabel='y (m)',
    )
    axes.tick_params(labelsize='small')
    if title:
        axes.set_title(title, fontsize='medium', loc='left')
    draw_table(axes, scene)
    return figure, axes


def draw_table(axes: Any, scene: Scene) -> None:
    """Draw cloth, cushions and pockets; for a scene without a table, the cloth."""
    from matplotlib.patches import Circle, Polygon, Rectangle

    if scene.table is None:
        axes.set_facecolor(CLOTH_COLOUR)
        axes.grid(color='white', linewidth=0.8)
        axes.set_axisbelow(True)
        return
    table = outline_of(scene)
    for half, colour in ((table.frame, WOOD_COLOUR), (table.back, CLOTH_COLOUR)):
        x, y = half
        axes.add_patch(Rectangle((-x, -y), 2.0 * x, 2.0 * y, color=colour, linewidth=0, zorder=0))
    for x, y, radius in table.holes:
        axes.add_patch(Circle((x, y), radius, color=HOLE_COLOUR, linewidth=0, zorder=0.2))
    for cushion in table.cushions:
        axes.add_patch(
            Polygon(
                cushion, facecolor=CUSHION_COLOUR, edgecolor='#6f9080', linewidth=0.6, zorder=0.3
            )
        )


def draw_balls(
    axes: Any, scene: Scene, places: Mapping[str, ArrayLike], *, faint: bool = False
) -> dict[str, list[Any]]:
    """
    Draw balls at their places, by name: (2,) or (3,) [m]; `faint` draws them pale.

    Returns the matplotlib artists of each ball.
    """
    from matplotlib.patches import Circle

    radius = scene.ball.radius
    artists: dict[str, list[Any]] = {}
    for name, place in places.items():
        x, y = np.asarray(place, float)[:2]
        look = {'alpha': 0.35, 'linewidth': 0.5} if faint else {'linewidth': 0.6}
        face = Circle(
            (x, y),
            radius,
            facecolor=ball_colour(name),
            edgecolor='black',
            zorder=2 if faint else 4,
            **look,
        )
        artists[name] = [axes.add_patch(face)]
        if name.isdecimal():
            spot = 0.78 if is_striped(name) else 0.6
            above = 2.1 if faint else 4.1
            disc = Circle((x, y), spot * radius, color='white', linewidth=0, zorder=above)
            number = axes.text(
                x, y, name, ha='center', va='center_baseline', fontsize=4.5, zorder=above + 0.1
            )
            artists[name] += [axes.add_patch(disc), number]
    return artists


def draw_trails(axes: Any, trails: Trails) -> None:
    """Draw the paths of balls, events on the way, and ghost balls: a colour for each ball."""
    from matplotlib.patches import Circle

    colours = path_colours(trails, MOVING_COLOURS, PALE_PATH)
    styles: dict[str, Any] = {}  # that occur, for the legend
    for name, colour in colours.items():
        pale = colour == PALE_PATH
        axes.plot([], [], color=colour, linewidth=1.5, label=_label(name, pale))
        for piece in trails.pieces(name):
            if piece.motion not in MOTION_VERBS:
                continue  # it spins in place
            styles[MOTION_VERBS[piece.motion]] = DASHES[piece.motion]
            axes.plot(
                piece.points[:, 0],
                piece.points[:, 1],
                linestyle=DASHES[piece.motion],
                color=colour,
                linewidth=0.6 if pale else 1.5,
                zorder=2.5 if pale else 3,
                solid_capstyle='butt',
            )
    for label in MOTION_VERBS.values():
        if label in styles:
            axes.plot([], [], linestyle=styles[label], color=GREY, linewidth=1.5, label=label)
    for event in trails.run.events:
        colour = colours.get(event.balls[0], PALE_PATH)
        if event.kind in MARKS and colour != PALE_PATH:
            marker, label = MARKS[event.kind]
            axes.plot(
                *event.position[:2],
                marker,
                color=colour,
                markersize=4.5,
                markeredgecolor='white',
                markeredgewidth=0.5,
                linestyle='',
                zorder=3.8,
            )
            axes.plot([], [], marker, color=GREY, markersize=4.5, linestyle='', label=label)
    for x, y, _ in trails.ghosts:
        axes.add_patch(
            Circle(
                (x, y),
                trails.scene.ball.radius,
                fill=False,
                linestyle='--',
                edgecolor=BLACK,
                linewidth=0.8,
                zorder=3.5,
            )
        )
    if trails.ghosts:
        axes.plot(
            [],
            [],
            'o',
            markersize=8,
            fillstyle='none',
            color=BLACK,
            linestyle='',
            label='ghost ball',
        )


def draw_start_and_rest(axes: Any, trails: Trails) -> None:
    """Draw balls where they rest, and pale ones, with their names, where they started."""
    draw_balls(axes, trails.scene, {n: trails.start(n) for n in _moved(trails)}, faint=True)
    _name_starts(axes, trails)
    ends = {name: trails.end(name) for name in trails.balls}
    draw_balls(axes, trails.scene, {name: end for name, end in ends.items() if end is not None})


def _label(name: str, pale: bool) -> str:
    return 'other balls' if pale else ball_in_words(name)


def draw_cue(axes: Any, scene: Scene, stroke: Stroke, place: ArrayLike) -> list[Any]:
    """
    Draw the cue as it meets the ball whose centre is at `place` (2,) or (3,) [m].

    Returns the matplotlib artists.
    """
    from matplotlib.patches import Polygon

    x, y, _ = np.asarray(stroke.velocity) / stroke.speed
    tip = np.asarray(place, float)[:2] + scene.ball.radius * np.array(stroke.normal[:2])
    length = (scene.cue.length or 1.4) * math.hypot(x, y)
    artists = axes.plot(
        *tip,
        'o',
        color=CUE_COLOUR,
        markersize=3,
        markeredgecolor='black',
        markeredgewidth=0.4,
        zorder=6.1,
    )
    if length < scene.ball.radius:
        return list(artists)  # vertical: from above, only the tip is visible
    butt = tip - length * _unit(x, y)
    aside = np.array([-1.0, 1.0]) * _unit(x, y)[::-1]
    wide = np.array([0.0065, 0.0145])  # m, half the width of a usual cue at its ends
    corners = [
        tip + wide[0] * aside,
        butt + wide[1] * aside,
        butt - wide[1] * aside,
        tip - wide[0] * aside,
    ]
    stick = Polygon(corners, facecolor=CUE_COLOUR, edgecolor='black', linewidth=0.4, zorder=6)
    return [*artists, axes.add_patch(stick)]


def draw_shot(shot: Shot, path: Path, title: str = '') -> None:
    """
    Write a picture of a shot's table from above; the default `title` summarises the shot.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    save(shot_figure(shot, title), path)


def shot_figure(shot: Shot, title: str = '') -> Any:
    """Draw a shot's table from above; the default `title` summarises the shot."""
    trails = trails_of(shot)
    figure, axes = table_axes(shot.scene, trails.all_points(), title or shot_title(shot))
    draw_trails(axes, trails)
    draw_start_and_rest(axes, trails)
    draw_cue(axes, shot.scene, shot.stroke, trails.start(CUE_BALL))
    add_legend(figure, axes)
    return figure


def shot_title(shot: Shot) -> str:
    """Say what happened, in lines that fit a picture."""
    trouble = '' if shot.status == Status.OK else f'{shot.status.name}: '
    return textwrap.fill(f'{trouble}{shot.message[0].upper()}{shot.message[1:]}', TITLE)


def _name_starts(axes: Any, trails: Trails) -> None:
    """Write the names of balls without a number beside their first places; of many, the cue's."""
    named = [name for name in _moved(trails) if not name.isdecimal()]
    for name in named if len(named) <= len(MOVING_COLOURS) else [CUE_BALL]:
        x, y, _ = trails.start(name)
        way = [piece.points[-1][:2] - (x, y) for piece in trails.pieces(name)]
        along = next((_unit(*each) for each in way if each.any()), np.array([1.0, 0.0]))
        axes.annotate(
            name,
            (x, y),
            11.0 * np.array([-along[1], along[0]]),  # beside the path
            textcoords='offset points',
            ha='center',
            va='center',
            fontsize='x-small',
            zorder=6.5,
        )


def _moved(trails: Trails) -> Iterable[str]:
    return (name for name in trails.balls if trails.moved(name))


def _unit(x: float, y: float) -> NDArray[np.float64]:
    return np.array([x, y]) / math.hypot(x, y)


Draw = Callable[[NDArray[np.float64]], Iterator[NDArray[np.uint8]]]

RATE = 25  # images per second
VIDEO_DPI = 100.0
BLOCK = 16  # pixels: encoders of MP4 want multiples of it
END_SHOWN = 1.0  # s for which the end is shown
FOLLOW = 0.25  # s for which the cue is shown after the strike
SHADOW = 0.5  # m by which the shadow of a ball is displaced, per m of height
GIF_COLOURS = 64  # of a GIF


def write_video(
    shot: Shot, path: Path, title: str = '', report: Callable[[int], None] = lambda done: None
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
