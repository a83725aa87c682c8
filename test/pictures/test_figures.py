"""The data behind the pictures, against the values that the paper and its notes state."""

from importlib import import_module
import inspect
from itertools import pairwise
import json
import math
from pathlib import Path
import pkgutil
import re
import sys

import numpy as np
import pytest

from billiard_shot import pictures, predict, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.pictures.history import (
    collision_figure,
    draw_collision,
    grip_of,
    history_of,
    trace_of_collision,
    trace_of_strike,
)
from billiard_shot.pictures.trails import trails_of
from billiard_shot.pictures.view import view_data
from billiard_shot.table.run.results import EventKind, TableRun
import studies
from studies import figures, laws
from studies.collisions import stacked
from studies.figures import around, combination, english, FIGURES, jump, masse
from studies.impulse import draw_ping_pong, draw_two_balls
from studies.paper_shots import paper_shot, turn_to_roll
from studies.two_balls import normal_impulses, PING_PONG, TwoBalls

FIG4 = TwoBalls()
LOST = re.compile(r', (-?[.\d]+) J of [.\d]+ J are lost')
NUMBER = re.compile(r'−?\d+\.\d{4}')
TRACE = FIG4.trace()
STATES = FIG4.states(TRACE)


def test_states_of_fig_4():
    assert [state.name for state in STATES] == ['S1', 'S3', 'S1', 'S2']
    assert STATES[0].events == 'C2-C1-R2'  # in the paper's table (b)
    ends = np.array([normal_impulses(TRACE)[state.samples][-1] for state in STATES])
    assert ends == pytest.approx(
        np.array([[3.60879, 3.96612], [3.96612, 3.96612], [5.44136, 5.32023], [5.44136, 6.17691]]),
        abs=2e-5,
    )
    assert FIG4.velocities(ends[-1:])[0] == pytest.approx([2.441360, 0.735552], abs=2e-6)
    lost = FIG4.kinetic_energy([[0, 0]]) - FIG4.kinetic_energy(ends[-1:])
    assert lost == pytest.approx(1.249363, abs=2e-6)


def test_energies_of_fig_4():
    """Losses add up to what is missing; springs hold what the motion has lost (equation 14)."""
    lost = sum(
        TRACE.energies[part.stop - 1, j]
        for part in TRACE.phases()
        for j in (0, 1)
        if TRACE.active[part.stop - 1, j]
        and (part.stop == len(TRACE.time) or not TRACE.active[part.stop, j])
    )
    assert lost == pytest.approx(1.249363, abs=2e-6)
    first = STATES[0].samples
    total = TRACE.energies[first].sum(axis=1) + FIG4.kinetic_energy(normal_impulses(TRACE)[first])
    assert total == pytest.approx(np.full(len(total), 4.5), abs=1e-6)


def test_the_impulse_curve_stays_in_its_ellipse_and_turns_at_the_lines():
    ellipse = FIG4.ellipse()
    assert FIG4.kinetic_energy(ellipse) == pytest.approx(np.full(len(ellipse), 4.5))
    assert ellipse.max(axis=0) == pytest.approx([6.0, 3.0 * (1 + math.sqrt(2))], abs=1e-3)
    curve = normal_impulses(TRACE)
    assert (FIG4.kinetic_energy(curve) <= 4.5 + 1e-9).all()
    assert (np.diff(curve, axis=0) >= -1e-12).all()
    on1, on2 = FIG4.compression_lines(curve[:, 0])
    assert TRACE.velocities[:, 0] == pytest.approx(on1 - curve[:, 1], abs=1e-6)
    assert TRACE.velocities[:, 3] == pytest.approx(curve[:, 1] - on2, abs=1e-6)


@pytest.mark.parametrize(
    ('law', 'velocities'), [('energetic', (0.7794, 0.1866)), ('bistiffness', (0.8017, 0.1154))]
)
def test_ping_pong(law, velocities):
    for v0 in (-1.0, -3.5):
        outcome = TwoBalls(restitution=PING_PONG, v0=v0, law=law).outcome()
        assert np.array(outcome) / -v0 == pytest.approx(velocities, abs=5e-5)


@pytest.mark.parametrize(
    ('masses', 'law'),
    [((1.0, 2.0), 'bistiffness'), ((3.0, 0.5), 'poisson'), ((0.3, 1.0), 'energetic')],
)
def test_a_watched_collision_is_the_one_that_is_solved(masses, law):
    balls = TwoBalls(masses=masses, law=law, restitution=(0.7, 0.8))
    end = balls.velocities(normal_impulses(balls.trace())[-1:])[0]
    assert end == pytest.approx(balls.outcome(), abs=1e-6)


