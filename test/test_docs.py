"""What README and docs show, runs; blocks for tools that are not here carry a tag."""

import argparse
from importlib import import_module
import json
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys

from programs import ran
import pytest

import billiard_shot
from billiard_shot import machine_code
from billiard_shot.cli import main
from billiard_shot.cli.options import add_options
from billiard_shot.cli.shots import STROKE_OPTIONS, strokes_from_options
from billiard_shot.shot.stroke import read_strokes

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / 'docs'), str(ROOT / 'docs' / '_ext')]
from interfaces import Group, read_interfaces  # noqa: E402
from pages import FILE, included_in, text_of  # noqa: E402
import redraw  # noqa: E402

MESSAGES = ROOT / 'msg_defs'
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').glob('*.md'))]
NOTEBOOKS = sorted((ROOT / 'docs' / 'notebooks').glob('*.ipynb'))
BLOCK = re.compile(r'(?:<!-- needs: (\S+) -->\n)?^```(\w+)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
BLOCKS = [
    (page.name, *match.groups()) for page in PAGES for match in BLOCK.finditer(text_of(page))
]
# Run by CI, and by test_packaging.py.
ELSEWHERE = ('make demo', 'make test', 'pip install .', 'pip install .[plot]')

FILES = {page.name: FILE.findall(page.read_text()) for page in PAGES}
TAGGED = [(page, tag, language, text) for page, tag, language, text in BLOCKS if tag]


def of(*languages):
    found = [
        (page, text) for page, tag, language, text in BLOCKS if language in languages and not tag
    ]
    assert found
    return found


def prepare(page, folder):
    """Write the files that a page shows, and link those that it finds in the repository."""
    (folder / 'config').symlink_to(ROOT / 'config')
    for name, text in FILES[page]:
        (folder / name).write_text(text)


@pytest.mark.parametrize(('page', 'text'), of('python'))
def test_python(page, text, capsys, tmp_path, monkeypatch):
    prepare(page, tmp_path)
    monkeypatch.chdir(tmp_path)  # for the files that they write, too
    exec(compile(text, page, 'exec'), {})
    printed = capsys.readouterr().out
    for said in re.findall(r'^print\(.*\)  +# (.*)$', text, re.MULTILINE):
        assert re.sub(r'\s', '', said) in re.sub(r'\s', '', printed)


@pytest.mark.parametrize(('page', 'text'), of('sh', 'console'))
def test_commands(page, text, capsys, tmp_path, monkeypatch):
    prepare(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    lines = text.replace('\\\n', ' ').splitlines()
    shell = not text.startswith('$ ')  # else a console: commands after $, and what they print
    commands = [line.removeprefix('$ ') for line in lines if shell or line.startswith('$ ')]
    shown = [] if shell else [line for line in lines if not line.startswith('$ ')]
    for command in commands:
        words = shlex.split(command, comments=True)
        if not words or ' '.join(words) in ELSEWHERE:
            continue
        if words[0] == 'python':
            code = import_module(f'studies.{Path(words[1]).stem}').main(words[2:])
        else:
            assert words[0] == 'billiard-shot', command
            code = main(words[1:])
        out, err = capsys.readouterr()
        if shown:
            pattern = re.escape('\n'.join(shown))
            # A line of dots stands for lines that the page leaves out; other dots for times.
            pattern = pattern.replace(re.escape('\n...'), r'\n(?s:.*)')
            pattern = pattern.replace(re.escape('...'), '.*')
            assert re.fullmatch(pattern, (out + err).rstrip('\n')), out + err
        else:
            assert (code, err) == (0, '')


ROBOT = ROOT / 'billiard_shot' / 'ros'
STROKES = re.compile(r'(?:predict_shot|player)((?: --[a-z-]+ -?\d[\d.]*)+)')


def test_strokes_for_the_robot_are_not_miscues():
    """Those of pages and help texts on the default scene, and those of the demo on its own."""
    parser = argparse.ArgumentParser()
    add_options(parser, *STROKE_OPTIONS)
    texts = [*map(text_of, PAGES), *(file.read_text() for file in ROBOT.glob('*.py'))]
    given = {words for text in texts for words in STROKES.findall(text)}
    assert len(given) >= 3
    paper = billiard_shot.Scene.load('paper')
    found = [strokes_from_options(parser.parse_args(words.split()), paper) for words in given]
    played = [(paper, stroke) for strokes in found for stroke in strokes.values()]
    demo = billiard_shot.Scene.load('robot_table')
    own = read_strokes(ROOT / 'config' / 'strokes' / 'demo.yaml', demo.cue_ball)
    for scene, stroke in (*played, *((demo, stroke) for stroke in own.values())):
        assert billiard_shot.predict(scene, stroke).status.name == 'OK', stroke


def changed(folder, file, program, **environment):
    """What a program prints in the package with the layers that docs/extending.md changes."""
    ((_, change),) = [block for block in of('diff') if file in block[1]]
    package = folder / 'billiard_shot'
    shutil.copytree(ROOT / 'config', folder / 'config')  # the bundled scenes
    for layer in set(re.findall(r'^\+\+\+ b/billiard_shot/(\w+)/', change, re.MULTILINE)):
        shutil.copytree(ROOT / 'billiard_shot' / layer, package / layer)
    if shutil.which('patch'):
        shutil.copytree(folder, folder.with_name(f'{folder.name}-patched'))
        patched = folder.with_name(f'{folder.name}-patched')
        command = ['patch', '-p1', '--no-backup-if-mismatch', '--fuzz=0']
        subprocess.run(command, input=change, text=True, cwd=patched, check=True)
    subprocess.run(['git', 'apply', '-'], input=change, text=True, cwd=folder, check=True)
    for path in re.findall(r'^\+\+\+ b/(\S+)', change, re.MULTILINE):
        if shutil.which('patch'):
            assert (patched / path).read_text() == (folder / path).read_text()
    # Not a whole package of its own: machine code is kept for one path only.
    layers_first = f'import billiard_shot; billiard_shot.__path__.insert(0, {str(package)!r})'
    done = ran(
        [sys.executable, '-c', f'{layers_first}\n{program}'],
        cwd=folder,
        env={**os.environ, 'PYTHONPATH': str(ROOT), **environment},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
def test_the_law_of_restitution_that_is_added(tmp_path):
    said = changed(
        tmp_path,
        'impact/options.py',
        """
from billiard_shot import Body, Contact, collide
for e in (0.2, 0.9):
    for exponent in (1.0, 1.5):
        result = collide(
            [Body(mass=1.0, velocity=(0, 0, -3)), Body(mass=2.0)],
            [Contact(a=0, b=1, point=(0, 0, 0), normal=(0, 0, 1), restitution=e)],
            law='blend', exponent=exponent)
        ball, other = result.velocities[:, 2]
        print((ball - other) / 3 - e, result.dissipated.sum() - 3 * (1 - e * e))
""",
        BILLIARD_SHOT_INTERPRET='1',
    )
    numbers = [float(word) for word in said.split()]
    assert len(numbers) == 8
    assert numbers == pytest.approx([0.0] * 8, abs=1e-9)


@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
def test_the_cushion_that_is_added(tmp_path):
    said = changed(
        tmp_path,
        'table/contacts/cushion_models.py',
        """
from billiard_shot import BallState, Scene, simulate
scene = Scene.from_dict({'like': 'pool_table', 'table': {'cushion': {'model': 'mirror'}}})
ball = BallState((1.2, 0.1, scene.ball.radius), (2.0, 0.7, 0.0), (0.0, 0.0, 0.0))
path = simulate(scene, {'cue': ball}).balls['cue']
before, after = path.at(path.rows['time'][1]), path.at(path.rows['time'][2])
print(after.velocity[0] / before.velocity[0], after.velocity[1] / before.velocity[1])
print(*(after.spin - before.spin))
""",
        BILLIARD_SHOT_INTERPRET='1',
    )
    numbers = [float(word) for word in said.split()]
    assert numbers == pytest.approx([-0.9, 1.0, 0.0, 0.0, 0.0], abs=1e-9)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
def test_the_target_that_is_added(tmp_path):
    said = changed(
        tmp_path,
        'planning/targets.py',
        """
from billiard_shot import plan, Scene
scene = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [.3, .2], '8': [-.3, .1]}})
best = plan(scene, {'beyond': -0.9}, budget=1000, constraints={'first_contact': '8'}).best
print(best.shot.run.final_position['cue'][0], best.success, best.shot.run.first_met['cue'])
try:
    plan(scene, {'beyond': 'x'})
except ValueError as refused:
    print(refused)
""",
    )
    reached, refused = said.splitlines()
    x, success, met = reached.split()
    assert float(x) < -0.9
    assert float(success) > 0.5
    assert met == '8'
    assert refused.startswith('target: beyond must be ')


@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
def test_the_game_that_is_added(tmp_path):
    said = changed(
        tmp_path,
        'game/rules/six_ball.py',
        """
from billiard_shot.game import Call, game_names, judge, Outcome, start
state = start('six_ball', 'pool_table', seed=1).with_cue_ball(-0.8, 0)
print('six_ball' in game_names(), len(state.balls))
broken = judge(state, Call(), Outcome('1', (('2', 'foot_left'),), places=state.balls)).state
print(broken.phase, broken.player)
print(judge(broken, Call(), Outcome('3', places=broken.balls)).fouls[0].rule)
won = Outcome('1', (('6', 'side_left'),), places={'cue': (0, 0), '1': (0.5, 0)})
print(judge(broken, Call(), won).state.winner)
foul = Outcome('3', (('6', 'side_left'),), places={'cue': (0, 0), '1': (0.5, 0)})
print('6' in judge(broken, Call(), foul).state.balls)
""",
    )
    assert said.split() == ['True', '7', 'play', '0', '6.2', '0', 'True']


@pytest.mark.skipif(shutil.which('bash') is None, reason='needs bash')
@pytest.mark.parametrize(('page', 'tag', 'language', 'text'), TAGGED)
def test_what_cannot_be_run_names_what_is_there(page, tag, language, text, tmp_path):
    """Commands for tools that are not here: the shell reads them; files, nodes, types exist."""
    if language == 'python':
        compile(text, page, 'exec')
    else:
        script = tmp_path / 'block.sh'
        script.write_text(text)
        subprocess.run(['bash', '-n', script], check=True)
    entries = (ROOT / 'setup.py').read_text()
    for kind, name in re.findall(r'ros2 (run|launch) billiard_shot (\S+)', text):
        assert f"'{name} = " in entries if kind == 'run' else (ROOT / 'launch' / name).is_file()
    for kind, name in re.findall(r'billiard_shot_msgs/(\w+)/(\w+)', text):
        assert (MESSAGES / kind / f'{name}.{kind}').is_file()
    pytest.skip(f'needs {tag} to be run')


def test_pages_show_the_examples_that_are_there():
    shown = set().union(*(included_in(page) for page in PAGES))
    examples = (path for path in (ROOT / 'docs' / 'examples').iterdir() if path.is_file())
    assert shown == {f'examples/{path.name}' for path in examples}


LINK = re.compile(r'\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)')


def anchors_of(page):
    """The anchors that GitHub and Sphinx give to the headings of a page."""
    headings = re.findall(r'^#+ (.*)$', page.read_text(), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', each.lower()).replace(' ', '-') for each in headings}


@pytest.mark.skipif(shutil.which('git') is None, reason='needs git')
@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_to_what_a_reader_on_github_sees(page):
    """To files of the repository, not to those that are made with the pages, and to headings."""
    listed = ran(['git', 'ls-files'], cwd=ROOT)
    if listed.returncode:
        pytest.skip('needs a clone')
    seen = {ROOT / name for name in listed.stdout.splitlines()}
    for name, anchor in LINK.findall(page.read_text()):
        target = (page.parent / name).resolve() if name else page
        assert target in seen, name
        assert not anchor or anchor in anchors_of(target), f'{name}#{anchor}'


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_a_reader_on_github_finds_each_example_by_a_link(page):
    linked = {name for name, _ in LINK.findall(page.read_text())}
    assert included_in(page) <= linked


def test_pages_show_the_pictures_that_are_there():
    pages = ''.join(page.read_text() for page in PAGES)
    there = {path.name for path in (ROOT / 'docs' / 'figures').iterdir()}
    assert set(re.findall(r'\]\((?:docs/)?figures/([^)]+)\)', pages)) == there
    assert redraw.commands().keys() | redraw.SCREENSHOTS | redraw.MEASURED == there


@pytest.mark.parametrize('notebook', NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_short_and_stored_without_outputs(notebook):
    cells = json.loads(notebook.read_text())['cells']
    assert len(cells) <= 12
    assert not any(cell.get('outputs') or cell.get('execution_count') for cell in cells)


def test_every_block_is_of_a_known_kind():
    kinds = {language for _, _, language, _ in BLOCKS}
    # yaml: test/scene/test_check.py; js, c: test/embed/test_export.py
    assert kinds <= {'python', 'sh', 'console', 'yaml', 'text', 'diff', 'js', 'c'}
    assert {tag for _, tag, _, _ in BLOCKS if tag} == {'ros2', 'pooltool'}


REMOTE = r'<(?:script|link|img|iframe|source)\b[^>]* (?:src|href)="(?:\w+:)?/[^"]*"'


def test_pages_build_without_warnings(tmp_path):
    for needed in ('furo', 'latex2mathml', 'myst_nb', 'anywidget'):
        pytest.importorskip(needed, reason='needs the extra docs')
    if not machine_code.is_loaded():
        pytest.skip('needs machine code')
    built = ran(
        [
            sys.executable,
            '-m',
            'sphinx',
            '-W',
            '--keep-going',
            '-q',
            '-b',
            'html',
            ROOT / 'docs',
            tmp_path,
        ]
    )
    assert built.returncode == 0, built.stderr
    for notebook in NOTEBOOKS:  # they have run in kernels, where an error ends the build
        shown = (tmp_path / 'notebooks' / f'{notebook.stem}.html').read_text()
        assert 'cell_output' in shown
        assert ('<iframe srcdoc=' in shown) == ('TableWidget(' in notebook.read_text())
    # Any static host, or a folder of one, serves them, and they ask no other host for anything.
    for page in tmp_path.rglob('*.html'):
        assert not re.findall(REMOTE, page.read_text()), page
    for style in tmp_path.rglob('*.css'):
        assert not re.findall(r'url\(["\']?(?:\w+:)?/', style.read_text()), style
    first = (tmp_path / 'index.html').read_text()
    assert first.index('<iframe class="live"') < first.index('In a clone')
    parameters = (tmp_path / 'reference' / 'parameters.html').read_text()
    for node in ('predictor', 'cue_driver', 'table_display'):
        assert f'id="{node.replace("_", "-")}"' in parameters
    for name in ('period', 'arm_timeout', 'unseen_timeout'):
        assert f'<span class="pre">{name}</span>' in parameters
    named = (tmp_path / 'reference' / 'api.html').read_text()
    for name in billiard_shot.__all__:
        assert f'id="billiard_shot.{name}"' in named, 'docs/reference/api.md lacks it'


UNIT = re.compile('metre|second|radian|no unit|no frame|pose of the tip')
NUMBERS = re.compile(r'float|u?int(8|16|32|64)|geometry_msgs/(Point|Pose|Vector3)')


@pytest.mark.skipif(not MESSAGES.exists(), reason='needs a source checkout')
def test_every_field_says_what_it_is():
    """msg_defs: each field has a comment, with a unit where it is a number; so have constants."""
    interfaces = read_interfaces(MESSAGES)
    assert {'PredictShot', 'TableState', 'ExecuteShot'} <= {each.name for each in interfaces}
    for interface in interfaces:
        for part in interface.parts:
            for item in part.items:
                where = f'{interface.name} {part.name} {item}'
                assert item.comment, where
                if isinstance(item, Group):
                    assert all(constant.name.isupper() for constant in item.constants), where
                else:
                    assert item.name.islower(), where
                    assert UNIT.search(item.comment) or not NUMBERS.match(item.type), where
