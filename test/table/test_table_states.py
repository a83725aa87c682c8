"""Tables with different balls in one batch: each does what it does alone."""

import numpy as np
import pytest
from tables import POOL, random_states, state

from billiard_shot import BallState, TableStates
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.simulate import simulate, simulate_batch

NAMES = 'cue', '1', '2', '3', '4'


def mixed_tables(seed, count):
    """Tables that have two to five of the balls, moving at random."""
    random = np.random.default_rng(seed)
    tables = []
    for _ in range(count):
        states = list(random_states(random, POOL.table, int(random.integers(2, 6))).values())
        names = random.permutation(NAMES)[: len(states)]
        tables.append(dict(zip(names.tolist(), states, strict=True)))
    return tables


def test_tables_with_different_balls_do_what_they_do_alone():
    tables = mixed_tables(1, 40)
    many = simulate_batch(POOL, tables)
    assert set(many.names) == set(NAMES)
    for i, table in enumerate(tables):
        # equal times are ordered by the balls' order, which is that of the batch
        alone = simulate(POOL, {name: table[name] for name in many.names if name in table})
        assert many.status[i] == alone.status
        assert many.duration[i] == alone.duration
        for k, name in enumerate(many.names):
            if name in table:
                assert (many.final_position[i, k] == alone.final_position[name]).all()
                first = many.first_met[i, k]
                met = None if first < 0 else many.names[first]
                assert met == alone.first_met.get(name)
            else:
                assert many.motion[i, k] == Motion.ABSENT
                assert many.first_met[i, k] == many.pocket[i, k] == -1


def test_a_mask_leaves_out_balls_of_columns():
    places = {'cue': state(0, 0, (2, 0, 0)), '1': state(0.3, 0), '2': state(0.6, 0)}
    columns = {
        name: BallState(np.tile(each.position, (3, 1)), each.velocity, each.spin)
        for name, each in places.items()
    }
    present = [[True, True, True], [True, False, True], [True, False, False]]
    many = simulate_batch(POOL, columns, present=present)
    assert many.first_met[:, 0].tolist() == [1, 2, -1]
    assert (many.motion == Motion.ABSENT).tolist() == (~np.array(present)).tolist()
    # absent balls may have numbers that cannot be: nobody looks at them
    columns['1'].position[1:] = np.nan
    again = simulate_batch(POOL, columns, present=present)
    assert (again.status == Status.OK).all()
    assert (again.final_position == many.final_position).all()


def test_the_balls_that_a_batch_leaves_on_the_table_begin_the_next_one():
    many = simulate_batch(POOL, mixed_tables(2, 60))
    rest = many.states
    assert (rest.present == (many.motion == Motion.REST)).all()
    again = simulate_batch(POOL, rest.take(many.status == Status.OK))
    assert (again.status == Status.OK).all()
    assert (again.duration == 0.0).all()
    kept = rest.take(many.status == Status.OK)
    assert (again.final_position[kept.present] == kept.position[kept.present]).all()


def test_states_are_checked():
    places = np.zeros((2, 1, 3))
    assert len(TableStates(['cue'], places)) == 2
    with pytest.raises(ValueError, match=r'position must be of shape \(2, 2, 3\), got'):
        TableStates(['cue', '1'], places)
    with pytest.raises(ValueError, match=r'present must be of shape \(2, 1\), got \(1, 1\)'):
        TableStates(['cue'], places, present=[[True]])
    with pytest.raises(ValueError, match='present must be true or false, got int64'):
        TableStates(['cue'], places, present=[[1], [0]])
    with pytest.raises(ValueError, match='names must be one name or more, all different'):
        TableStates(['cue', 'cue'], np.zeros((2, 2, 3)))
    with pytest.raises(ValueError, match='present must not be given if states is not a mapping'):
        simulate_batch(POOL, [{'cue': state(0, 0)}], present=[[True]])
