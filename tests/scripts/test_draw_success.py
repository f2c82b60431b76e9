import matplotlib
import pytest
from draw_success import DOCS, PANELS, draw, rows_of


def test_each_row_of_the_tables_is_a_point_at_its_rate(monkeypatch):
    drawn = []
    plot = matplotlib.axes.Axes.plot
    monkeypatch.setattr(
        matplotlib.axes.Axes,
        "plot",
        lambda axes, x, *rest, **style: drawn.append(x) or plot(axes, x, *rest, **style),
    )
    draw()
    rows = (row for runs in PANELS.values() for rows in rows_of(runs).values() for row in rows)
    rates = [row["pc_success"] for row in rows]
    assert sorted(drawn) == pytest.approx(sorted(rates))


def test_the_committed_plot_names_every_row_and_suite():
    text = (DOCS / "success.svg").read_text(encoding="utf-8")
    for title, runs in PANELS.items():
        for name in (title, *rows_of(runs)):
            assert f"<!-- {name} -->" in text
