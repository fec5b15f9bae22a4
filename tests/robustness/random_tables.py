"""Random tables of text in random dialects, written from known arrays without any of the code that reads them."""

import dataclasses
import unicodedata
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
from random_dialects import BLANKS, STAMPS, Dialect

PREFIXES = {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9, "k": 1e3, "c": 1e-2}
UNITS = {
    f"{prefix}{unit}": (unit, factor) for unit in ("s", "V", "A", "N") for prefix, factor in PREFIXES.items()
}
UNITS |= {
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "mm/s": ("m/s", 1e-3),
    "min": ("s", 60.0),
    "": ("", 1.0),
    "1": ("", 1.0),
}
"""Unit as an answer spells it, with the SI unit and the factor to it."""
QUANTITIES = (
    (("Force", "Kraft", "Load"), ("Normal force", "Friction force X", "Load cell 2"), ("N", "mN")),
    (
        ("Voltage", "Spannung", "Ch1"),
        ("Electric potential", "Channel 1 voltage", "Drive out"),
        ("V", "mV", "kV"),
    ),
    (("Current", "Strom"), ("Leakage current", "Current into plate"), ("A", "mA", "uA", "nA")),
    (("Displacement", "Weg"), ("Probe position", "Depth of indenter"), ("mm", "um")),
    (("Speed",), ("Sliding speed",), ("mm/s",)),
)
ODD_NAMES = (
    "Re(Z)",
    "V(out)",
    "I(V1)",
    "tan Delta",
    "Tan(Delta)",
    "COF",
    "Eps'",
    "Eps''",
    "V(n001,n002)",
    "F_N",
)


@dataclass(frozen=True, kw_only=True)
class Written:
    """A column as it was written: what it is called, the SI values that it stands for; NaN is missing."""

    name: str
    unit: str
    values: np.ndarray
    role: str = "number"
    clock: str = ""
    factor: float = 1.0

    @property
    def written(self) -> np.ndarray:
        """The values in the unit in which they are written."""
        return self.values / self.factor


@dataclass(frozen=True, kw_only=True)
class Table:
    """A text and what it says: for each segment its columns, and the seconds of the rows where the file states them."""

    raw: bytes
    dialect: Dialect
    segments: list[list[Written]] = field(default_factory=list)


def write(dialect: Dialect, seed: int) -> Table:
    """Write a table from arrays that the seed decides."""
    random = np.random.default_rng([seed, 41])
    build = _Builder(dialect, random)
    pieces, segments = [], []
    for number in range(dialect.segments):
        rows, columns = build.segment()
        label = [f"Segment {number + 1}"] if dialect.labelled and dialect.segments > 1 else []
        pieces += [*label, *rows]
        segments.append(columns)
    text = dialect.newline.join([*build.preamble(), *pieces])
    text += {"newline": dialect.newline, "none": "", "blank lines": dialect.newline * 3}[dialect.end]
    try:
        raw = text.encode(dialect.encoding)
    except UnicodeEncodeError:
        raw = text.encode("utf-8")
    return Table(raw=raw, dialect=dialect, segments=segments)


