"""Whatever is typed wrongly is told in one line, with exit code 2."""

import pytest

from dressing_sim.cli import main


@pytest.mark.parametrize(
    ("line", "parts"),
    [
        ("", ["no command", "evaluate, replay"]),
        ("evalute", ["'evalute'", "did you mean 'evaluate'", "doctor"]),
        ("evaluate --seed abc", ["evaluate: --seed is 'abc'", "valid is a whole number"]),
        ("evaluate --seed 1.5", ["'1.5'", "valid is a whole number"]),
        ("planar --snr-db loud", ["--snr-db is 'loud'", "valid is a number"]),
        ("planar --method magic", ["'magic'", "'rf+noise'"]),
        ("evaluate --sed 1", ["--sed", "see dressing-sim evaluate --help"]),
        ("evaluate now", ["unknown now"]),
        ("dress", ["missing --posture"]),
        ("dress --posture", ["--posture", "Missing value"]),
        ("replay folder seven", ["'seven'", "valid is a whole number"]),
        ("replay folder", ["missing INT"]),
        ("learn", ["missing PATH"]),
    ],
)
def test_one_line_says_what_was_got_and_what_is_valid(line, parts, capsys):
    with pytest.raises(SystemExit) as end:
        main(line.split())
    told = capsys.readouterr()
    assert end.value.code == 2
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert told.err.startswith("dressing-sim: ")
    for part in parts:
        assert part in told.err


def test_a_narrow_terminal_does_not_change_the_line(monkeypatch, capsys):
    told = []
    for columns in ("20", "200"):
        monkeypatch.setenv("COLUMNS", columns)
        with pytest.raises(SystemExit):
            main(["planar", "--runs", "many"])
        told.append(capsys.readouterr().err)
    assert "--runs is 'many', valid is a whole number" in told[1]
    assert told[0].count("\n") == 1


def test_help_stays_the_parser_s(capsys):
    with pytest.raises(SystemExit) as end:
        main(["evaluate", "--help"])
    assert end.value.code == 0
    assert "For example" in capsys.readouterr().out
