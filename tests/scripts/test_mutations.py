import ast

import pytest
from mutations import mutants

CODE = '''
"""A text with 1 + 2."""
def f(x: int = 3) -> "int | None":
    """Not 4 < 5."""
    if x is None or not x < 1.5:
        raise ValueError(f"{x + 1}")
    for n in range(2):
        x += 3 * n
        continue
    return max(x, -n) @ x
'''.lstrip()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "code.py"
    path.write_text(CODE, encoding="utf-8")
    return path


def test_every_mutant_is_another_program(file):
    found = mutants(file)
    trees = {ast.dump(ast.parse(mutant.source(CODE.encode()))) for mutant in found}
    assert len(trees) == len(found)
    assert ast.dump(ast.parse(CODE)) not in trees


def test_what_may_change_changes_and_texts_do_not(file):
    changed = [(mutant.line, str(mutant).partition(": ")[2]) for mutant in mutants(file)]
    for change in (
        (2, "3 -> (4)"),
        (4, "x is None or not x < 1.5 -> (x is None and (not x < 1.5))"),
        (4, "x is None -> (x is not None)"),
        (4, "not x < 1.5 -> (x < 1.5)"),
        (4, "x < 1.5 -> (x <= 1.5)"),
        (7, "x += 3 * n -> x -= 3 * n"),
        (7, "x += 3 * n -> pass"),
        (7, "3 * n -> (3 / n)"),
        (8, "continue -> break"),
        (9, "max(x, -n) -> min(x, -n)"),
        (9, "-n -> (n)"),
        (9, "max(x, -n) @ x -> (x @ max(x, -n))"),
    ):
        assert change in changed, change
    assert {line for line, _ in changed} == {2, 4, 6, 7, 8, 9}
