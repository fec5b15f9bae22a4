"""The size of the package is a figure like its speed: no room holds more lines than `size.toml` allows."""

import ast
import functools
import tomllib
from collections import Counter
from pathlib import Path

import pytest
from source import SOURCE, nodes_of, text_of

TABLE = Path(__file__).with_name("size.toml")
ALL = "all"
SLACK = 1.02
"""Ratio to the figures of the table up to which a room may grow between two looks at them."""


def docstring_lines(path):
    """Numbers of the lines of all docstrings of a file."""
    found = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and (
            ast.get_docstring(node, clean=False) is not None
        ):
            found.update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return found


def example_lines(path):
    """Count the lines of the sections Examples, the last of a docstring: they are run, and bounded, by a test of their own."""
    told = (ast.get_docstring(node) or "" for node in nodes_of(path) if isinstance(node, ast.FunctionDef))
    return sum(
        f"\n{text}".partition("\n\nExamples\n---")[2].count("\n") + 3
        for text in told
        if "\n\nExamples\n---" in text
    )


def lines_of(path):
    """Lines of code, without blank lines and comments, and lines of docstrings without their examples."""
    told = docstring_lines(path)
    code = sum(
        bool(line.strip()) and not line.lstrip().startswith("#") and number not in told
        for number, line in enumerate(text_of(path).splitlines(), 1)
    )
    return code, len(told) - example_lines(path)


@functools.cache
def sizes():
    """Lines of code and of docstrings of each room, and of all."""
    code, told = Counter(), Counter()
    for path in SOURCE.rglob("*.py"):
        inside = path.relative_to(SOURCE).parts
        room = inside[0] if len(inside) > 1 else "top"
        own = lines_of(path)
        for name in (room, ALL):
            code[name] += own[0]
            told[name] += own[1]
    return {room: (code[room], told[room]) for room in code}


def allowed():
    """Rows of the table: room, lines of code, lines of docstrings."""
    rows = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return {room: (row["code"], row["docstrings"]) for room, row in rows.items()}


def test_every_room_is_in_the_table():
    assert set(sizes()) == set(allowed())


@pytest.mark.parametrize("room", allowed())
def test_no_room_grows_without_a_word(room):
    """To raise a figure takes a sentence in the table that says what it buys; to lower it takes none."""
    code, told = sizes()[room]
    most, most_told = allowed()[room]
    assert code <= SLACK * most, f"{room}: {code} lines of code, {most} allowed"
    assert told <= SLACK * most_told, f"{room}: {told} lines of docstrings, {most_told} allowed"


def test_the_table_is_near_what_there_is():
    """A figure far above what a room holds would let it grow unseen."""
    now, most = sizes(), allowed()
    loose = {room: (now[room], most[room]) for room in now if most[room][0] > 1.02 * now[room][0] + 20}
    assert not loose


def test_lines_are_counted_as_described(tmp_path):
    file = tmp_path / "example.py"
    file.write_text(
        '"""Sum."""\n\n# why\nx = 1\n\n\ndef f():\n    """Two.\n\n    Lines.\n    """\n    return x\n'
    )
    assert lines_of(file) == (3, 5)
    file = tmp_path / "with_example.py"
    file.write_text(
        'def f():\n    """Two.\n\n    Examples\n    --------\n    >>> f()\n    """\n    return 1\n'
    )
    assert lines_of(file) == (2, 2)
