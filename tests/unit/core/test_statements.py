"""What is stated about models and results: checks against sources, diagnostics, equations, versions."""

from __future__ import annotations

import math
import platform
from importlib.metadata import version

import numpy as np
import pytest

from electrovib.core import versions
from electrovib.core.checks import STATUSES, Check
from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.core.formulas import formula_lines
from electrovib.core.status import UNVERIFIED, status_text


class Doubling:
    def twice(self, x):
        return 2 * x


def check(**changes):
    given = {"name": "twice", "expect": 4.0, "rtol": 0.01, "source": "table 1", "given": {"x": 2.0}}
    return Check(**(given | changes))


def test_a_number_of_a_source_is_compared_and_can_disagree():
    assert check().value(Doubling()) == 4.0
    assert check(compute=lambda: 4).value() == 4.0
    assert all(check().accepts(value) for value in (4.0, 3.9601, 4.0399))
    assert not any(check().accepts(value) for value in (3.88, 4.12, -4.0, 0.0, math.nan, math.inf))
    assert check(expect=-58.0).accepts(-58.5)
    assert not check(expect=-58.0).accepts(-60.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [("status", "unverified"), ("status", "rumour"), ("expect", 0.0)]
    + [("rtol", value) for value in (0.0, 1.0, -0.1, math.nan)],
)
def test_what_cannot_check_is_refused(name, value):
    with pytest.raises(TypeError):
        check(**{name: value})


def test_each_status_has_its_words_and_a_definition_none():
    assert (STATUSES[0], STATUSES[-1]) == ("full text", UNVERIFIED)
    assert status_text(UNVERIFIED) == "unverified, cited from memory"
    assert status_text("") == "a definition"
    assert len({status_text(status) for status in STATUSES}) == len(STATUSES) == 4
    assert all(status_text(status).startswith(status.split()[0]) for status in STATUSES)


def test_a_diagnostic_is_plain_text_with_one_of_three_states():
    diagnostic = Diagnostic("Paschen", "warning", "above 800 V")
    assert diagnostic.to_dict() == {"name": "Paschen", "state": "warning", "text": "above 800 V"}
    assert {"ok", "warning", "unknown"} == set(STATES)
    with pytest.raises(ValueError, match="'red' is not one of"):
        Diagnostic("Paschen", "red", "above 800 V")


@pytest.mark.parametrize(
    ("name", "text", "lines"),
    [
        ("voltage", "a*b + c", ["voltage = a*b + c"]),
        ("element.impedance", "r + path.element().impedance(f)", ["impedance = r + path.impedance(f)"]),
        ("part.friction'", "-a", ["part.friction' = -a"]),
        ("rate", "0 if leak is None else 1/leak", ["rate = 0, without leak", "rate = 1/leak, otherwise"]),
        (
            "v",
            "x if t < a else y if t < b else x",
            ["v = x, for t < a", "v = y, for t < b", "v = x, otherwise"],
        ),
    ],
)
def test_an_equation_has_a_line_for_each_case(name, text, lines):
    assert formula_lines(name, text) == tuple(lines)


def test_versions_are_those_installed(monkeypatch):
    monkeypatch.setattr(versions, "PARTS", ("electrovib", "numpy", "surely-not-installed"))
    found = versions.versions()
    assert found["numpy"] == np.__version__
    assert found["electrovib"] == version("electrovib")
    assert found["python"] == platform.python_version()
    assert "surely-not-installed" not in found