class _Builder:
    """The writing of one table."""

    def __init__(self, dialect: Dialect, random: np.random.Generator) -> None:
        self.dialect, self.random = dialect, random
        chosen = random.permutation(len(QUANTITIES))[: dialect.columns]
        self.quantities = [QUANTITIES[at] for at in sorted(chosen)]
        self.names = [self._name(quantity) for quantity in self.quantities]
        self.units_of = [str(random.choice(quantity[2])) for quantity in self.quantities]
        if dialect.headings == "odd":
            self.names = [str(name) for name in random.permutation(ODD_NAMES)[: dialect.columns]]
            self.units_of = ["" if random.random() < 0.5 else unit for unit in self.units_of]
        if dialect.same_name and dialect.columns > 1:
            self.names[1], self.units_of[1] = self.names[0], self.units_of[0]
        if dialect.units == "none":
            self.units_of = [""] * dialect.columns

    def _name(self, quantity: tuple[tuple[str, ...], ...]) -> str:
        return str(self.random.choice(quantity[1 if self.dialect.headings == "several" else 0]))

    def segment(self) -> tuple[list[str], list[Written]]:
        """Return the lines of one segment and what it says."""
        dialect = self.dialect
        columns = self._time() + self._numbers()
        if dialect.time == "second time":
            unit, half = "" if dialect.units == "none" else "s", np.arange(dialect.rows) * dialect.step / 2
            second = self._number_column("Time B", unit, half, digits=7, role="time")
            last = columns.pop()
            columns += [second, (dataclasses.replace(last[0], clock="Time B"), last[1])]
        if dialect.words:
            written = Written(name="State", unit="", values=np.full(dialect.rows, np.nan), role="words")
            columns.append((written, ["OK" if at % 3 else "wait" for at in range(dialect.rows)]))
        lines = self._headings([column for column, _ in columns])
        for at in range(dialect.rows):
            lines.append(self._line([cells[at] for _, cells in columns], quoted=dialect.quotes == "all"))
        for word in dialect.statistics:
            others = [self._text(self._of(word, column), 3) for column, _ in columns[1:]]
            lines.append(self._line([word, *others], quoted=dialect.quotes == "all"))
        return lines, [column for column, _ in columns]

    @staticmethod
    def _of(word: str, column: Written) -> float:
        """Return a statistic of the values as they are written."""
        known = column.written[np.isfinite(column.written)]
        found = {"Max": np.max, "Min": np.min, "Std": np.std}.get(word[:3], np.mean)
        return float(found(known)) if known.size else 0.0

    def _time(self) -> list[tuple[Written, list[str]]]:
        dialect = self.dialect
        seconds = np.arange(dialect.rows) * dialect.step
        name = "Elapsed time" if dialect.headings == "several" else "Time"
        match dialect.time:
            case "none":
                return []
            case "step":
                counted = np.arange(dialect.rows, dtype=float)
                column = Written(name="Sample", unit="", values=counted, role="index")
                return (
                    [(column, [str(at) for at in range(dialect.rows)])] if self.random.random() < 0.5 else []
                )
            case "seconds" | "second time":
                unit = "" if dialect.units == "none" else "s"
                return [self._number_column(name, unit, seconds, digits=6, role="time")]
            case "ms" | "us" | "min" as unit:
                digits = 9 if unit == "min" else 3
                return [self._number_column(name, unit, seconds / UNITS[unit][1], digits=digits, role="time")]
        return self._stamps(name, seconds)

    def _stamps(self, name: str, seconds: np.ndarray) -> list[tuple[Written, list[str]]]:
        """Return the times of the rows as moments; where the offset from UTC changes, it does so after one second."""
        dialect = self.dialect
        begin = datetime(2026, 3, 29, 0, 59, 59, tzinfo=UTC)
        moments = [begin + timedelta(microseconds=round(1e6 * each)) for each in seconds]
        if dialect.time == "iso offset":
            change = begin + timedelta(seconds=1)
            zones = [timezone(timedelta(hours=2 if each >= change else 1)) for each in moments]
            moments = [each.astimezone(zone) for each, zone in zip(moments, zones, strict=True)]
        cells = [_moment(each, STAMPS[dialect.time]) for each in moments]
        if dialect.decimal == "," != dialect.delimiter and dialect.time in ("clock", "mm:ss"):
            cells = [cell.replace(".", ",") for cell in cells]
        written = Written(name=name, unit="s", values=seconds, role="stamps")
        if dialect.time != "date and clock":
            return [(written, cells)]
        dates = [f"{each:%d/%m/%Y}" for each in moments]
        return [(dataclasses.replace(written, name="Date"), dates), (written, cells)]

    def _numbers(self) -> list[tuple[Written, list[str]]]:
        dialect, found = self.dialect, []
        for at, (name, unit) in enumerate(zip(self.names, self.units_of, strict=True)):
            size = (
                10.0 ** self.random.integers(3, 6)
                if dialect.thousands
                else 10.0 ** self.random.integers(0, 3)
            )
            values = size * self.random.uniform(-1, 1, dialect.rows)
            missing = np.zeros(dialect.rows, dtype=bool)
            if dialect.missing is not None and at == dialect.columns - 1:
                first = 0 if dialect.rows < 12 else int(self.random.integers(1, 4))
                missing[first :: 2 if dialect.rows < 4 else 4] = True
                if dialect.missing.startswith("-999"):
                    values = np.abs(values) % 100 + 1
            filled = None
            if dialect.shorter and at == dialect.columns - 1:
                filled = dialect.rows - int(self.random.integers(1, dialect.rows // 3))
            found.append(
                self._number_column(name, unit, values, digits=dialect.digits, missing=missing, filled=filled)
            )
        return found

    def _number_column(
        self, name, unit, values, *, digits, role="number", missing=None, filled=None
    ) -> tuple[Written, list[str]]:
        """Return a column with its cells; the values are those of the digits that are written."""
        dialect, cells, known = self.dialect, [], []
        for at, value in enumerate(values):
            if filled is not None and at >= filled:
                cells.append("")
                known.append(np.nan)
            elif missing is not None and missing[at]:
                numeric = dialect.missing[-1:].isdigit()
                cells.append(dialect.missing.replace(".", dialect.decimal) if numeric else dialect.missing)
                known.append(np.nan)
            elif dialect.units == "mixed cells" and unit in UNITS and unit:
                factor, prefix = (1e3, "m") if abs(value) < 1 and unit in ("s", "V", "A", "N") else (1.0, "")
                digit = round(value * factor, digits)
                cells.append(f"{self._text(digit, digits)} {self._spelt(prefix + unit)}")
                known.append(float(f"{digit:.{digits}f}") / factor)
            else:
                plain = self._decimal(value, digits)
                known.append(float(plain.replace("D", "E")))
                unit_in_cell = f" {self._spelt(unit)}" if dialect.units == "cells" and unit else ""
                cells.append(self._dressed(plain) + unit_in_cell)
        kind, factor = UNITS[unit]
        return Written(name=name, unit=kind, values=np.array(known) * factor, role=role, factor=factor), cells

    def _decimal(self, value: float, digits: int) -> str:
        match self.dialect.number:
            case "general":
                return f"{value:.{digits + 4}g}"
            case "scientific":
                return f"{value:.{digits + 3}E}"
            case "fortran":
                return f"{value:.{digits + 3}E}".replace("E", "D")
            case "integers":
                return f"{value:.0f}"
            case "plus":
                return f"{value:+.{digits}f}"
        return f"{value:.{digits}f}"

    def _text(self, value: float, digits: int) -> str:
        return self._dressed(f"{value:.{digits}f}")

    def _dressed(self, plain: str) -> str:
        """Return a decimal number with the signs of the dialect."""
        dialect = self.dialect
        sign = plain[0] if plain[0] in "+-" else ""
        whole, point, rest = plain.removeprefix(sign).partition(".")
        if dialect.thousands and whole.isdigit():
            whole = _grouped(whole, dialect.thousands)
        body = whole + (dialect.decimal if point else "") + rest
        if dialect.decimal == ",":
            body = body.replace(".", ",") if not dialect.thousands else body
        if dialect.minus == "brackets":
            return f"({body})" if sign == "-" else body
        if dialect.minus == "apart":
            return f"{sign or '+'} {body}"
        return sign.replace("-", dialect.minus) + body

    def _spelt(self, unit: str) -> str:
        return unit.replace("u", self.dialect.mu) if unit.startswith("u") else unit

    def _headings(self, columns: list[Written]) -> list[str]:
        dialect = self.dialect
        if dialect.headings == "none":
            return []
        names, units = [], []
        for column in columns:
            unit = self._unit_of(column)
            form = {"brackets": "{} [{}]", "parentheses": "{} ({})", "slash": "{} / {}"}.get(
                dialect.units, "{}"
            )
            if dialect.delimiter == " ":
                form = form.replace(" ", "")
            names.append(form.format(column.name, unit) if unit else column.name)
            units.append(f"[{unit}]" if dialect.units == "row in brackets" and unit else unit)
        if dialect.delimiter == " ":
            names = [name.replace(" ", "_") for name in names]
            units = [unit or "-" for unit in units]
        elif dialect.delimiter == "  ":
            units = [unit or "-" for unit in units]
        quoted = dialect.quotes != "none" or any(
            dialect.delimiter in name for name in names if dialect.delimiter == ","
        )
        lines = [self._line(names, quoted=quoted, heading=True)]
        if dialect.units.startswith("row") and any(unit not in ("", "-") for unit in units):
            lines.append(self._line(units, quoted=quoted, heading=True))
        return [f"{dialect.mark} {line}" if dialect.mark else line for line in lines]

    def _unit_of(self, column: Written) -> str:
        """Return the unit as it is written for a column of numbers."""
        if column.role in ("stamps", "words", "index") or self.dialect.units in (
            "none",
            "cells",
            "mixed cells",
        ):
            return ""
        if column.role == "time":
            return self._spelt(
                self.dialect.time
                if self.dialect.time in ("ms", "us", "min") and column.name != "Time B"
                else "s"
            )
        return self._spelt(self.units_of[self.names.index(column.name)])

    def _line(self, cells: list[str], *, quoted: bool, heading: bool = False) -> str:
        dialect = self.dialect
        if quoted:
            cells = [f'"{cell}"' for cell in cells]
        if dialect.delimiter == "  ":
            return "".join(f"{cell:<26}  " for cell in cells).rstrip()
        end = (
            dialect.delimiter
            if dialect.trailing == "all" or (dialect.trailing == "rows" and not heading)
            else ""
        )
        return (dialect.delimiter + " " * dialect.padded).join(cells) + end

    def preamble(self) -> list[str]:
        """Return the lines above the table."""
        dialect = self.dialect
        rate = f"{1 / dialect.step:g}{self.random.choice([' Hz', 'S/s'])}"
        settings = [
            ("Model", "DX-120"),
            ("Date", "2026-11-28 10:00:00"),
            ("Sampling rate", rate),
            ("Range CH1", "10 V"),
        ]
        if dialect.time == "step":
            step = f"{dialect.step:.6f}".replace(".", dialect.decimal)
            settings.append(
                ("Sample interval [s]", f'"{step}"' if dialect.decimal == dialect.delimiter else step)
            )
        match dialect.preamble:
            case "none":
                return []
            case "settings":
                sign = "\t" if dialect.delimiter in BLANKS else dialect.delimiter
                return [f"{key}{sign}{value}" for key, value in settings]
            case "colon":
                return [f"{key}: {value}" for key, value in settings] + [""]
            case "equals":
                return [f"{key}={value}" for key, value in settings]
            case "sep=":
                return [] if dialect.delimiter in BLANKS else [f"sep={dialect.delimiter}"]
        return [f"{dialect.preamble} {key}: {value}" for key, value in settings]


def _moment(moment: datetime, form: str) -> str:
    """Return a moment in a form; an offset is written with a colon."""
    text = moment.strftime(form)
    return f"{text[:-2]}:{text[-2:]}" if form.endswith("%z") else text


def _grouped(whole: str, separator: str) -> str:
    """Return the digits of a whole number in groups of three, or those of India."""
    head, last = (whole[:-3], whole[-3:]) if len(whole) > 3 else ("", whole)
    if separator == "lakh":
        groups = [head[max(0, end - 2) : end] for end in range(len(head), 0, -2)][::-1]
        return ",".join([*groups, last])
    groups = [head[max(0, end - 3) : end] for end in range(len(head), 0, -3)][::-1]
    return separator.join([*groups, last])


def plain_name(name: str) -> str:
    """Return a name in a form in which spellings of one name agree."""
    return " ".join(unicodedata.normalize("NFKC", name).replace("_", " ").strip('" #%').casefold().split())