def texts_of(path):
    """Texts of a picture in SVG, in the order in which they were drawn."""
    return re.findall(r'<!-- (.*?) -->', path.read_text())


@pytest.mark.parametrize('law', ['bistiffness', 'poisson', 'energetic'])
def test_losses_in_the_legend_add_up_to_the_loss_in_the_title(law, tmp_path):
    balls = TwoBalls(law=law)
    path = tmp_path / 'balls.svg'
    draw_two_balls(balls, path)
    texts = texts_of(path)
    kinetic = balls.kinetic_energy(normal_impulses(balls.trace())[[0, -1]])
    (title,) = (float(each[1]) for text in texts if (each := LOST.search(text)))
    assert title == pytest.approx(kinetic[0] - kinetic[1], abs=1e-4)
    legends = [re.findall(r'([-.\d]+) J', text) for text in texts if 'loses' in text]
    assert len(legends) == 2
    assert sum(float(each) for losses in legends for each in losses) == pytest.approx(
        title, abs=2e-3
    )


@pytest.mark.parametrize('law', ['bistiffness', 'poisson', 'energetic'])
def test_the_table_of_two_balls_ends_with_the_outcome(law, tmp_path):
    balls = TwoBalls(law=law)
    path = tmp_path / 'balls.svg'
    draw_two_balls(balls, path)
    texts = texts_of(path)
    last = len(texts) - 1 - next(i for i, each in enumerate(reversed(texts)) if '(c) at' in each)
    numbers = [float(each.replace('−', '-')) for each in texts[:last] if NUMBER.fullmatch(each)]
    *_, v1, v2, e1, e2, kinetic = numbers
    assert (v1, v2) == pytest.approx(balls.outcome(), abs=2e-4)
    assert (e1, e2) == pytest.approx(TwoBalls(law=law).trace().energies[-1], abs=1e-3)
    assert kinetic == pytest.approx(0.5 * (v1 * v1 + v2 * v2), abs=1e-3)


def test_ping_pong_numbers_in_the_picture(tmp_path):
    path = tmp_path / 'balls.svg'
    draw_ping_pong(path)
    texts = ' '.join(texts_of(path))
    for law in ('energetic', 'bistiffness'):
        upper, lower = TwoBalls(restitution=PING_PONG, v0=-1.0, law=law).outcome()
        for name, part in (('upper', upper), ('lower', lower)):
            assert f'{name} ball, {law}: {part:.4f} |v₀|' in texts


def test_titles_of_figures_state_what_the_shots_do():
    """Nearly half of the energy falls with the 8; the tip sticks, or presses three times."""
    history = history_of(trails_of(combination()))
    total = history.translation + history.rotation + history.height
    falls = next(each.time for each in combination().run.events if each.kind == EventKind.POCKET)
    lost = np.interp([falls - 1e-4, falls + 1e-4], history.time, total)
    assert 0.4 < (lost[0] - lost[1]) / total[0] < 0.5
    assert not english().miscue
    assert english().stroke.speed == pytest.approx(3.0)
    assert english().impact.phases[-1].active == (1,)
    assert f'{masse().stroke.speed:.1f}' == '16.5'
    tip = [0 in phase.active for phase in masse().impact.phases]
    assert sum(now and not before for before, now in pairwise([False, *tip])) == 3
    assert f'{math.degrees(jump().stroke.offsets[2]):.0f}' == '40'
    assert around().stroke.offsets[2] == pytest.approx(math.radians(50))


def test_the_home_page_shows_the_shot_of_its_command(tmp_path, monkeypatch):
    text = (Path(__file__).parents[2] / 'docs' / 'index.md').read_text()
    assert 'figures/table-jump.png' in text
    monkeypatch.chdir(tmp_path)
    command = re.search(r'^billiard-shot (view .*)$', text, re.MULTILINE)[1]
    assert main(command.split()) == 0
    page = (tmp_path / 'shot.html').read_text()
    data = json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', page)[1])
    assert data['start'] == json.loads(json.dumps(view_data(jump(), '')['start']))


# Traces leave the shaft out, and bodies stay in place.
FREE_END = Scene.from_dict({'like': 'pool', 'law': 'energetic', 'effects': {'shaft': 'off'}})


