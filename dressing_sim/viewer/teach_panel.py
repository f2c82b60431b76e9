"""What can be pressed to teach: take the gripper, keep the take, train."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dressing_sim.viewer.live import ByHand
from dressing_sim.viewer.panels import when_pressed
from dressing_sim.viewer.session import Session

if TYPE_CHECKING:
    import viser

_HELP = """
1. Choose an arm with the sliders.
2. **Take the gripper** and drag its handle along the **green line**, round the elbow and up to the
   shoulder. Time stands still while you do not drag.
3. **Done**: the robot holds for a second, and there is a verdict.
4. **Keep this take**. Two takes on different arms are a good beginning.
5. **Train on my takes**, choose an arm that you did not teach, and press **Dress**.
"""


class TeachPanel:
    """Takes by hand, and learning from them."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        gui.add_markdown(_HELP)
        self._take = gui.add_button("Take the gripper", color="teal")
        self._done = gui.add_button("Done")
        self._keep = gui.add_button("Keep this take", color="green")
        self._train = gui.add_button("Train on my takes", color="orange")
        self._takes = gui.add_markdown("")
        self._drop = gui.add_button("Drop the last take", color="red")
        self._kept: object = None
        when_pressed(self._take, session.teach)
        when_pressed(self._done, session.let_go)
        when_pressed(self._keep, self._keep_it)
        when_pressed(self._train, session.train)
        when_pressed(self._drop, self._drop_it)

    def _keep_it(self) -> None:
        with self._session.telling():
            self._session.keep_take()
            self._kept = self._session.live

    def _drop_it(self) -> None:
        with self._session.telling():
            self._session.drop_take()

    def show(self) -> None:
        """What can be pressed now, and which takes there are."""
        session, live = self._session, self._session.live
        takes = session.lessons.takes
        by_hand = live is not None and isinstance(live.leader, ByHand)
        dressed = live is not None and live.outcome is not None and live.outcome.success
        self._take.label = "Begin again" if session.by_hand else "Take the gripper"
        self._done.disabled = not session.by_hand
        self._keep.disabled = not (by_hand and dressed) or self._kept is live
        self._train.disabled = self._drop.disabled = not takes
        lines = [
            f"{number}. {take.posture.name}, {len(take.positions) * take.dt:.1f} s"
            for number, take in enumerate(takes, start=1)
        ]
        listed = "\n".join(lines) if lines else "*none yet*"
        self._takes.content = f"**My takes** (in `{session.lessons.file}`)\n\n{listed}"
