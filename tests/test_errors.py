from dressing_sim.errors import one_line


def test_a_line_has_no_control_characters_and_an_end():
    assert one_line("a\tb\x1b[31m\r\nc\0") == "a b [31m c"
    assert len(one_line("x" * 5000)) == 300
