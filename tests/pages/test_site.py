"""The site builds without a warning, is complete, and fetches nothing from elsewhere."""

import re
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path

import pytest

import dressing_sim
from dressing_sim import learning

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))

#: What a browser loads by itself; a link that somebody may click is another thing.
LOADED = {
    "img": "src",
    "script": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "link": "href",
}


class Loads(HTMLParser):
    """Collects the addresses that a page makes a browser load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs).get(LOADED.get(tag, ""))
        if found:
            self.found.append(found)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_parser")
    pytest.importorskip("furo")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", folder / "cache", DOCS, folder / "html"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    # Warnings are errors; what libraries say of their caches, such as of fonts, is none.
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    return folder / "html"


def test_nothing_is_loaded_from_elsewhere(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 30
    for page in pages:
        loads = Loads()
        loads.feed(page.read_text(encoding="utf-8"))
        assert loads.found
        assert not [one for one in loads.found if re.match(r"(\w+:)?//", one)]
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(@import|url\()\s*[\"']?(https?:)?//", text)


def test_it_has_every_public_name_and_every_command(site):
    pages = {
        page.stem: page.read_text(encoding="utf-8") for page in (site / "reference").glob("*.html")
    }
    for name in set(dressing_sim.__all__) - {"__version__", "Policy"}:
        anchor = rf'id="dressing_sim\.(\w+\.)*{name}"'
        assert re.search(anchor, pages["python"] + pages["config"]), name
    for name in learning.__all__:
        assert f">{name}<" in pages["learning"], name
    commands = pages["commands"]
    for name in ("evaluate", "dress", "import", "doctor"):
        assert f'id="{name}"' in commands


def test_its_title_says_the_version(site):
    assert f"dressing_sim {dressing_sim.__version__}" in (site / "index.html").read_text("utf-8")


def test_every_page_is_in_the_navigation():
    listed = set()
    for tree in re.findall(r"```\{toctree\}\n(.*?)```", (DOCS / "index.md").read_text(), re.DOTALL):
        listed |= {line for line in tree.splitlines() if line and not line.startswith(":")}
    pages = {str(page.relative_to(DOCS).with_suffix("")) for page in PAGES}
    assert listed == pages - {"index", "planar/table"}


def test_the_layers_of_the_page_are_those_that_are_checked():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
    checked = [name.strip() for layer in layers for name in layer.split("|")]
    text = (DOCS / "architecture.md").read_text(encoding="utf-8").split("## Layers")[1]
    rows = re.findall(r"^\| (`.*?) \|", text.split("\n## ")[0], re.MULTILINE)
    assert [
        f"dressing_sim.{name}" for row in rows for name in re.findall(r"`(.*?)`", row)
    ] == checked
