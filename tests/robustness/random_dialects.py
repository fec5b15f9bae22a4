"""Random dialects of tables of text: delimiter, signs, headings, units, times, and what instruments add."""

import dataclasses
from dataclasses import dataclass

import numpy as np

MARKS = ("9.9E+37", "-9.9E+37", "9.91E+37", "+9.90000000E+37", "9.91e37", "199.999E+99", "OVLD", "OL", "-999", "-999.00",
    "NaN", "nan", "N/A", "#N/A", "---", "****", "Overload", "inf", "-inf", "NULL", "1.#QNAN", "-1.#IND", "")  # fmt: skip
STATISTICS = (
    ("Mean", "Max"),
    ("Mean", "Std"),
    ("Max", "Min", "Mean", "Std"),
    ("Average:",),
    ("Mittelwert", "Maximum"),
)
BLANKS = (" ", "  ")
STAMPS = {"iso": "%Y-%m-%d %H:%M:%S.%f", "iso T": "%Y-%m-%dT%H:%M:%S.%f", "iso Z": "%Y-%m-%dT%H:%M:%S.%fZ",
    "iso offset": "%Y-%m-%dT%H:%M:%S.%f%z", "date.clock": "%d.%m.%Y %H:%M:%S.%f", "date and clock": "%H:%M:%S.%f",
    "clock": "%H:%M:%S.%f", "mm:ss": "%M:%S.%f", "whole seconds": "%H:%M:%S"}  # fmt: skip
"""Forms of moments, by the way in which the times of the rows are written."""


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """How a table is written; the values that are given here are the plain ones."""

    rows: int = 20
    columns: int = 2
    delimiter: str = ","
    decimal: str = "."
    thousands: str = ""
    number: str = "fixed"
    digits: int = 4
    minus: str = "-"
    headings: str = "words"
    units: str = "brackets"
    mark: str = ""
    mu: str = "u"
    time: str = "seconds"
    step: float = 0.01
    missing: str | None = None
    statistics: tuple[str, ...] = ()
    preamble: str = "none"
    segments: int = 1
    labelled: bool = False
    quotes: str = "none"
    trailing: str = "none"
    padded: bool = False
    newline: str = "\n"
    encoding: str = "utf-8"
    shorter: bool = False
    words: bool = False
    same_name: bool = False
    end: str = "newline"


def drawn(random: np.random.Generator) -> Dialect:
    """Draw a dialect in which a table can be written without contradiction; one in five is nearly plain."""
    oddity = 0.25 if random.random() < 0.2 else 1.0

    def one(plain, *others, share=0.12):
        return others[random.integers(len(others))] if random.random() < share * oddity else plain

    delimiter = (",", ";", "\t", "|", " ", "  ")[random.choice(6, p=[0.3, 0.22, 0.22, 0.06, 0.08, 0.12])]
    decimal = one(".", ",", share=0.6 if delimiter in ";\t" else 0.15)
    dots = [sign for sign in (",", ".", "'", "’", " ", "\u00a0", "\u202f", "lakh") if sign != decimal]
    return consistent(
        Dialect(
            rows=int(random.choice([2, 3, 5, 12, 30, 60], p=[0.04, 0.06, 0.1, 0.3, 0.4, 0.1])),
            columns=int(random.integers(1, 5)),
            delimiter=delimiter,
            decimal=decimal,
            thousands=one("", *dots),
            number=one("fixed", "general", "scientific", "integers", "fortran", "plus", share=0.4),
            digits=int(random.choice([1, 2, 3, 4, 6])),
            minus=one("-", "\u2212", "apart", "brackets", share=0.15),
            headings=one("words", "none", "several", "odd", share=0.4),
            units=one("brackets", "none", "parentheses", "row", "row in brackets", "slash", "cells", "mixed cells", share=0.6),
            mark=one("", "#", "%"),
            mu=one("u", "µ", "μ", share=0.5),
            time=one("seconds", "ms", "us", "min", "step", "second time", "none", *STAMPS, share=0.55),
            step=float(random.choice([1e-5, 1e-3, 0.01, 0.05, 0.5])),
            missing=one(None, *MARKS, share=0.25),
            statistics=one((), *STATISTICS, share=0.08),
            preamble=one("none", "settings", "colon", "equals", "#", "%", "sep=", share=0.4),
            segments=one(1, 2, 3, share=0.08),
            labelled=bool(random.random() < 0.5),
            quotes=one("none", "headings", "all", share=0.2),
            trailing=one("none", "rows", "all"),
            padded=bool(random.random() < 0.1),
            newline=one("\n", "\r\n", share=0.4),
            encoding=one("utf-8", "utf-8-sig", "utf-16", "latin-1", share=0.3),
            shorter=bool(random.random() < 0.06),
            words=bool(random.random() < 0.08),
            same_name=bool(random.random() < 0.04),
            end=one("newline", "none", "blank lines", share=0.3),
        )
    )  # fmt: skip


