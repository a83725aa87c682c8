"""What tip and shaft do: time of contact, squirt, spin and second hits, with published bands."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import add_legend, BLUE, GREY, new_figure, save, VERMILION
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.predict import predict, predict_batch
from billiard_shot.shot.stroke import Stroke

SPEEDS = 0.3 * np.geomspace(1.0, 8.0 / 0.3, 9)  # m/s
OFFSETS = np.linspace(0.0, 0.55, 12)  # radii
ELEVATIONS = np.arange(0.0, 80.0, 10.0)  # degrees
STROKES = 60  # for each elevation
# High-speed films, and measured squirt: Alciatore (billiards.colostate.edu).
FILMED = 1.0, 2.0  # ms that a leather tip touches the ball
SQUIRT = ((0.1, 0.35, 0.55), (0.3, 0.75, 1.6), (0.5, 1.6, 2.6))  # degrees at an offset [radii]
MISCUES = 0.5, 0.55  # radii, from which a chalked tip slips
SOFT = {
    'like': 'pool',
    'contacts': {'cue_ball': {'exponent': 1.5}},
    'effects': {'tip_spring': 'on'},
}


def draw_tip(path: Path) -> None:
    """
    Draw times of contact, squirt, spin and second hits of two models of the tip.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    figure = new_figure(10.0, 7.0)
    (speed, offset), (squirt, again) = figure.subplots(2, 2)
    for axis in (speed, offset):
        axis.axhspan(*FILMED, color=GREY, alpha=0.3, label='published')
        axis.set_ylim(0.0, 2.5)
        axis.set_ylabel('time that the tip touches the ball (ms)')
    for a, low, high in SQUIRT:
        squirt.plot([a, a], [low, high], color=GREY, linewidth=8, alpha=0.5)
    for axis in (offset, squirt):
        axis.axvspan(*MISCUES, color=GREY, alpha=0.3)
        axis.set_xlabel('offset to the side (radii), 2 m/s')
    models = (
        ('pool', Scene.load('pool'), BLUE),
        ('exponent 1.5, tip_spring', Scene.from_dict(SOFT), VERMILION),
    )
    for name, scene, colour in models:
        style = {'color': colour, 'label': name}
        speed.semilogx(SPEEDS, [_touched(scene, 0.0, v) for v in SPEEDS], **style)
        offset.plot(OFFSETS, [_touched(scene, a, 2.0) for a in OFFSETS], **style)
        batch = predict_batch(scene, offsets=_level(OFFSETS))
        x, y, _ = batch.velocity.T
        squirt.plot(OFFSETS, np.degrees(np.arctan2(y, x)), **style)
        spin = scene.ball.radius * np.abs(batch.spin[:, 2]) / np.hypot(x, y)
        squirt.plot(OFFSETS, spin, '--', color=colour)
        for least, most, line in ((0.0, 0.3, '-'), (0.3, 0.5, ':')):
            shares = [_share_hit_again(scene, least, most, each) for each in ELEVATIONS]
            again.plot(ELEVATIONS, shares, line, color=colour)
    speed.set_xticks([0.3, 1.0, 2.0, 4.0, 8.0], ['0.3', '1', '2', '4', '8'])
    speed.minorticks_off()
    speed.set_xlabel('speed of the cue (m/s), through the middle')
    squirt.set_ylim(0.0, 4.0)
    squirt.set_ylabel('squirt (degrees); dashed: spin, R ω / v')
    again.set_xlabel('elevation (degrees); offsets to .3 radii, dotted: .3 to .5')
    again.set_ylabel('strokes that hit the ball again (%)')
    add_legend(figure, speed)
    save(figure, path)


def _touched(scene: Scene, a: float, speed: float) -> float:
    """Time that the tip touches the ball in a level stroke [ms]."""
    return 1e3 * predict(scene, Stroke.from_offsets(a, 0.0, 0.0, 0.0, speed)).tip_time


def _level(offsets: Array) -> Array:
    """Level strokes at 2 m/s, as rows of `predict_batch`."""
    nothing = np.zeros_like(offsets)
    return np.column_stack([offsets, nothing, nothing, nothing, nothing + 2.0])


def _share_hit_again(scene: Scene, least: float, most: float, elevation: float) -> float:
    """Share of strokes whose tip meets the ball again [%], at offsets within two circles."""
    draw = np.random.default_rng(1)
    away, angle = draw.uniform(least, most, STROKES), draw.uniform(0.0, 2.0 * math.pi, STROKES)
    lift, speed = np.full(STROKES, math.radians(elevation)), draw.uniform(1.0, 3.0, STROKES)
    columns: Any = (away * np.cos(angle), away * np.sin(angle), lift, np.zeros(STROKES), speed)
    batch = predict_batch(scene, offsets=np.column_stack(columns))
    return 100.0 * float((batch.double_hit | batch.chatter)[~batch.refused].mean())
