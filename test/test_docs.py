"""What README and docs show, runs; blocks for tools that are not here carry a tag."""
from pathlib import Path
import re
import shlex

import pytest

from billiard_shot.cli import main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]
BLOCK = re.compile(r'(?:<!-- needs: (\S+) -->\n)?^```(\w+)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
BLOCKS = [(page.name, *match.groups()) for page in PAGES
          for match in BLOCK.finditer(page.read_text())]
ELSEWHERE = ('make demo', 'make test', 'pip install .')  # run by CI, and by test_packaging.py

WRONG_SCENE = """\
ball:
  mass: -0.17
  radus: 0.0286
  radius: 0.028575
like: pool
balls:
  8: [0.05, 0]
  '8': [1, 1]
"""


def of(*languages):
    found = [(page, text) for page, tag, language, text in BLOCKS
             if language in languages and not tag]
    assert found
    return found


@pytest.mark.parametrize(('page', 'text'), of('python'))
def test_python(page, text, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # for the files that they write
    exec(compile(text, page, 'exec'), {})
    printed = capsys.readouterr().out
    for said in re.findall(r'^print\(.*\)  +# (.*)$', text, re.MULTILINE):
        assert re.sub(r'\s', '', said) in re.sub(r'\s', '', printed)


@pytest.mark.parametrize(('page', 'text'), of('sh', 'console'))
def test_commands(page, text, capsys, tmp_path, monkeypatch):
    (tmp_path / 'config').symlink_to(ROOT / 'config')
    (tmp_path / 'mine.yaml').write_text(WRONG_SCENE)
    monkeypatch.chdir(tmp_path)
    lines = text.replace('\\\n', ' ').splitlines()
    shell = not text.startswith('$ ')  # else a console: commands after $, and what they print
    commands = [line.removeprefix('$ ') for line in lines if shell or line.startswith('$ ')]
    shown = [] if shell else [line for line in lines if not line.startswith('$ ')]
    for command in commands:
        words = shlex.split(command, comments=True)
        if not words or ' '.join(words) in ELSEWHERE:
            continue
        assert words[0] == 'billiard-shot', command
        code = main(words[1:])
        out, err = capsys.readouterr()
        if shown:
            assert (out + err).splitlines() == shown
        else:
            assert (code, err) == (0, '')


def test_every_block_is_of_a_known_kind():
    kinds = {language for _, _, language, _ in BLOCKS}
    assert kinds <= {'python', 'sh', 'console', 'yaml', 'text'}  # yaml: test/scene/test_check.py
    assert {tag for _, tag, _, _ in BLOCKS if tag} == {'ros2'}