def consistent(dialect: Dialect) -> Dialect:
    """Return a dialect without choices that contradict each other."""
    for rule in (_headings_of_their_delimiter, _times_of_their_units, _signs_apart, _enough_rows):
        dialect = dataclasses.replace(dialect, **rule(dialect))
    return dialect


def _headings_of_their_delimiter(dialect: Dialect) -> dict[str, object]:
    """Between blanks nothing else may hold a blank; without headings there are no units but those in the cells."""
    headings, units = dialect.headings, dialect.units
    if dialect.delimiter == " ":
        headings = "words" if headings == "several" else headings
        units = "brackets" if units in ("cells", "mixed cells") else units
    if headings == "none" and dialect.time == "second time":
        headings = "words"
    if headings != "none":
        same = dialect.same_name and headings != "odd"  # a prime may be part of a name
        return {"headings": headings, "units": units, "same_name": same}
    units = units if units in ("cells", "mixed cells") else "none"
    return {"headings": "none", "units": units, "mark": "", "segments": 1, "same_name": False}


def _times_of_their_units(dialect: Dialect) -> dict[str, object]:
    """A unit other than the second has to be written, and a step above the table."""
    time = dialect.time
    if dialect.delimiter in BLANKS and time in ("iso", "date.clock", "date and clock"):
        time = "iso T"
    if dialect.units == "none" and time in ("ms", "us", "min"):
        time = "seconds"
    if (dialect.number == "integers" or dialect.units == "mixed cells") and time in ("seconds", "min"):
        time = "none" if dialect.units == "none" else "ms"
    change: dict[str, object] = {"time": time}
    if time in STAMPS or time == "second time":
        change["segments"] = 1
    if time == "step" and dialect.preamble in ("none", "%", "sep="):
        change["preamble"] = "settings"
    if time == "none":
        change["statistics"] = ()
    if time == "ms" and dialect.number == "integers":
        change["step"] = max(1e-3, dialect.step)
    return change


def _signs_apart(dialect: Dialect) -> dict[str, object]:
    """A sign is a delimiter, a decimal sign or a separator, or stands in quotes."""
    change: dict[str, object] = {}
    blank, separator = dialect.delimiter in BLANKS, dialect.thousands
    if {"lakh": ","}.get(separator, separator) == dialect.decimal or dialect.number in (
        "scientific",
        "fortran",
        "general",
    ):
        change["thousands"] = separator = ""
    if blank:
        change |= {"shorter": False, "quotes": "none", "padded": False, "trailing": "none"}
        change |= {"missing": dialect.missing or None}
        change |= {"thousands": ""} if separator in (" ", "\u00a0", "\u202f") else {}
    if dialect.delimiter == " " and dialect.minus == "apart":
        change["minus"] = "-"
    if dialect.delimiter in (dialect.decimal, "," if separator == "lakh" else separator):
        change["quotes"] = "all"
    return change


def _enough_rows(dialect: Dialect) -> dict[str, object]:
    """What shows by repetition needs rows, and two clocks two columns."""
    change: dict[str, object] = {}
    if dialect.time in ("second time", "none", "step", "whole seconds") or dialect.columns == 1:
        change["shorter"] = False
    if dialect.time == "second time":
        change |= {"columns": max(2, dialect.columns), "same_name": False}
        change |= {"number": "fixed"} if dialect.number == "integers" else {}
    if dialect.time == "whole seconds":
        change |= {"rows": max(30, dialect.rows), "step": 0.1}
    elif dialect.missing in ("-999", "-999.00") or change.get("shorter", dialect.shorter):
        change["rows"] = max(12, dialect.rows)
    return change
