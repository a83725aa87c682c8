import io
import sys

import pytest

from billiard_shot.cli import output as module
from billiard_shot.cli.output import progress, progress_line, reporting


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_silent_where_stderr_is_no_terminal(monkeypatch):
    monkeypatch.setattr(sys, 'stderr', io.StringIO())
    assert list(progress(range(5), 'strokes')) == [0, 1, 2, 3, 4]
    with reporting('strokes', 5) as report:
        report(3)
    assert sys.stderr.getvalue() == ''


def test_draws_on_a_terminal_and_clears_up(monkeypatch):
    monkeypatch.setattr(sys, 'stderr', Terminal())
    monkeypatch.setattr(module, 'INTERVAL', 0.0)
    assert list(progress((i for i in range(4)), 'strokes', total=4)) == [0, 1, 2, 3]
    drawn = sys.stderr.getvalue().split('\r\033[K')
    assert drawn[1].endswith('0/4')
    assert [text.split(',')[0].split()[-1] for text in drawn[2:6]] == ['1/4', '2/4', '3/4', '4/4']
    assert drawn[-1] == ''


def test_clears_up_after_an_error(monkeypatch):
    monkeypatch.setattr(sys, 'stderr', Terminal())
    with pytest.raises(RuntimeError), reporting('strokes', 3):
        raise RuntimeError
    assert sys.stderr.getvalue().endswith('\r\033[K')


def test_text_of_a_bar():
    assert progress_line('x', 0, 10, 0.0) == 'x: [' + '.' * 30 + '] 0/10'
    assert progress_line('x', 5, 10, 2.0) == 'x: [' + '#' * 15 + '.' * 15 + '] 5/10, 2 s to go'
    assert progress_line('x', 10, 10, 2.0) == 'x: [' + '#' * 30 + '] 10/10'
    assert progress_line('x', 7, 0, 2.0) == 'x: 7'
