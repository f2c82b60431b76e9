from dressing_sim.benchmark.studies.columns import spaced, table_of

COLUMNS = {
    "unit": "{unit}",
    "share": "{share:.1%}",
    "mean": "{mean:.2f} ({ci[0]:.1f} to {ci[1]:.1f}) N",
    "twice": lambda row: str(2 * row["n"]),
}


def test_a_cell_is_a_format_of_the_row_or_a_function_of_it():
    row = {"unit": "%", "share": 0.1234, "mean": 1.5, "ci": [1.0, 2.0], "n": 2}
    assert table_of(COLUMNS, [row]) == [
        ["unit", "share", "mean", "twice"],
        ["%", "12.3 %", "1.50 (1.0 to 2.0) N", "4"],
    ]


def test_what_is_not_known_is_a_dash():
    row = {"unit": None, "share": None, "mean": 1.0, "ci": None, "n": 0}
    assert table_of(COLUMNS, [row])[1] == ["-", "-", "-", "0"]


def test_without_rows_there_is_the_heading():
    assert table_of(COLUMNS, []) == [["unit", "share", "mean", "twice"]]


def test_per_cent_stands_after_a_space_in_numbers_alone():
    assert spaced("{share:.0%} of 5 % {name}", {"share": 0.5, "name": "a%"}) == "50 % of 5 % a%"
