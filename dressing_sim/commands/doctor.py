"""``dressing-sim doctor``: checks of the installation."""

from __future__ import annotations

import json as json_format


def doctor(json: bool = False) -> None:
    """Check this installation: packages, robot, simulation, pictures.

    Exit code 1 if something that evaluation needs does not work.

    For example: dressing-sim doctor

    Args:
        json: print the findings as JSON.
    """
    from dataclasses import asdict

    from dressing_sim.doctor import examine

    findings = []
    for finding in examine():
        findings.append(finding)
        if not json:
            mark = "ok" if finding.ok else "FAILED" if finding.needed else "missing"
            print(f"{mark:8} {finding.name}: {finding.detail}", flush=True)
    if json:
        print(json_format.dumps([asdict(finding) for finding in findings], indent=2))
    if any(finding.needed and not finding.ok for finding in findings):
        raise SystemExit(1)
