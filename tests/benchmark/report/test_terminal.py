from io import StringIO

from rich.console import Console

from dressing_sim.benchmark.report.document import Document, Items, Paragraph, Section, Table
from dressing_sim.benchmark.report.terminal import print_document, print_table


def printed(document):
    console = Console(width=80, record=True, file=StringIO())
    print_document(document, console)
    return console.export_text()


def test_the_lead_is_printed_and_no_more():
    text = printed(
        Document(
            "title",
            "command",
            (
                Paragraph("The **result**."),
                Table([["a", "b"], ["1", "`2`"]], "Told."),
                Items(("x",)),
            ),
            (Section("Further", (Paragraph("details"),)),),
        )
    )
    assert "The result." in text
    assert "Told." in text
    assert [line.strip("│ ").split() for line in text.splitlines() if "│" in line] == [
        ["1", "│", "2"]
    ]
    assert "* x" in text
    assert "details" not in text


def test_square_brackets_are_text(capsys):
    print_table([["pull [N]"], ["[red]1[/red]"]])
    told = capsys.readouterr().out
    assert "pull [N]" in told
    assert "[red]1[/red]" in told