@pytest.mark.parametrize('shot', [masse(), predict(FREE_END, english().stroke)])
def test_a_watched_strike_is_the_one_that_is_predicted(shot):
    trace = trace_of_strike(shot)
    phases = shot.impact.phases
    parts = trace.phases()
    assert [np.flatnonzero(trace.active[part][0]).tolist() for part in parts] == [
        list(phase.active) for phase in phases
    ]
    for part, phase in zip(parts, phases, strict=True):
        normal = trace.impulses[part][-1][[0, 3]]
        stated = np.abs([phase.impulses[0] @ shot.stroke.normal, phase.impulses[1][2]])
        assert normal == pytest.approx(stated, abs=1e-5 * stated.max())
        assert trace.energies[part][-1] == pytest.approx(
            phase.energies, abs=1e-5 * phase.energies.max() + 1e-12
        )
    assert (np.diff(trace.time) >= 0.0).all()


def test_forces_are_the_slope_of_impulses_and_friction_obeys_coulomb():
    shot = masse()
    trace = trace_of_strike(shot)
    for part in trace.phases():
        time = trace.time[part]
        area = np.cumsum(
            0.5 * np.diff(time)[:, None] * (trace.forces[part][1:] + trace.forces[part][:-1]),
            axis=0,
        )
        gained = trace.impulses[part][1:] - trace.impulses[part][0]
        assert area == pytest.approx(gained, abs=2e-3 * np.abs(trace.impulses).max())
    for j, friction in enumerate((0.4, 0.152479)):
        grip = grip_of(trace, j, friction)
        seen = ~np.isnan(grip)
        slides = trace.slip(j) > 1e-3
        assert (grip[seen] <= 1.0 + 1e-4).all()
        assert grip[seen & slides] == pytest.approx(np.ones((seen & slides).sum()), abs=1e-4)
        assert (grip[seen & ~slides] < 0.99).any()


def test_strikes_that_cannot_be_watched():
    for shot in (
        predict(Scene.load('pool'), Stroke((1, 0, 0), (1, 0, 0))),
        predict(
            Scene.from_dict({'like': 'pool', 'balls': {'1': [0.05715, 0]}}),
            Stroke.from_offsets(0, 0, 0.1, 0, 1),
        ),
    ):
        with pytest.raises(ValueError, match=r'shot must be a stroke that can be played'):
            trace_of_strike(shot)


def test_exponent_of_hertz_is_watched_too():
    hertz = stacked(exponent=1.5, speed=3.0)
    end = trace_of_collision(hertz.bodies, hertz.contacts, 'energetic', 1.5).impulses[-1]
    assert end[[0, 3]] == pytest.approx(hertz.solve('energetic', 1e-10).impulses[:, 2], abs=1e-6)
    assert end[0] != pytest.approx(TRACE.impulses[-1, 0], abs=1e-3)


@pytest.mark.parametrize(
    ('name', 'velocity', 'spin'),
    [
        ('vertical', (0.4291079, 0.8582159), (31.633515, -15.816758, 0)),
        ('horizontal', (0.6335673, 0.4653476), (0, 0, 10.3976629)),
        ('massé', (1.3024731, 0.7322053), (10.401821, -35.756185, -1.202481)),
    ],
)
def test_table_1(name, velocity, spin):
    """Where the ball begins to roll follows from the reference rows, after Coulomb's law."""
    row = paper_shot(name)
    shot = row.shot
    assert shot.velocity[:2] == pytest.approx(velocity, abs=1e-6)
    assert shot.spin == pytest.approx(spin, abs=1e-5)
    scene = shot.scene
    r, g, mu = scene.ball.radius, scene.cloth.gravity, scene.contacts.ball_table.friction
    v, w = np.array(velocity), np.array(spin)
    slip = v - r * np.array([w[1], -w[0]])
    time = 2 * np.hypot(*slip) / (7 * mu * g)
    place = v * time - 0.5 * mu * g * slip / np.hypot(*slip) * time**2
    assert turn_to_roll(row.computed) == pytest.approx(place, abs=2e-6)
    assert row.printed.start('cue')[:2] == pytest.approx((0, 0))
    assert len(row.computed.pieces('cue')) == 2  # slides, rolls: the ball stays on the cloth


def test_histories():
    shot = combination()
    history = history_of(trails_of(shot))
    total = history.translation + history.rotation + history.height
    kinds = EventKind.CUSHION, EventKind.CLUSTER
    hits = [event.time for event in shot.run.events if event.kind in kinds]
    pressed = [(t <= history.time) & (history.time <= t + 6e-3) for t in hits]
    lasting = total[~np.any(pressed, axis=0)]  # springs keep some of the energy
    assert (np.diff(lasting) <= 1e-9 * total[0]).all()  # never gains
    start = 0.5 * (
        shot.scene.ball.mass * shot.velocity @ shot.velocity
        + shot.scene.ball.inertia * shot.spin @ shot.spin
    )
    assert total[0] == pytest.approx(start)
    assert total[-1] == pytest.approx(0.0, abs=1e-12)
    motion = shot.run.balls['cue'].at(history.time).motion
    rolls = motion == 2
    assert history.rims['cue'][rolls] == pytest.approx(history.speeds['cue'][rolls], abs=1e-9)
    assert set(history.speeds) == {'cue', '1', '8'}


