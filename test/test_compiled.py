"""Tables of arguments, of which a part is kept from call to call."""

from threading import Thread

import pytest

from billiard_shot import machine_code
from billiard_shot.compiled import table_of
from billiard_shot.records import ROWS
from billiard_shot.table.play_tables import play_tables


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs the library')
def test_a_table_has_the_arguments_of_its_call_whatever_was_called_before():
    description = machine_code.library().description
    arguments = description['entries']['play_tables']['arguments']
    assert 0 < play_tables.kept < len(arguments)
    table = table_of(arguments, play_tables.kept)
    one, other = play_tables.example(ROWS), play_tables.example(ROWS)
    mixed = *one[:-1], other[-1]
    first, second, third = (table(*args) for args in (one, other, mixed))
    assert len({first, second, third}) == 3
    assert [table(*args) for args in (one, one, other, mixed)] == [
        first,
        first,
        second,
        third,
    ]
    found = []
    thread = Thread(target=lambda: found.append(table(*other)))
    thread.start()
    thread.join()
    assert found == [second]
    assert table(*mixed) == third
