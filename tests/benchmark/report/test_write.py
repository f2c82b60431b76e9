import json
import os
from pathlib import Path

import pytest

from dressing_sim.benchmark.report.document import Document, Film, Paragraph, Plot, Section
from dressing_sim.benchmark.report.write import write_report
from dressing_sim.errors import InvalidInputError

SVG = '<?xml version="1.0"?>\n<svg width="72pt" viewBox="0 0 72 36"><g/></svg>'
SUMMARY = {"rows": [], "seed": 4}


def document(text="The result."):
    plots = Plot("own", SVG, "words", file=True), Plot("inside", SVG, "words")
    return Document("A title", "command", (Paragraph(text),), (Section("Plots", plots),))


def test_a_report_is_its_files(tmp_path):
    folder = tmp_path / "a" / "b"
    write_report(folder, document(), SUMMARY)
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["own.svg", "report.html", "report.md", "summary.json"]
    assert json.loads((folder / "summary.json").read_text()) == SUMMARY
    assert (folder / "report.md").read_text().startswith("# A title")
    assert "<h1>A title</h1>" in (folder / "report.html").read_text()
    assert (folder / "own.svg").read_text() == SVG


def test_the_summary_tells_that_a_run_is_finished_so_it_comes_last(tmp_path, monkeypatch):
    order = []
    replace = os.replace

    def noted(source, target, **options):
        order.append(Path(target).name)
        replace(source, target, **options)

    monkeypatch.setattr(os, "replace", noted)
    write_report(tmp_path, document(), SUMMARY)
    assert order[-1] == "summary.json"


def test_a_report_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    write_report(tmp_path, document(), SUMMARY)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}

    def fails(*_arguments):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises((OSError, InvalidInputError), match="disk full"):
        write_report(tmp_path, document("Another."), {})
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_films_are_written_beside_the_page(tmp_path):
    film = Film("success-episode7", b"film", (480, 360), "words", "seen")
    write_report(tmp_path, Document("t", "c", (film,)), SUMMARY)
    assert (tmp_path / "success-episode7.mp4").read_bytes() == b"film"
    assert "[Film](success-episode7.mp4): seen" in (tmp_path / "report.md").read_text()
