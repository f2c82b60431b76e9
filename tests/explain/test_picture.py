import re
from io import BytesIO

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from matplotlib.patches import Ellipse
from PIL import Image

from dressing_sim.benchmark.report import plots
from dressing_sim.errors import InvalidInputError
from dressing_sim.explain.learned import (
    FrameView,
    Learned,
    MixtureExplanation,
    TransportExplanation,
)
from dressing_sim.explain.mixtures import projected
from dressing_sim.explain.picture import write_explanation
from dressing_sim.explain.sides import sides_of
from dressing_sim.explain.transport import _tube
from dressing_sim.learning.density import GaussianMixture

JOINTS = np.array([[0.5, 0.2, 0.3], [0.6, 0.45, 0.2], [0.55, 0.65, 0.35]])
PATH = JOINTS[::-1].repeat(4, axis=0) + np.linspace(0.0, 0.1, 12)[:, None]
SD = np.array([0.03, 0.05, 0.08])


def mixture(shift=0.0):
    return GaussianMixture(np.ones(1), JOINTS[:1] + shift, np.diag(SD**2)[None])


def mixtures(synthetic=(), discarded=(), initial=None):
    learned = Learned(mixture(), initial)
    views = [FrameView(n, learned, (PATH,), synthetic, discarded) for n in ("shoulder", "wrist")]
    return MixtureExplanation(JOINTS, PATH, tuple(views), learned)


def transport():
    carried = np.stack([PATH + 0.01, PATH - 0.01])
    return TransportExplanation(JOINTS, PATH, np.linspace(0.01, 0.03, len(PATH)), carried)


def texts(svg):
    return re.findall(r"<!-- (.*?) -->", svg)


@pytest.mark.parametrize("explained", [mixtures(), transport()], ids=["mixture", "transport"])
def test_the_suffix_says_the_format_and_the_same_numbers_make_the_same_file(tmp_path, explained):
    for name in ("a.svg", "b.svg", "a.png", "b.png"):
        write_explanation(tmp_path / name, explained, "tp-gmm on bent40")
    for suffix in ("svg", "png"):
        first, second = ((tmp_path / f"{n}.{suffix}").read_bytes() for n in "ab")
        assert first == second
    assert "tp-gmm on bent40" in texts((tmp_path / "a.svg").read_text())
    picture = np.asarray(Image.open(BytesIO((tmp_path / "a.png").read_bytes())).convert("L"))
    assert picture.shape[1] == pytest.approx(plots.WIDTH * 250, abs=2)
    assert picture.max() == 255
    assert picture.min() < 60


def test_an_unknown_format_is_refused(tmp_path):
    with pytest.raises(InvalidInputError, match=r"unknown format '.gif', valid is .svg, .png"):
        write_explanation(tmp_path / "a.gif", mixtures(), "")


def test_the_legend_names_what_is_there_and_counts_it(tmp_path):
    write_explanation(tmp_path / "a.svg", mixtures(), "")
    told = texts((tmp_path / "a.svg").read_text())
    assert "expert demonstration" in told
    assert not [text for text in told if "synthetic" in text]
    full = mixtures((PATH,) * 2, (PATH,) * 70, mixture(0.1))
    write_explanation(tmp_path / "b.svg", full, "")
    told = texts((tmp_path / "b.svg").read_text())
    assert {
        "synthetic, kept (2)",
        "synthetic, discarded (70, 60 drawn)",
        "before synthetic demonstrations",
    } <= set(told)


def test_both_sides_see_lengths_as_they_are_from_the_shoulder():
    for side in sides_of(JOINTS):
        np.testing.assert_allclose(side.axes @ side.axes.T, np.eye(2), atol=1e-12)
        np.testing.assert_allclose(side.points(JOINTS[:1]), 0.0, atol=1e-12)
        wrist = side.points(JOINTS)[2]
        assert wrist[0] == pytest.approx(np.hypot(0.05, 0.45))
    beside, above = sides_of(JOINTS)
    assert beside.points(JOINTS)[1, 1] == pytest.approx(-0.1)
    assert above.points(JOINTS)[2, 1] == pytest.approx(0.0, abs=1e-12)
    hanging = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.7], [0.0, 0.0, 0.5]])
    assert np.isfinite(sides_of(hanging)[0].axes).all()


def test_ellipses_reach_two_standard_deviations_of_the_marginal():
    joints = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.6, 0.0, 0.0]])  # along x
    at_origin = GaussianMixture(np.ones(1), np.zeros((1, 3)), np.diag(SD**2)[None])
    for side, other in zip(sides_of(joints), (SD[2], SD[1]), strict=True):
        (ellipse,) = projected(side, at_origin)
        assert isinstance(ellipse, Ellipse)
        corners = ellipse.get_verts()
        np.testing.assert_allclose(corners.max(axis=0), [2 * SD[0], 2 * other], rtol=1e-3)


def test_the_tube_is_as_wide_as_the_deviation_says():
    explained, side = transport(), sides_of(JOINTS)[0]
    with plots.figure(2.0) as drawn:
        axes = drawn.subplots()
        _tube(axes, side, explained, 2.0, "#cfe9df", 1.0)
    (tube,) = axes.collections
    assert isinstance(tube, EllipseCollection)
    places, widths = tube.get_offsets(), tube.get_widths()
    np.testing.assert_allclose(widths[[0, -1]], 4.0 * explained.deviation[[0, -1]])
    np.testing.assert_allclose(places[[0, -1]], side.points(PATH)[[0, -1]])
    gaps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert (gaps <= 0.11 * widths[1:]).all()
