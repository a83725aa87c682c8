"""The shots in README and docs do what the text around them says."""

from pathlib import Path
import re
import shlex

import numpy as np
import pytest
from test_docs import BLOCKS, FILES

from billiard_shot import aim, load_shot, predict
from billiard_shot.cli import main
from billiard_shot.planning.result import why_missed

RACKS = ('eight_ball', 'nine_ball', 'snooker')


@pytest.fixture
def shown(tmp_path, monkeypatch, capsys):
    """Return a function that plays a command of docs/recipes.md, by the name of its picture."""
    for name, text in FILES['recipes.md']:
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)

    def play(recipe):
        text = (Path(__file__).parents[1] / 'docs' / 'recipes.md').read_text()
        (block,) = re.findall(rf'```sh\n([^`]*recipe-{recipe}\.png)\n```', text)
        for line in block.splitlines():
            words = shlex.split(line.removeprefix('billiard-shot '))
            if '--picture' in words:
                del words[words.index('--picture') :]
            if words[0] == 'predict':
                words += ['-o', 'shot.json']
            assert main(words) == 0
        capsys.readouterr()
        return load_shot('shot.json')

    return play


def way_after_contact(shot):
    """How far the cue ball rests beyond the place of its first contact, along its way [m]."""
    event = next(event for event in shot.events if len(event.balls) > 1)
    contact = shot.trajectory.at(event.time).position[:2]
    along = contact - shot.trajectory.at(0.0).position[:2]
    away = shot.final_position['cue'][:2] - contact
    return float(away @ along) / float(np.hypot(*along))


@pytest.mark.parametrize(
    ('recipe', 'low', 'high'), [('stop', -0.01, 0.01), ('draw', -0.6, -0.4), ('follow', 0.3, 0.5)]
)
def test_straight_shots(shown, recipe, low, high):
    shot = shown(recipe)
    assert shot.pocketed == {'8': 'foot_left'}
    assert low < way_after_contact(shot) < high


def test_stun(shown):
    shot = shown('stun')
    assert shot.pocketed == {'8': 'foot_left'}
    time = next(event.time for event in shot.events if len(event.balls) > 1)
    state = shot.run.at(time + 0.1)
    cue, eight = state['cue'].velocity[:2], state['8'].velocity[:2]
    cosine = cue @ eight / np.hypot(*cue) / np.hypot(*eight)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(90.0, abs=5.0)


def test_side(shown):
    """The cue ball leaves along the line of aim; without the correction, the 8 does not fall."""
    shot = shown('side')
    assert shot.pocketed == {'8': 'foot_left'}
    aimed = aim(shot.scene, '8', pocket='foot_left', speed=2, a=0.3, b=-0.2)
    assert np.arctan2(*shot.velocity[1::-1]) == pytest.approx(aimed.offsets[3], abs=1e-6)
    assert why_missed(predict(shot.scene, aimed), '8', ['foot_left']).startswith(
        '8 beside foot left: thick by '
    )


def test_massé_and_jump(shown):
    for recipe, over in (('masse', False), ('jump', True)):
        shot = shown(recipe)
        assert shot.pocketed == {'8': 'foot_left'}
        assert shot.first_contact == '8'
        met = next(event.time for event in shot.events if len(event.balls) > 1)
        path = shot.trajectory.at(np.linspace(0.0, met, 2000)[:-1]).position
        beside = np.hypot(*(path[:, :2] - shot.scene.balls['1']).T).min()
        assert (beside < 2.0 * shot.scene.ball.radius) == over


def test_bank(shown):
    shot = shown('bank')
    assert shot.pocketed == {'8': 'side_left'}
    assert shot.stroke.speed == pytest.approx(2.0)
    assert ['8', 'right'] in [[*event.balls, event.place] for event in shot.events]


def commands_at_racks():
    command = re.compile(
        rf'^(?:\$ )?billiard-shot (?:predict|view) ((?:{"|".join(RACKS)}) .*)$', re.M
    )
    for page, _, language, text in BLOCKS:
        if language in ('sh', 'console'):
            for words in command.findall(text.replace('\\\n', ' ')):
                yield page, shlex.split(words, comments=True)


@pytest.mark.parametrize(('page', 'words'), list(commands_at_racks()))
def test_shots_at_a_rack_hit_it(page, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stroke = [word for word in words if not word.startswith('--output') and 'shot.' not in word]
    assert main(['predict', *stroke, '-o', 'hit.json']) == 0
    capsys.readouterr()
    assert load_shot('hit.json').first_contact is not None