def test_the_shots_do_what_their_titles_say():
    for shot, met in ((combination(), '1'), (jump(), '8'), (around(), '8')):
        assert isinstance(shot.run, TableRun)
        assert shot.run.first_met['cue'] == met
        assert '8' in shot.run.pocketed
        assert 'cue' not in shot.run.pocketed
    over = jump().trajectory
    x = over.at(np.linspace(0, 0.5, 2000)).position
    assert x[np.argmin(np.abs(x[:, 0])), 2] > 3 * jump().scene.ball.radius
    assert (around().trajectory.at(np.linspace(0.02, 0.3, 100)).motion == 1).any()


def test_all_figures_come_out(tmp_path, capsys):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    assert figures.main(['--output', str(tmp_path)]) == 0
    out = capsys.readouterr().out.split()
    assert out == [str(tmp_path / f'{name}.png') for name in FIGURES]
    for path in tmp_path.iterdir():
        assert path.read_bytes().startswith(b'\x89PNG')
        assert path.stat().st_size > 20_000


def test_command_says_what_is_wrong(tmp_path, capsys):
    assert figures.main(['--list']) == 0
    assert capsys.readouterr().out.split() == list(FIGURES)
    assert figures.main(['brake']) == 2
    assert 'NAME must be one of impulse-plane, ' in (capsys.readouterr().err)
    (tmp_path / 'file').write_text('')
    assert figures.main(['-o', str(tmp_path / 'file')]) == 2
    assert '--output: ' in capsys.readouterr().err


def test_command_in_an_empty_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert figures.main(['ping-pong']) == 0
    assert (tmp_path / capsys.readouterr().out.strip()).read_bytes().startswith(b'\x89PNG')


@pytest.mark.parametrize(
    'words',
    [
        ['study', 'accuracy'],
        ['map', 'blocked', '--ball', '8'],
        ['study', 'effects'],
        ['plan', 'blocked', '--pot', '8'],
        ['predict', '--speed', '2'],
    ],
    ids=lambda words: words[0],
)
def test_without_matplotlib_a_command_says_what_is_missing_before_it_works(
    words, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, 'matplotlib.figure', None)
    assert main([*words, '--picture', 'x.png']) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert "pip install 'billiard_shot[plot]'" in err


def test_a_picture_that_cannot_be_written(tmp_path, capsys):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    wrong = tmp_path / 'none' / 'laws.png'
    assert laws.main(['--count', '5', '--picture', str(wrong)]) == 2
    assert f'--picture must be in a folder that exists, got {wrong}' in capsys.readouterr().err


def test_a_collision_of_ones_own(tmp_path):
    """The curves end at the impulses of `collide`, and nothing is drawn if nothing collides."""
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    collision = stacked((1.0, 1.0), (0.9**0.5, 0.4**0.5), 10.0, 3.0)
    result = collision.solve('energetic', 1e-10)
    figure = collision_figure(collision.bodies, collision.contacts, 'energetic')
    impulses, energies = figure.axes
    for j, line in enumerate(impulses.get_lines()):
        assert line.get_ydata()[-1] == pytest.approx(result.impulses[j, 2], rel=1e-6)
    lost = [float(line.get_label().split()[1]) for line in energies.get_lines()]
    assert lost == pytest.approx(result.dissipated[:, 0], rel=5e-3)
    draw_collision(collision.bodies, collision.contacts, tmp_path / 'x.png', law='energetic')
    assert (tmp_path / 'x.png').stat().st_size > 1000
    with pytest.raises(ValueError, match='one must approach'):
        draw_collision(collision.bodies[1:], [], tmp_path / 'y.png')


def test_draw_functions_take_what_they_draw_then_the_path_then_the_title():
    found = 0
    for module in (
        *pkgutil.iter_modules(pictures.__path__, f'{pictures.__name__}.'),
        *pkgutil.iter_modules(studies.__path__, f'{studies.__name__}.'),
    ):
        for name, function in vars(import_module(module.name)).items():
            if not name.startswith('draw_') or function.__module__ != module.name:
                continue
            arguments = inspect.signature(function).parameters.values()
            names = [each.name for each in arguments if each.kind is not each.KEYWORD_ONLY]
            if 'path' in names:
                found += 1
                place = names.index('path')
                assert names[place + 1 :] in ([], ['title'], ['about']), name
                assert not {'title', 'about'} & {*names[:place]}, name
    assert found > 10
