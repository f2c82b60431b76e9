"""A table that grows by rows is the rows' arrays."""

import numpy as np

from dressing_sim.episode.columns import Columns


def row(number):
    return {"n": number, "on": number % 3 == 0, "place": np.full((2, 3), 0.1 * number)}


def test_columns_are_the_arrays_of_the_rows():
    rows, table = [row(number) for number in range(200)], Columns()
    for number, one in enumerate(rows):
        assert len(table) == number
        table.append(one)
    for name, column in table.copies().items():
        expected = np.array([one[name] for one in rows])
        np.testing.assert_array_equal(column, expected)
        assert column.dtype == expected.dtype


def test_a_table_goes_on_after_columns_that_it_leaves_alone():
    first = Columns()
    for number in range(5):
        first.append(row(number))
    kept = first.copies()
    for column in kept.values():
        column.flags.writeable = False
    second = Columns(kept)
    for number in range(5, 90):
        second.append(row(number))
    assert len(second) == 90
    assert second.copies()["n"].tolist() == list(range(90))
    assert kept["n"].tolist() == first.copies()["n"].tolist() == list(range(5))
