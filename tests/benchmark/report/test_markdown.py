from dressing_sim.benchmark.report.document import (
    Cards,
    Code,
    Document,
    Items,
    Paragraph,
    Picture,
    Plot,
    Section,
    Table,
    config_section,
)
from dressing_sim.benchmark.report.markdown import markdown, markdown_table


def document(*blocks, title="Title"):
    return Document(title, "command --seed 4", (Paragraph("The result."),), (Section("S", blocks),))


def test_a_markdown_table_has_a_line_a_row():
    assert markdown_table([["a", "b"], ["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_text_with_bars_and_line_ends_stays_in_its_cell():
    text = markdown_table([["a"], ["x | y\nz"]])
    assert text.splitlines()[2:] == ["| x \\| y z |"]


def test_blocks_come_in_their_order_between_empty_lines():
    text = markdown(
        document(
            Table([["a"], ["1"]], "of what"),
            Items(("one", "two")),
            Code("x = 1", "python"),
            Code("typed\nagain"),
        )
    )
    assert text == (
        "# Title\n\n    command --seed 4\n\nThe result.\n\n## S\n\n| a |\n| --- |\n| 1 |\n\n"
        "of what\n\n* one\n* two\n\n```python\nx = 1\n```\n\n    typed\n    again\n"
    )


def test_plots_that_are_files_are_shown_and_others_are_in_the_page():
    text = markdown(
        document(
            Plot("one", "<svg/>", "a [b] c", "caption", file=True),
            Plot("two", "<svg/>", "words", "of two"),
        )
    )
    assert "![a \\[b\\] c](one.svg)\n\ncaption" in text
    assert "two.svg" not in text
    assert "(report.html): of two" in text


def test_cards_are_sections_and_pictures_are_left_out():
    card = Section("A card", (Picture("p", b"png", "alt"), Paragraph("text")))
    assert markdown(document(Cards((card,)))).endswith("## S\n\n### A card\n\ntext\n")


def test_no_html_begins_in_text_but_code_is_left_alone():
    evil = "<script>x</script> and `<b>` and 1 < 2"
    text = markdown(document(Paragraph(evil), Items((evil,)), Table([[evil]]), title=evil))
    escaped = r"\<script>x\</script> and `<b>` and 1 < 2"
    assert text.count(escaped) == 4
    assert text.count("<script>") == 4


def test_a_run_says_its_configuration_and_versions():
    summary = {"config": {"seed": 4}, "versions": {"mujoco": "4.0", "numpy": "2"}}
    text = markdown(Document("t", "c", (), (config_section(summary),)))
    assert '```json\n{\n  "seed": 4\n}\n```\n\nmujoco 4.0, numpy 2\n' in text
