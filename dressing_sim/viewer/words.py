"""What the page says: what to do next, verdicts and their reasons, as Markdown."""

from __future__ import annotations

from dressing_sim.benchmark.records import first_failure
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import region
from dressing_sim.viewer.leaders import ByHand
from dressing_sim.viewer.past import title_of
from dressing_sim.viewer.session import Session
from dressing_sim.viewer.shapes import strain_colours


def next_step(session: Session) -> str:
    """What a newcomer does best now, in a line."""
    live, takes = session.live, len(session.lessons.takes)
    if session.status or session.running:
        return "" if session.hand is None else _leading(session)
    if session.showing and live is not None and session.at is None:
        if session.hand is not None:
            return _leading(session)
        if live.outcome is not None:
            return _after(session, live.outcome, takes)
    if session.past is not None and not session.trained:
        return "open **Run**, click a ball in the scene (or choose a posture), press **Replay**."
    if session.trained:
        arm = session.choices.posture
        if any(arm == take.posture for take in session.lessons.takes):
            return "**Another arm**, one that you did not teach; then **Dress**."
        return "press **Dress**: an arm that you did not teach."
    if takes == 1:
        return "teach a second arm: open **Teach** and press **Take the gripper**."
    if takes:
        return "open **Teach** and press **Train on my takes**."
    return (
        "press **Dress** and watch, or bend the arm first. To show the robot how it is done, open "
        "**Teach** and press **Take the gripper**."
    )


def _leading(session: Session) -> str:
    """What to do for somebody who leads the gripper."""
    live, left = session.live, session.left
    if live is None or left is None:
        return "drag the orange ball to the shoulder, then press **Done**."
    if session.arrived:
        return "you are at the shoulder. Press **Done**."
    if live.n_steps:
        return f"go on along the green line: {100 * left:.0f} cm are left."
    return (
        f"drag the orange ball along the green line, {100 * left:.0f} cm round the elbow to the "
        "shoulder, or press **Follow the green line**. Time stands still while you think."
    )


def _after(session: Session, outcome: Outcome, takes: int) -> str:
    """What to do after a verdict."""
    live = session.live
    if live is not None and isinstance(live.leader, ByHand):
        if not outcome.success:
            return "press **Take the gripper** and try again."
        if session.kept is not live:
            return "press **Keep this take**."
        if takes == 1:
            return "one take is kept. **Another arm**, and teach that too."
        return f"{takes} takes are kept. **Train on my takes**, or teach one more."
    if outcome.success:
        return "**Another arm** in **Teach**, or drag **Time** to look back."
    return "press **See where it went wrong**, or teach this arm too."


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


def told(failure: Failure) -> str:
    """A failure in a sentence: what, when, where and how much."""
    when = "" if failure.time is None else f" after {failure.time:.1f} s"
    detail = failure.detail.replace("armscye", "wide end")
    return f"**{title_of(failure).capitalize()}**{when}: {detail}."


def verdict(outcome: Outcome, limits: Thresholds, against: str = "") -> str:
    """A verdict with its reasons and limits, as Markdown."""
    if outcome.invalid is not None:
        return f"### Invalid\nThe simulation cannot be trusted: {outcome.invalid}"
    lines = ["### Dressed" if outcome.success else "### Not dressed"]
    first = first_failure(outcome)
    if first is not None:
        lines += [told(first), ""]
        lines += [f"- then: {told(one)}" for one in outcome.failures if one is not first]
    lines += ["", _numbers(outcome, limits)] if outcome.metrics else []
    return "\n".join([*lines, *([f"\n*{against}*"] if against else [])])


def state(session: Session) -> str:
    """What is going on, and what to do next."""
    step = next_step(session)
    return "\n\n".join(filter(None, [_now(session), step and f"\u27a1 **Next:** {step}"]))


def _now(session: Session) -> str:
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
        return _chosen(session)
    if live.outcome is not None and session.at is None:
        against = ""
        if session.past is not None and session.replayed is not None:
            same = session.past.agrees(session.replayed, live.outcome)
            against = "as recorded" if same else "not as recorded: other versions, or another world"
        return verdict(live.outcome, live.dressing.config.thresholds, against)
    if session.by_hand and session.at is None:
        return f"**The gripper is yours**, {live.time:.1f} s so far."
    moment = session.moment()
    if moment is None:
        return ""
    still = "" if session.running else " (time stands still)"
    where = region(moment.row.armscye_s)
    return f"**{moment.row.time:.2f} s**{still}: the sleeve's wide end is at the {where}."


def _chosen(session: Session) -> str:
    """Which policy would dress, and what it learned from."""
    choices = session.choices
    if session.trained:
        number = len(session.lessons.takes)
        takes = "your take" if number == 1 else f"your {number} takes"
        return (
            f"**{choices.policy_name}** has learned from {takes}. "
            "The orange line is where it would lead the gripper."
        )
    return (
        f"The orange line is where the policy **{choices.policy_name}** would lead the gripper, "
        "for the arm that you see."
    )


def strain_legend(top: float) -> str:
    """What the colours of the cloth mean, as HTML."""
    colours = ", ".join(f"rgb{colour}" for colour in strain_colours())
    return (
        '<div style="padding: 4px 12px; font-size: 12px">The cloth\'s colour is its strain'
        f'<div style="height: 12px; background: linear-gradient(to right, {colours})"></div>'
        f'<div style="display: flex; justify-content: space-between"><span>0</span>'
        f"<span>{100 * top:.0f} % and more</span></div></div>"
    )
