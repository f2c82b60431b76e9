import re
from itertools import combinations
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest

from dressing_sim.benchmark.report import plots
from dressing_sim.files import assets

ROWS = [
    plots.Interval("a $label$", 10.0, 40.0, 70.0, dots=(20.0, 60.0), ring=50.0),
    plots.Interval("first\nless second", -30.0, None, 20.0, muted=True),
]

#: What the eye perceives of linear RGB without one kind of cones (Machado et al. 2009), and with
#: all.
VISIONS = {
    "all": np.eye(3),
    "protanopes": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "deuteranopes": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "tritanopes": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}


def perceived(colour, vision):
    """A colour #rrggbb in Oklab (Ottosson 2020), where 0.02 is just noticed."""
    encoded = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(encoded < 0.04, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    cones = [[0.4122, 0.5363, 0.0514], [0.2119, 0.6807, 0.1074], [0.0883, 0.2817, 0.6300]]
    lab = [[0.2105, 0.7936, -0.0041], [1.9780, -2.4286, 0.4506], [0.0259, 0.7828, -0.8087]]
    return np.array(lab) @ np.cbrt(np.array(cones) @ np.clip(np.array(vision) @ linear, 0, 1))


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("eyes", VISIONS)
def test_categories_and_the_page_are_told_apart_by_everybody(eyes, theme):
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    page = dict(
        re.findall(r"(--\w+): (#\w+);", re.findall(r":root \{(.*?)\}", style, re.DOTALL)[theme])
    )
    black, *others = plots.CATEGORIES
    assert black == plots.BLACK
    seen = [
        perceived(colour, VISIONS[eyes]) for colour in (page["--paper"], page["--black"], *others)
    ]
    for a, b in combinations(seen, 2):
        assert np.linalg.norm(a - b) > 0.07


def test_the_same_numbers_make_the_same_file_whatever_the_style_outside():
    first = plots.intervals(ROWS, "rate [%]", (-40.0, 100.0))
    with matplotlib.rc_context({"font.size": 20.0, "svg.fonttype": "none"}):
        assert plots.intervals(ROWS, "rate [%]", (-40.0, 100.0)) == first
    assert plots.intervals(ROWS[:1], "rate [%]", (-40.0, 100.0)) != first
    ElementTree.fromstring(first)


def test_every_kind_that_occurs_is_drawn_and_explained():
    colours = {"stuck": "#d55e00", "hit": "#56b4e9", "never": "#009e73"}
    rows = {"a": {"stuck": 20.0, "hit": 3.0}, "b": {"hit": 15.0}, "c": {}}
    svg = plots.stacked(rows, colours, "failed [%]")
    assert svg.count("fill: #d55e00") == 2  # a bar, and its place in the legend
    assert svg.count("fill: #56b4e9") == 3
    assert "#009e73" not in svg


def test_long_labels_are_broken_into_lines():
    label = "tp-gmm-rf-noise?" + "&".join(f"parameter{i}=0.1" for i in range(6)) + " on case_a"
    lines = plots.wrapped(label).splitlines()
    assert max(map(len, lines)) <= 46
    assert "".join(lines).replace(" ", "") == label.replace(" ", "")


def test_panels_are_as_many_as_wanted():
    with plots.figure(3.0) as drawn:
        grid = plots.panels(drawn, 4, 3, sharex=True)
        assert len(grid) == 4
        assert sum(axes.axison for axes in drawn.axes) == 4
