from xml.etree import ElementTree

import matplotlib

from dressing_sim.benchmark.report import plots

ROWS = [
    plots.Interval("a $label$", 10.0, 40.0, 70.0, dots=(20.0, 60.0), ring=50.0),
    plots.Interval("first\nless second", -30.0, None, 20.0, muted=True),
]


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
