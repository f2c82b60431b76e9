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


def pixel(tab, place):
    """Where a place (3,) [m] is on the screen, as the page's first camera sees it."""
    left, top, width, height = tab.box(
        "[...document.querySelectorAll('canvas')].reduce((a, b) => b.width > a.width ? b : a)"
    )
    eye, target = np.array([-0.05, 1.05, 0.80]), np.array([0.40, -0.12, 0.22])
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    seen = np.array([right, np.cross(right, forward), forward]) @ (place - eye)
    scale = height / 2.0 / np.tan(np.deg2rad(46.0) / 2.0) / seen[2]
    return left + width / 2.0 + scale * seen[0], top + height / 2.0 - scale * seen[1]


def drag_handle(tab, page, place, axis, length, way, moved):
    """Drag a handle at a place by the arrow of an axis until something has moved."""
    direction = np.eye(3)[axis]
    grip = place + length * direction
    page.wait_until_drawn(LONG)
    tab.settle()
    for _ in range(4):  # a slow machine may have drawn the handle too late to be gripped
        tab.frames(4)
        tab.drag(pixel(tab, grip), pixel(tab, grip + way * direction))
        if page.session.wait(moved, 10.0):
            return
    raise AssertionError(f"nothing moved; the page says: {tab.text()}")


def colours(tab):
    """How many colours the middle of the page has, in coarse steps."""
    picture = imageio.imread(io.BytesIO(tab.picture()), extension=".png")[..., :3]
    height, width = picture.shape[:2]
    middle = picture[height // 4 : -height // 4, width // 4 : width // 2].reshape(-1, 3)
    return len(np.unique(middle // 32, axis=0))


def test_a_slider_and_a_dragged_wrist_bend_the_arm_and_its_path_follows(tab, page):
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
    bent = session.choices.posture
    nearer = bent.wrist[0] - 0.02
    assert page.wait_for_robot(LONG)
    drag_handle(
        tab, page, bent.wrist, 0, 0.11, -0.08, lambda: session.choices.posture.wrist[0] < nearer
    )
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


def test_somebody_teaches_it_trains_and_it_dresses_another_arm(tab, page):
    session = page.session
    tab.tab("Teach")
    tab.press("Take the gripper", LONG)
    assert session.wait(lambda: session.by_hand, LONG)
    live = session.live
    assert session.wait(lambda: session.running, LONG)
    rng = np.random.default_rng(0)
    path = Operator().path(live.dressing.posture, live.dressing.target, rng)
    for place in path[::12]:
        session.lead(place)
        assert session.wait(lambda: live.waits or live.over, LONG)
    session.lead(path[-1])
    assert session.wait(lambda: live.waits or live.over, LONG)
    tab.press("Done", LONG)
    assert session.wait(lambda: live.over, LONG)
    assert live.outcome.success, live.outcome.reasons
    tab.press("Keep this take", LONG)
    tab.says("1. bent40", LONG)
    session.choose(Choices(posture=Choices().bent(elbow_deg=46.0).posture))
    tab.press("Train on my takes", LONG)
    assert session.wait(lambda: session.preview.path is not None, LONG)
    tab.tab("Dress")
    tab.press("Dress", LONG)
    assert session.wait(lambda: session.live is not live and session.live.over, LONG)
    assert session.live.outcome.success, session.live.outcome.reasons
    tab.says("Dressed", LONG)


def test_what_is_kept_for_new_tabs_does_not_grow(page):
    session = page.session
    sizes = []
    for round_ in range(3):
        for step in range(0, 100, 5):
            session.look_at(step)
            page.wait_until_drawn(LONG)
        sizes.append(page.n_messages)
        assert round_ == 0 or sizes[-1] <= sizes[0] + 20
