"""What is stated: units of signals from their names alone, checks against sources, diagnostics, equations, versions."""

import math
import platform
from importlib.metadata import version
from typing import Annotated

import numpy as np
import pytest

from electrovib.core import versions
from electrovib.core.citation import STATUSES, UNVERIFIED, Check, status_text
from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.formulas import formula_lines
from electrovib.core.model import Model, read_model
from electrovib.core.quantity import column_unit, is_unit_of
from electrovib.core.signals import FORMAT, SIGNALS, make_trace, signal, stamp
from electrovib.core.units import KINDS


def test_every_signal_has_a_known_unit_and_a_meaning_of_its_own():
    for name, known in SIGNALS.items():
        assert name.isidentifier()
        assert name == name.lower()
        assert known.unit in KINDS, name
        assert known.doc
    endings = ("_v", "_mv", "_n", "_mn", "_s", "_ms", "_us", "_hz", "_khz", "_pa")
    assert not [name for name in SIGNALS if name.endswith(endings)]
    assert len({known.doc for known in SIGNALS.values()}) == len(SIGNALS)
    assert signal("electrostatic_force").unit == "N"
    with pytest.raises(ElectrovibError, match="Did you mean 'electrostatic_force'"):
        signal("electrostatic_forse")


@pytest.fixture
def made():
    variables = {
        "drive_voltage": (("time",), np.array([0.0, 1.0])),
        "field": (("layer", "time"), np.ones((1, 2))),
    }
    places = {"time": np.array([0.0, 1.0]), "layer": np.array(["gap"], dtype=object)}
    return make_trace(variables, places, {"solver": "by hand"})


def test_a_trace_is_stamped(made):
    assert made.drive_voltage.attrs["units"] == "V"
    assert made.drive_voltage.attrs["long_name"] == "voltage of the drive"
    assert made.time.attrs["units"] == "s"
    assert "units" not in made.layer.attrs
    assert made.attrs["format"] == FORMAT
    assert made.attrs["solver"] == "by hand"
    with pytest.raises(ElectrovibError, match="Did you mean 'drive_voltage'"):
        make_trace({"drive_voltag": (("time",), np.zeros(1))}, {"time": np.zeros(1)}, {})


def test_a_stamp_is_that_of_the_name_and_leaves_the_original_and_other_names_alone(made):
    made["drive_voltage"] = made.drive_voltage**2
    made["drive_voltage"].attrs["units"] = "V^2"
    made["mine"] = ("time", np.zeros(2), {"units": "furlong"})
    stamped = stamp(made)
    assert stamped.drive_voltage.attrs["units"] == "V"
    assert made.drive_voltage.attrs["units"] == "V^2"
    assert stamped.mine.attrs == {"units": "furlong"}


class Column(Model):
    """A column of this test."""

    unit: Annotated[str, column_unit("s")] = "s"


@pytest.mark.parametrize(
    ("kind", "units", "others"),
    [("s", ["us", "µs"], ["V", "", "3 us", 5]), ("1", ["1", "-", "%"], ["V"]), ("V/m", ["kV/mm"], ["V"])],
)
def test_the_unit_of_a_files_column(kind, units, others):
    assert all(is_unit_of(kind, text) for text in units)
    assert not any(is_unit_of(kind, text) for text in others)
    assert read_model(Column, {"unit": "ms"}).unit == "ms"
    with pytest.raises(InputError, match="the column holds a time: expected a unit such as 's'"):
        read_model(Column, {"unit": "V"})


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
    assert len({status_text(status) for status in STATUSES}) == len(STATUSES) == 6
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
