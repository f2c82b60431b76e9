"""The page in a headless browser."""

import io
import time
from dataclasses import replace

import imageio.v3 as imageio
import numpy as np
import pytest

from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.viewer.choices import TAKES, Choices
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


def test_a_person_whose_arm_is_still_is_drawn_as_in_films(page):
    session, stage = page.session, page._stage
    usual = Choices(policy="expert")
    bent = replace(usual, posture=replace(usual.posture, elbow_deg=80.0))
    for choices in (usual, bent):
        session.choose(choices)
        assert session.wait(lambda: session.preview.choices is session.choices, LONG)
        page.wait_until_drawn(LONG)
        assert page.wait_for_likeness(LONG)
        assert not any(handle.visible for handle in stage._person.values())
        # Skin lies where the arm is simulated.
        skin = stage._likeness["skin"].vertices
        for joint in (choices.posture.elbow, choices.posture.shoulder):
            nearest = np.linalg.norm(skin - joint, axis=1).min()
            assert nearest < 1.2 * choices.posture.arm_size.upper_arm_radius


def test_while_somebody_bends_it_the_arm_is_one_of_capsules(page):
    session, stage = page.session, page._stage
    posture = session.choices.posture
    for bend in np.linspace(20.0, 60.0, 9):
        session.choose(replace(session.choices, posture=replace(posture, elbow_deg=bend)))
        assert session.wait(lambda: session.preview.choices is session.choices, LONG)
        page.wait_until_drawn(LONG)
        handles = stage._likeness.values() if stage.portrayed else stage._person.values()
        assert all(handle.visible for handle in handles)
    assert page.wait_for_likeness(LONG)


def pixel(tab, page, place):
    """Where a place (3,) [m] is on the screen: the camera may have been turned."""
    camera = next(iter(page._server.get_clients().values())).camera
    eye, up = np.array(camera.position), [0.0, 0.0, 1.0]
    ahead = (np.array(camera.look_at) - eye) / np.linalg.norm(camera.look_at - eye)
    right = np.cross(ahead, up) / np.linalg.norm(np.cross(ahead, up))
    left, top, width, height = tab.box("document.querySelector('canvas')")
    offset = np.asarray(place) - eye
    scale = height / 2.0 / np.tan(camera.fov / 2.0) / (offset @ ahead)
    x, y = scale * (offset @ right), scale * (offset @ np.cross(right, ahead))
    return np.array([left + width / 2.0 + x, top + height / 2.0 - y])


def drag_through(tab, page, places, held):
    """Drag a handle with the mouse from the first place in the scene (n, 3) [m] through the others.

    A press that comes before the browser has found out what is below the mouse turns the camera
    instead: it is then let go, and tried again from where the handle is seen by now.
    """
    end = time.monotonic() + LONG
    while True:
        start = pixel(tab, page, places[0])
        tab.mouse("Moved", start - 3.0)
        tab.mouse("Moved", start)
        tab.mouse("Pressed", start, button="left", clickCount=1)
        towards = pixel(tab, page, places[1]) - start
        begun = start + 8.0 * towards / np.linalg.norm(towards)
        tab.mouse("Moved", begun, button="left", buttons=1)
        if page.session.wait(held, 10.0):
            break
        tab.mouse("Released", begun, button="left", clickCount=1)
        assert time.monotonic() < end, "the handle cannot be taken hold of"
    for place in places[1:]:
        tab.mouse("Moved", pixel(tab, page, place), button="left", buttons=1)
    tab.mouse("Released", pixel(tab, page, places[-1]), button="left", clickCount=1)


def test_the_wrist_is_dragged_by_its_arrow(tab, page):
    session, handle = page.session, page._stage.wrist
    session.choose(Choices(policy="expert"))
    page.wait_until_drawn(LONG)
    before = session.choices.posture
    tip = before.wrist + [0.0, 0.0, 0.11]
    places = [tip, tip + [0.0, 0.0, 0.03], tip + [0.0, 0.0, 0.06]]
    drag_through(tab, page, places, lambda: page._stage.held == "wrist")
    assert session.wait(lambda: page._stage.held is None, LONG)
    assert session.wait(lambda: session.choices.posture.wrist[2] > before.wrist[2] + 0.03, LONG)
    # It snaps back onto the arm.
    page.wait_until_drawn(LONG)
    assert np.allclose(handle.position, session.choices.posture.wrist)


def test_somebody_teaches_it_trains_and_it_dresses_another_arm(tab, page):
    session, takes = page.session, page.session.lessons
    session.choose(Choices(policy="expert"))
    tab.tab("Teach")
    tab.press("Take the gripper", LONG)
    tab.says("drag the orange ball", LONG)
    live, hand, guide = session.live, session.hand, session.guide.path.positions
    page.wait_until_drawn(LONG)
    grip = [-0.025, 0.0, 0.0]  # on the screen right of the middle, where no arrow is
    before = hand.target
    drag_through(tab, page, guide[:120:30] + grip, lambda: hand.target is not before)
    assert session.wait(lambda: live.waits and live.n_steps > 0, LONG)
    beside = np.linalg.norm(guide - live.dressing.target, axis=1)
    assert beside.min() < 0.005  # along the line, however the mouse trembles
    assert 20 < beside.argmin() < len(guide) - 20
    tab.press("Follow the green line", LONG)
    tab.says("Press Done", LONG)
    tab.press("Done", LONG)
    assert session.wait(lambda: live.over, LONG)
    assert live.outcome.success, live.outcome.reasons
    tab.press("Keep this take", LONG)
    tab.says("take 1: bent40", LONG)
    assert len(takes.takes) == len(Lessons(takes.file).takes) == 1
    tab.press("Train on my takes", LONG)
    tab.says("has learned from your take", LONG)
    tab.press("Another arm", LONG)
    assert session.wait(lambda: session.choices.posture.name != "bent40", LONG)
    tab.press("Dress this arm", LONG)
    assert session.wait(lambda: session.live is not live and session.live.over, LONG)
    choices = session.choices
    assert choices.demonstrations == TAKES
    policy = Lessons(takes.file).policy(choices)
    expected = record(policy, choices.posture, choices.seed).outcome
    assert session.live.outcome.to_dict() == expected.to_dict()
    tab.says("Dressed" if expected.success else "Not dressed", LONG)
    tab.tab("Dress")


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
