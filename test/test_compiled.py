"""Calls of entries: tables of arguments, of which a part is kept, and threads."""

from threading import Event, Thread
from time import monotonic, sleep

import numpy as np
import pytest

from billiard_shot import machine_code, predict_within_noise, Scene
from billiard_shot.compiled import argument_table, Run
from billiard_shot.records import ROWS
from billiard_shot.table.run.task import play_tables

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs the library')


def test_a_table_has_the_arguments_of_its_call_whatever_was_called_before():
    description = machine_code.library().description
    arguments = description['entries']['play_tables']['arguments']
    assert 0 < play_tables.kept < len(arguments)
    table = argument_table(arguments, play_tables.kept)
    one, other = play_tables.example(ROWS), play_tables.example(ROWS)
    mixed = *one[:-1], other[-1]
    first, second, third = (table(*args) for args in (one, other, mixed))
    assert len({first, second, third}) == 3
    assert [table(*args) for args in (one, one, other, mixed)] == [first, first, second, third]
    found = []
    thread = Thread(target=lambda: found.append(table(*other)))
    thread.start()
    thread.join()
    assert found == [second]
    assert table(*mixed) == third


def test_other_threads_run_during_a_call(monkeypatch):
    """
    The lock of the interpreter is released; ctypes does that.

    On a busy machine the other thread may not run during one call, but it runs during one of many.
    """
    ticks, ended = [], Event()
    run = play_tables.compiled

    def timed(*args):
        begin = monotonic()
        result = run(*args)
        calls.append((begin, monotonic()))
        return result

    def has_run():
        begin, end = max(calls, key=lambda call: call[1] - call[0])
        quarter = 0.25 * (end - begin)
        return any(begin + quarter < each < end - quarter for each in ticks)

    def tick():
        while not ended.is_set():
            ticks.append(monotonic())
            sleep(0.001)

    monkeypatch.setattr(play_tables, 'compiled', Run(ROWS, timed))
    scene, strokes = Scene.load('eight_ball'), np.tile([0, 0, 0.1, 0.0, 8.0], (400, 1))
    thread = Thread(target=tick)
    thread.start()
    try:
        for _ in range(100):
            calls = []
            predict_within_noise(scene, strokes, workers=1)
            if has_run():
                break
        else:
            raise AssertionError('no other thread has run')
    finally:
        ended.set()
        thread.join()
