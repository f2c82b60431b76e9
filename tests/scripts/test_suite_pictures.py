from pathlib import Path

import matplotlib
import pytest
from suite_pictures import distance_table, draw_postures

from dressing_sim import load_suite
from dressing_sim.errors import InvalidInputError

PAPER = load_suite("paper5")
SUITES = {"val50": load_suite("val50")[:25], "paper5": PAPER}


def test_the_same_postures_make_the_same_file(tmp_path):
    one, again, other = (tmp_path / name for name in ("one.svg", "again.svg", "other.svg"))
    draw_postures(SUITES, one)
    with matplotlib.rc_context({"font.size": 20.0}):
        draw_postures(SUITES, again)
    draw_postures({"paper5": PAPER[:4]}, other)
    assert one.read_bytes() == again.read_bytes() != other.read_bytes()
    assert one.read_text(encoding="utf-8").startswith("<?xml")


def test_every_arm_is_drawn_from_three_sides(tmp_path, monkeypatch):
    drawn = []
    plot = matplotlib.axes.Axes.plot
    monkeypatch.setattr(
        matplotlib.axes.Axes,
        "plot",
        lambda axes, *points, **style: drawn.append(points) or plot(axes, *points, **style),
    )
    draw_postures({"paper5": PAPER}, tmp_path / "arms.svg")
    lines = [(list(x), list(y)) for x, y in drawn if not isinstance(x, float)]
    assert len(lines) == 3 * len(PAPER)
    for posture in PAPER:
        joints = [posture.wrist, posture.elbow, posture.shoulder]
        for across, up in ((0, 1), (0, 2), (1, 2)):
            assert ([p[across] for p in joints], [p[up] for p in joints]) in lines


@pytest.mark.parametrize("n", [0, 4])
def test_too_many_or_no_suites_are_an_error(tmp_path, n):
    with pytest.raises(InvalidInputError, match="valid is 1 to 3"):
        draw_postures({str(i): PAPER for i in range(n)}, tmp_path / "none.svg")
    assert not list(tmp_path.iterdir())


def test_the_table_has_a_row_for_each_frame_of_each_suite():
    table = distance_table({"case_a": load_suite("case_a"), "same": [PAPER[0], PAPER[0]]})
    _, _, *rows = table.splitlines()
    assert [row.split("|")[1].strip() for row in rows] == ["`case_a`"] * 2 + ["`same`"] * 2
    assert rows[2] == "| `same` | shoulder | 0.000 | 0, 0, 0 | 0 |"


def test_one_posture_has_no_distance():
    with pytest.raises(InvalidInputError, match="'alone': 1 postures"):
        distance_table({"alone": PAPER[:1]})


def test_the_documents_state_the_table_of_the_two_cases():
    docs = Path(__file__).parents[2] / "docs" / "benchmark.md"
    table = distance_table({name: load_suite(name) for name in ("case_a", "case_b")})
    assert table in docs.read_text(encoding="utf-8")
