import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from submitted import ADA, ROWS, changed, fake_run, flip

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.scoreboard.page import scoreboard, scoreboard_page
from dressing_sim.benchmark.scoreboard.submission import read_submission, submit
from dressing_sim.cli import main
from dressing_sim.errors import InvalidInputError


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Three submitted results in a folder: two of the same rows, one of another policy."""
    made = []
    for place, (name, entries) in enumerate(
        [
            ("Ada", ROWS),
            ("Bob", [Entry("tp-gmm-noise", "case_b"), Entry("tp-gmm", "case_b")]),
            ("Eve", [Entry("tp-gmm-rf", "case_b")]),
        ]
    ):
        (tmp_path / name).mkdir()
        folder = fake_run(tmp_path / name, monkeypatch, entries)
        path = tmp_path / "files" / f"{name.lower()}.json"
        path.parent.mkdir(exist_ok=True)
        link = ADA.link if place == 0 else ""
        path.write_text(submit(folder, replace(ADA, name=name, link=link, practised=place == 2)))
        made.append(path)
    return made


def test_there_is_a_table_for_each_class_with_the_best_first(files, tmp_path):
    read = {file: read_submission(file) for file in files}
    document = scoreboard(read, tmp_path / "page.md", "")
    assert [section.title for section in document.sections] == [
        "Suite paper5, inputs frames",
        "Suite paper5, inputs frames, practised in the simulator",
        "Suite paper5, inputs posture",
    ]
    (table,) = document.sections[0].blocks
    heading, *body = table.cells
    assert heading[:5] == ["policy", "shown", "success", "rate", "95 % interval"]
    successes = [int(line[2].partition("/")[0]) for line in body]
    assert len(body) == 3
    assert successes == sorted(successes, reverse=True)
    for place, line in enumerate(body, start=1):
        rows = read[tmp_path / "files" / line[-1]].rows
        (row,) = [one for one in rows if f"`{one['policy']}`" == line[0]]
        assert line[2] == f"{row['n_success']} / {row['n_episodes']}"
        assert table.links[place, len(line) - 1] == f"files/{line[-1]}"


class Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attributes):
        if tag == "a":
            self.found.append(dict(attributes)["href"])


def test_links_lead_from_the_page_to_the_files(files, tmp_path, monkeypatch, capsys):
    for page in ("board.html", "sub/board.html"):
        main(["scoreboard", str(files[0].parent), "--out", str(tmp_path / page)])
        links = Links()
        links.feed((tmp_path / page).read_text())
        inside = [one for one in links.found if not one.startswith("https://")]
        assert {(tmp_path / page).parent.joinpath(one).resolve() for one in inside} == set(files)
        assert set(links.found) - set(inside) == {ADA.link}
    text = scoreboard_page(files, tmp_path / "board.md", "typed")
    assert "| [Ada](https://example.org/~ada) | 2026-11-27 | [ada.json](files/ada.json) |" in text
    with pytest.raises(SystemExit):
        main(["scoreboard", str(files[0].parent), "--out", str(tmp_path / "board.html")])
    assert "use --force" in capsys.readouterr().err


def test_nothing_in_a_page_is_somebodys_markup(files, tmp_path):
    for page in ("board.md", "board.html"):
        text = scoreboard_page(files, tmp_path / page, "a <b>command</b>")
        assert "<b>" not in text.replace("    a <b>command</b>", "")
    for name in ("<img src=x onerror=alert(1)>", "a|b", "**a**", "`a`", "![a](b)"):

        def named(values, name=name):
            values["submitted"]["name"] = name

        changed(files[0], named)
        with pytest.raises(InvalidInputError, match="valid is one without markup"):
            scoreboard_page(files, tmp_path / "board.html", "")


@pytest.mark.parametrize("name", ["a b.json", "a`.json", "<b>.json", "[a](b).json"])
def test_a_files_name_is_plain(name, files, tmp_path):
    odd = files[0].rename(files[0].parent / name)
    with pytest.raises(InvalidInputError, match="valid is a name of letters"):
        scoreboard_page([odd], tmp_path / "board.md", "")


def test_the_same_episodes_stand_there_once(files, tmp_path):
    again = files[0].with_name("again.json")
    again.write_text(files[0].read_text().replace('"name": "Ada"', '"name": "Eve"'))
    with pytest.raises(InvalidInputError, match=r"again\.json: holds the episodes of .*ada\.json"):
        scoreboard_page([*files, again], tmp_path / "board.md", "")


@pytest.mark.parametrize(
    ("out", "part"),
    [("board.txt", "valid is a name that ends .md, .html"), ("files/ada.json", "is read as well")],
)
def test_bad_input_is_one_line(out, part, files, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(["scoreboard", "files", "--out", out])
    told = capsys.readouterr().err
    assert (stopped.value.code, told.count("\n")) == (2, 1)
    assert part in told


def test_a_file_that_breaks_a_rule_keeps_the_page_from_being_made(files, tmp_path, monkeypatch):
    changed(files[1], flip, seal=False)
    with pytest.raises(InvalidInputError, match=re.escape(f"{files[1]}: episodes do not match")):
        scoreboard_page(files, tmp_path / "board.md", "")


def test_an_empty_folder_is_an_empty_page(tmp_path):
    assert "No results yet." in scoreboard_page([], tmp_path / "board.md", "typed")
