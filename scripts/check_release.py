"""Whether what is committed can be released, and the files to release: wheel, sdist and the site.

    python scripts/check_release.py [--python python3.11 --python python3.13] [--out dist]

The version is the same everywhere and has a section in the changelog; nothing is uncommitted; wheel
and sdist pass ``twine check``; the wheel works in an empty environment of each Python; the site is
built without a warning and packed, so that every version keeps the pages that belong to it.
It publishes nothing. Needs the extra ``dev``. Exit code 1 if anything is not so.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

#: Where the version stands, and how.
VERSIONS = {
    "pyproject.toml": r'^version = "(.+)"$',
    "dressing_sim/__init__.py": r'^__version__ = "(.+)"$',
    "CITATION.cff": r"^version: (.+)$",
}


def versions(root: Path) -> dict[str, str]:
    """The version that each file names; an empty text where there is none."""
    found = {}
    for name, pattern in VERSIONS.items():
        one = re.search(pattern, (root / name).read_text(encoding="utf-8"), re.MULTILINE)
        found[name] = one[1] if one else ""
    return found


def faults_of_texts(root: Path) -> Iterator[str]:
    """What is wrong with versions and changelog, a line each."""
    named = versions(root)
    if len(set(named.values())) != 1 or not all(named.values()):
        said = ", ".join(f"{file} says {version or 'none'}" for file, version in named.items())
        yield f"versions differ: {said}"
    version = named["pyproject.toml"]
    changes = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    if not re.search(
        rf"^## \[?{re.escape(version)}\]?( - \d{{4}}-\d\d-\d\d)$", changes, re.MULTILINE
    ):
        yield f"CHANGELOG.md has no section '## {version} - YYYY-MM-DD'"


def uncommitted(root: Path) -> Iterator[str]:
    """A line if the working tree is not what is committed."""
    changed = run(["git", "status", "--porcelain"], root).stdout.splitlines()
    if changed:
        yield f"{len(changed)} files are not committed, {changed[0][3:]} among them"


def faults_of_packages(root: Path, out: Path, pythons: list[str]) -> Iterator[str]:
    """Builds wheel and sdist into a folder; what is wrong with them, a line each."""
    built = run([sys.executable, "-m", "build", "--outdir", str(out), str(root)], root)
    if built.returncode:
        yield f"nothing was built: {last_line(built)}"
        return
    files = [str(path) for pattern in ("*.whl", "*.tar.gz") for path in sorted(out.glob(pattern))]
    checked = run([sys.executable, "-m", "twine", "check", "--strict", *files], root)
    if checked.returncode:
        yield f"twine check: {last_line(checked)}"
    for python in pythons:
        with tempfile.TemporaryDirectory() as empty:
            yield from faults_of_wheel(files[0], python, Path(empty))


def faults_of_wheel(wheel: str, python: str, empty: Path) -> Iterator[str]:
    """A line if a wheel does not install and work in an environment made in an empty folder."""
    own = str(empty / "venv" / "bin" / "python")
    for command in (
        [python, "-m", "venv", "venv"],
        [own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel],
        [own, "-m", "dressing_sim", "doctor"],
    ):
        done = run(command, empty)
        if done.returncode:
            yield f"{python}: {' '.join(command[1:4])} ended with {last_line(done)}"
            return


def faults_of_site(root: Path, out: Path, version: str) -> Iterator[str]:
    """Packs the site of this version into a folder; a line if it does not build."""
    with tempfile.TemporaryDirectory() as made:
        site = Path(made) / f"dressing_sim-{version}-docs"
        command = [sys.executable, "-m", "sphinx", "-W", "-q", "-b", "html", "-d", f"{made}/cache"]
        built = run([*command, "docs", str(site)], root)
        if built.returncode:
            yield f"the site does not build: {last_line(built)}"
            return
        shutil.make_archive(str(out / site.name), "zip", made, site.name)


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder, its output kept."""
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return subprocess.CompletedProcess(command, 127, "", f"there is no {command[0]}")


def last_line(done: subprocess.CompletedProcess[str]) -> str:
    """The last line that a command printed, which says most."""
    lines = (done.stdout + done.stderr).strip().splitlines()
    return lines[-1] if lines else f"exit code {done.returncode}"


def main() -> None:
    """Check, build, tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", action="append", help="a Python to install with; repeatable")
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    args = parser.parse_args()
    out = args.out.resolve()
    if out.exists() and any(out.iterdir()):
        sys.exit(f"{out} is not empty; an old file in it could be released")
    out.mkdir(parents=True, exist_ok=True)
    version = versions(ROOT)["pyproject.toml"]
    faults = [
        *faults_of_texts(ROOT),
        *uncommitted(ROOT),
        *faults_of_packages(ROOT, out, args.python or [sys.executable]),
        *faults_of_site(ROOT, out, version),
    ]
    print(*(f"fault: {fault}" for fault in faults), sep="\n")
    print(f"version {version}: {len(faults)} faults, files in {out}")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
