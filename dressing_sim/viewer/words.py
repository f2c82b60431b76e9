"""What the page says: verdicts and help, as Markdown."""

from __future__ import annotations

from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rules import RULES
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.viewer.session import Session
from dressing_sim.viewer.shapes import strain_colours

_TITLES = {rule.name: rule.title for rule in RULES}

HELP = """
**Dress**: bend the arm with the sliders, or drag its wrist or elbow. The orange line is where the
policy would lead the gripper. Press **Dress**.

**Teach**: choose an arm, press **Take the gripper**, drag its handle along the green line, press
**Done**. Keep the take, teach another arm, press **Train**, and dress an arm that you did not
teach.
"""


def _numbers(outcome: Outcome, limits: Thresholds) -> str:
    """The metrics that decide, each with its limit."""
    metrics = outcome.metrics
    told = {
        "armscye_s": f"the sleeve's end at s = {{:.2f}} (dressed from {limits.armscye_s:g})",
        "strain": f"strain {{:.2f}} of {limits.strain:g}",
        "grip_force": f"pull {{:.1f}} N of {limits.grip_force:g} N",
        "link_force": f"on the arm {{:.1f}} N of {limits.link_force:g} N",
        "duration": "{:.1f} s",
    }
    return " · ".join(text.format(metrics[name]) for name, text in told.items() if name in metrics)


def verdict(outcome: Outcome, limits: Thresholds, against: str = "") -> str:
    """A verdict with its reasons and limits, as Markdown."""
    if outcome.invalid is not None:
        return f"### Invalid\nThe simulation cannot be trusted: {outcome.invalid}"
    lines = ["### Dressed" if outcome.success else "### Not dressed"]
    for failure in outcome.failures:
        when = "" if failure.time is None else f" ({failure.time:.2f} s)"
        title = _TITLES.get(failure.reason, failure.reason)
        lines.append(f"- **{title}**{when}: {failure.detail}")
    lines += ["", _numbers(outcome, limits)] if outcome.metrics else []
    return "\n".join([*lines, *([f"\n*{against}*"] if against else [])])


def state(session: Session) -> str:
    """What is going on, in a line or a verdict."""
    live = session.live
    if session.error:
        return f"**Not possible:** {session.error}"
    if session.status:
        return f"*{session.status} …*"
    shown = session.preview
    if live is None or not session.showing:
        if shown is not None and shown.why:
            return f"**Not possible:** {shown.why}"
        return HELP
    if live.outcome is not None and session.at is None:
        against = ""
        if session.past is not None and session.replayed is not None:
            same = session.past.agrees(session.replayed, live.outcome)
            against = "as recorded" if same else "not as recorded: other versions, or another world"
        return verdict(live.outcome, live.dressing.config.thresholds, against)
    if session.by_hand and session.at is None:
        return "**The gripper is yours.** Drag its handle; time stands still while you do not."
    at = live.time if session.at is None else session.at * live.dressing.config.tracking.dt
    return f"**{at:.2f} s** {'' if session.running else '(time stands still)'}"


def strain_legend(top: float) -> str:
    """What the colours of the cloth mean, as HTML."""
    colours = ", ".join(f"rgb{colour}" for colour in strain_colours())
    return (
        '<div style="padding: 4px 12px; font-size: 12px">The cloth\'s colour is its strain'
        f'<div style="height: 12px; background: linear-gradient(to right, {colours})"></div>'
        f'<div style="display: flex; justify-content: space-between"><span>0</span>'
        f"<span>{100 * top:.0f} % and more</span></div></div>"
    )
