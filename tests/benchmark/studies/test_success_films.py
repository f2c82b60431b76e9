from pathlib import Path
from types import SimpleNamespace

import imageio.v2 as imageio
import pytest
from fake_results import HIT, SMALL, STUCK, SUCCESS, UNREACHABLE, results_of

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.report.document import Film, Paragraph
from dressing_sim.benchmark.report.html import html
from dressing_sim.benchmark.studies import success_films
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.benchmark.studies.success_document import success_document
from dressing_sim.benchmark.studies.success_films import failure_films, films_section
from dressing_sim.benchmark.studies.success_summary import summarise
from dressing_sim.episode.config import EpisodeConfig

LINES = [[HIT, SUCCESS], [STUCK, STUCK], [UNREACHABLE, SUCCESS]]
FOLDER = Path("a folder")


@pytest.fixture
def replayed(monkeypatch, world, posture):
    """Episodes of a few steps of a real world, in which the sleeve falls; which were run again."""
    asked, differences = [], {}

    def replay(study, folder, index, observer):
        asked.append(index)
        result = folder[index]
        for _ in range(0 if result.outcome is UNREACHABLE else 40):
            world.step()
            observer(world)
        return SimpleNamespace(
            result=result,
            differences=differences.get(index, []),
            posture=posture,
            config=EpisodeConfig(),
        )

    monkeypatch.setattr(success_films, "replay_episode", replay)
    return asked, differences


def filmed(count=1, lines=LINES):
    results = results_of(SMALL, lines)
    films = failure_films(Success(), dict(enumerate(results)), SMALL, results, count)
    return results, films, films_section(FOLDER, SMALL, EpisodeTable.of(results), films)


@pytest.mark.usefixtures("opengl")
def test_a_typical_failure_of_each_row_is_a_film_that_plays(replayed, tmp_path):
    _, films, section = filmed()
    asked, _ = replayed
    assert asked == [0, 2, 4]
    assert list(films.mp4) == [0, 2]
    cards = section.blocks[-1].cards
    assert [card.title for card in cards] == [
        "expert: hit, 1 of 1 failures",
        f"{SMALL.entries[1].label}: over_strain, 2 of 2 failures",
        f"{SMALL.entries[2].label}: ik_unreachable, 1 of 1 failures",
    ]
    film = cards[0].blocks[0]
    assert isinstance(film, Film)
    assert "the robot touched head" in film.alt
    assert "dressing-sim replay 'a folder' 0 --video film.mp4" in film.caption
    missing = cards[2].blocks[0]
    assert isinstance(missing, Paragraph)
    assert "the robot never moved" in missing.text
    (tmp_path / "film.mp4").write_bytes(film.mp4)
    with imageio.get_reader(tmp_path / "film.mp4") as reader:
        told = reader.get_meta_data()
        assert told["codec"] == "h264"
        assert told["pix_fmt"].startswith("yuv420p")
        assert told["size"] == film.size == (480, 360)


def test_an_episode_that_comes_out_otherwise_has_no_film(replayed):
    _, differences = replayed
    differences[0] = ["success: recorded false, now true"]
    _, films, section = filmed(lines=[[HIT], [SUCCESS], [SUCCESS]])
    assert films.mp4 == {}
    (card,) = section.blocks[-1].cards
    assert card.blocks == (
        Paragraph("No film: this episode does not come out as it was recorded."),
    )


def test_where_nothing_failed_nothing_is_run_again(replayed):
    _, _, section = filmed(lines=[[SUCCESS]] * 3)
    assert replayed[0] == []
    assert section.blocks == (Paragraph("No episode failed."),)


def test_without_films_the_report_is_as_it_was():
    results = results_of(SMALL, LINES)
    summary = summarise(SMALL, results, {"seed": 3})
    document = success_document(FOLDER, SMALL, results, summary, "command")
    assert "filmed" not in html(document)
    assert not document.films
