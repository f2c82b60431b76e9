"""The page in a headless browser."""

import io

import imageio.v3 as imageio
import numpy as np
import pytest

from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.viewer.choices import Choices
from dressing_sim.viewer.lessons import Lessons
from dressing_sim.viewer.session import Session

pytest.importorskip("viser")

LONG = 120.0


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    from dressing_sim.viewer.app import Page

    lessons = Lessons(tmp_path_factory.mktemp("takes") / "takes.h5")
    session = Session(lessons, Choices(policy="expert"))
    session.set_speed(0.0)
    page = Page(session, port=0)
    yield page
    page.close()


@pytest.fixture(scope="module")
def tab(chromium, page):
    tab = chromium.open(f"http://127.0.0.1:{page.port}")
    tab.says("Dress", LONG)
    yield tab
    tab.close()


def colours(tab):
    """How many colours the middle of the page has, in coarse steps."""
    picture = imageio.imread(io.BytesIO(tab.picture()), extension=".png")[..., :3]
    height, width = picture.shape[:2]
    middle = picture[height // 4 : -height // 4, width // 4 : width // 2].reshape(-1, 3)
    return len(np.unique(middle // 32, axis=0))


def test_a_slider_bends_the_arm_and_its_path_follows(tab, page):
    session = page.session
    assert session.wait(lambda: session.preview is not None, LONG)
    before = session.choices.posture.elbow_deg
    tab.wait(
        "(() => { const all = [...document.querySelectorAll('*')];"
        " let one = all.find((e) => !e.children.length && e.textContent.startsWith('Elbow'));"
        " while (one && !one.querySelector('[role=slider]')) one = one.parentElement;"
        " if (!one) return false; one.querySelector('[role=slider]').focus(); return true; })()"
    )
    for _ in range(3):
        tab.key("ArrowRight", 39)
    assert session.wait(lambda: session.choices.posture.elbow_deg == before + 1.5, LONG)
    assert page.wait_for_robot(LONG)
    page.wait_until_drawn(LONG)
    tab.settle()
    assert session.wait(lambda: session.preview.choices is session.choices, LONG)
    assert session.preview.path is not None
    assert colours(tab) > 10
    assert tab.console == []


def test_it_dresses_as_the_command_line_and_survives_reload_and_a_second_tab(tab, page, chromium):
    session = page.session
    session.choose(Choices(policy="expert"))
    tab.press("Dress")
    assert session.wait(lambda: session.running and session.live.n_steps > 10, LONG)
    tab.call("Page.reload")
    second = chromium.open(f"http://127.0.0.1:{page.port}")
    second.says("Dress", LONG)
    second.close()
    assert session.wait(lambda: session.live.over, LONG)
    expected = record(Operator(), Choices().posture, 0).outcome
    assert session.live.outcome.to_dict() == expected.to_dict()
    tab.says("the sleeve's end at s", LONG)


def test_what_is_kept_for_new_tabs_does_not_grow(page):
    session = page.session
    sizes = []
    for round_ in range(3):
        for step in range(0, 100, 5):
            session.look_at(step)
            page.wait_until_drawn(LONG)
        sizes.append(page.n_messages)
        assert round_ == 0 or sizes[-1] <= sizes[0] + 20
