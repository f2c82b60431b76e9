"""The table of the scoreboard is what its files give."""

from pathlib import Path

from dressing_sim.benchmark.scoreboard.page import scoreboard_page

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "scoreboard"
COMMAND = "dressing-sim scoreboard docs/scoreboard --out docs/scoreboard/table.md --force"


def test_the_table_is_made_of_the_files():
    page = FOLDER / "table.md"
    text = scoreboard_page(sorted(FOLDER.glob("*.json")), page, COMMAND)
    assert page.read_text(encoding="utf-8") == text


def test_the_rules_say_how_it_is_made():
    assert COMMAND in (FOLDER.parent / "scoreboard.md").read_text(encoding="utf-8")
