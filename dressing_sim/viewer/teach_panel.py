"""What can be pressed to teach: take the gripper, keep the take, train, try."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from dressing_sim.viewer.leaders import ByHand
from dressing_sim.viewer.panels import when_pressed
from dressing_sim.viewer.session import Session

if TYPE_CHECKING:
    import viser

#: Takes that are a good beginning.
_ENOUGH = 2

#: Colour of the button that comes next, and of others.
_NEXT: Final = "teal"
_OTHER: Final = "gray"


class TeachPanel:
    """Takes by hand, and learning from them. The button that comes next is green."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._arm = gui.add_button("Another arm", hint="One that is not taught yet")
        self._take = gui.add_button("Take the gripper", hint="Lead it yourself")
        self._follow = gui.add_button(
            "Follow the green line", hint="The robot goes on along it to the shoulder"
        )
        self._done = gui.add_button("Done", hint="The robot holds for a second, then the verdict")
        self._keep = gui.add_button("Keep this take", hint="Only a take that dresses can be kept")
        self._takes = gui.add_markdown("")
        self._train = gui.add_button("Train on my takes")
        self._dress = gui.add_button("Dress this arm", hint="With the policy that is chosen")
        self._drop = gui.add_button("Drop the last take")
        when_pressed(self._arm, session.another_arm)
        when_pressed(self._take, session.teach)
        when_pressed(self._follow, session.follow_guide)
        when_pressed(self._done, session.let_go)
        when_pressed(self._keep, self._keep_it)
        when_pressed(self._train, session.train)
        when_pressed(self._dress, session.dress)
        when_pressed(self._drop, self._drop_it)

    def _keep_it(self) -> None:
        with self._session.telling():
            self._session.keep_take()

    def _drop_it(self) -> None:
        with self._session.telling():
            self._session.drop_take()

    def show(self) -> None:
        """What can be pressed now, and which takes there are."""
        session, live = self._session, self._session.live
        takes, leading = session.lessons.takes, session.by_hand
        good = live is not None and live.outcome is not None and live.outcome.success
        good &= live is not None and isinstance(live.leader, ByHand) and session.showing
        keepable = good and session.kept is not live
        self._take.label = "Begin again" if leading else "Take the gripper"
        self._follow.disabled = self._done.disabled = not leading
        self._keep.disabled = not keepable
        self._train.disabled = self._drop.disabled = not takes
        self._paint(leading, keepable)
        lines = [
            f"- take {number}: {take.posture.name}, {len(take.positions) * take.dt:.1f} s"
            for number, take in enumerate(takes, start=1)
        ]
        listed = "\n".join(lines) if lines else "*none yet; two on different arms are enough*"
        self._takes.content = f"**My takes** (in `{session.lessons.file}`)\n\n{listed}"

    def _paint(self, leading: bool, keepable: bool) -> None:
        """Colour the button that comes next."""
        session, takes = self._session, self._session.lessons.takes
        taught = any(take.posture == session.choices.posture for take in takes)
        if leading:
            following = self._follow if session.running and not session.arrived else self._done
        elif keepable:
            following = self._keep
        elif session.trained:
            following = self._arm if taught else self._dress
        elif len(takes) >= _ENOUGH:
            following = self._train
        else:
            following = self._arm if taught else self._take
        for button in (self._arm, self._take, self._follow, self._done, self._keep):
            button.color = _NEXT if button is following else _OTHER
        for button in (self._train, self._dress, self._drop):
            button.color = _NEXT if button is following else _OTHER
