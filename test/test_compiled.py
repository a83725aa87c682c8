"""Tables of arguments, of which a part is kept from call to call."""

from threading import Thread

import pytest

from billiard_shot import machine_code
from billiard_shot.records import ROWS
from billiard_shot.table.play_tables import play_tables


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs the library')
def test_a_table_has_the_arguments_of_its_call_whatever_was_called_before():
    compiled = play_tables.compiled
    assert 0 < compiled.new < len(compiled.arguments)
    one, other = play_tables.example(ROWS), play_tables.example(ROWS)
    mixed = *one[:-1], other[-1]
    first, second, third = (compiled.table(*args) for args in (one, other, mixed))
    assert len({first, second, third}) == 3
    assert [compiled.table(*args) for args in (one, one, other, mixed)] == [
        first,
        first,
        second,
        third,
    ]
    found = []
    thread = Thread(target=lambda: found.append(compiled.table(*other)))
    thread.start()
    thread.join()
    assert found == [second]
    assert compiled.table(*mixed) == third
