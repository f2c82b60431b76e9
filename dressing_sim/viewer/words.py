"""What the page says: verdicts and help, as Markdown."""

from __future__ import annotations

from dressing_sim.episode.metrics import metric_text
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rules import RULES
from dressing_sim.viewer.session import Session

_TITLES = {rule.name: rule.title for rule in RULES}

#: Metrics that stand below a verdict.
_TOLD = ("armscye_s", "strain", "grip_force", "link_force", "duration")

HELP = """
**Dress**: bend the arm with the sliders, or drag its wrist or elbow. The orange line is where the
policy would lead the gripper. Press **Dress**.

**Teach**: choose an arm, press **Take the gripper**, drag its handle along the green line, press
**Done**. Keep the take, teach another arm, press **Train**, and dress an arm that you did not teach.
"""


def verdict(outcome: Outcome, against: str = "") -> str:
    """A verdict with its reasons, as Markdown."""
    if outcome.invalid is not None:
        return f"### ⚠️ Invalid\nThe simulation cannot be trusted: {outcome.invalid}"
    lines = ["### ✅ Dressed" if outcome.success else "### ❌ Not dressed"]
    for failure in outcome.failures:
        when = "" if failure.time is None else f" ({failure.time:.2f} s)"
        title = _TITLES.get(failure.reason, failure.reason)
        lines.append(f"- **{title}**{when}: {failure.detail}")
    told = [
        f"{name.replace('_', ' ')} {metric_text(name, outcome.metrics[name])}"
        for name in _TOLD
        if name in outcome.metrics
    ]
    lines += ["", " · ".join(told)] if told else []
    return "\n".join([*lines, *([f"\n*{against}*"] if against else [])])


def state(session: Session) -> str:
    """What is going on, in a line or a verdict."""
    live = session.live
    if session.error:
        return f"⚠️ {session.error}"
    if session.status:
        return f"⏳ {session.status} …"
    shown = session.preview
    if live is None or not session.showing:
        if shown is not None and shown.why:
            return f"⚠️ {shown.why}"
        return HELP
    if live.outcome is not None and session.at is None:
        against = ""
        if session.past is not None and session.replayed is not None:
            same = session.past.agrees(session.replayed, live.outcome)
            against = "as recorded" if same else "not as recorded: other versions, or another world"
        return verdict(live.outcome, against)
    if session.by_hand and session.at is None:
        return "**The gripper is yours.** Drag its handle; time stands still while you do not."
    at = live.time if session.at is None else session.at * live.dressing.config.tracking.dt
    return f"**{at:.2f} s** {'' if session.running else '(time stands still)'}"
