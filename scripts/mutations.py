"""Small changes of Python code: one operator, comparison, number, condition or statement each.

Docstrings, annotations, texts, decorators, assertions and what is raised stay as they are; so does
``strict=`` of zip, which is an assertion.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

#: Operators, comparisons and functions, each with what stands in its place.
SWAPS = """Add>Sub Sub>Add Mult>Div Div>Mult Pow>Mult FloorDiv>Mult Mod>FloorDiv LShift>RShift
And>Or Or>And Lt>LtE Lt>Gt LtE>Lt LtE>GtE Gt>GtE Gt>Lt GtE>Gt GtE>LtE Eq>NotEq NotEq>Eq Is>IsNot
IsNot>Is In>NotIn NotIn>In min>max max>min any>all all>any floor>ceil ceil>floor maximum>minimum
minimum>maximum argmin>argmax argmax>argmin"""
KEPT = (ast.Raise, ast.JoinedStr, ast.Assert, ast.Import, ast.ImportFrom)


@dataclass(frozen=True)
class Mutant:
    """A file, with the bytes from ``begin`` to ``end`` replaced."""

    path: Path
    line: int
    begin: int
    end: int
    text: str

    def __str__(self) -> str:
        old = self.path.read_bytes()[self.begin : self.end].decode()
        return f"{self.path}:{self.line}: {old} -> {self.text}".replace("\n", " ")

    def source(self, original: bytes) -> bytes:
        """The file's new bytes."""
        return original[: self.begin] + self.text.encode() + original[self.end :]


def others(old: str | ast.AST) -> list[str]:
    """Names of what may stand in the place of a name or of an operator."""
    name = old if isinstance(old, str) else type(old).__name__
    return [new for one, new in (swap.split(">") for swap in SWAPS.split()) if one == name]


def changes(node: ast.AST) -> Iterator[str]:
    """What may stand in the place of a node."""
    match node:
        case ast.BinOp(left, ast.MatMult(), right):
            yield f"({ast.unparse(right)} @ {ast.unparse(left)})"
        case ast.BinOp(left, op, right):
            for new in others(op):
                yield f"({ast.unparse(ast.BinOp(left, getattr(ast, new)(), right))})"
        case ast.AugAssign(target, op, value):
            for new in others(op):
                yield ast.unparse(ast.AugAssign(target, getattr(ast, new)(), value))
            yield "pass"
        case ast.Compare(left, ops, comparators):
            for place, one in enumerate(ops):
                for new in others(one):
                    changed = [*ops[:place], getattr(ast, new)(), *ops[place + 1 :]]
                    yield f"({ast.unparse(ast.Compare(left, changed, comparators))})"
        case ast.BoolOp(op, values):
            yield f"({ast.unparse(ast.BoolOp(getattr(ast, others(op)[0])(), values))})"
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield f"({ast.unparse(operand)})"
        case ast.Constant(bool() as value):
            yield str(not value)
        case ast.Constant(int() | float() as value):
            yield from (f"({value + 1})", f"({value - 1})")
        case ast.Call(ast.Name(name), arguments, keywords):
            for new in others(name):
                yield ast.unparse(ast.Call(ast.Name(new), arguments, keywords))
        case ast.Attribute(ast.Name("np"), name):
            yield from (f"np.{new}" for new in others(name))
        case ast.Break() | ast.Continue():
            yield "continue" if isinstance(node, ast.Break) else "break"
        case ast.Expr(ast.Call()) | ast.Assign([ast.Subscript() | ast.Attribute()]):
            yield "pass"


def mutants(path: Path) -> list[Mutant]:
    """All mutants of a file."""
    source = path.read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found: list[Mutant] = []

    def visit(node: ast.AST) -> None:
        if isinstance(node, KEPT) or (isinstance(node, ast.keyword) and node.arg == "strict"):
            return
        if isinstance(node, ast.expr | ast.stmt):
            begin = starts[node.lineno - 1] + node.col_offset
            end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
            found.extend(Mutant(path, node.lineno, begin, end, text) for text in changes(node))
        for name, value in ast.iter_fields(node):
            if name not in ("annotation", "returns", "decorator_list", "type_params"):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        visit(child)

    visit(ast.parse(source))
    return found
