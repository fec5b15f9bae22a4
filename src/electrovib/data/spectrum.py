"""A spectrum of impedance or permittivity from a table with the headings that instruments write.

An impedance is stated by any pair of columns of `_PAIRS`. The modes of a meter of inductance, capacitance and
resistance, with the angular frequency w:

- parallel: Y = G + j B = G + j w Cp, where G = 1 / Rp = w Cp D and D = 1 / Q;
- series: Z = Rs + 1 / (j w Cs), where D = w Cs Rs.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, refuse
from electrovib.core.units import number_in
from electrovib.data.unit_words import kind_and_factor, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Complex, Real
    from electrovib.data.recorded import DataColumn, Recorded

_PREFIX: Final = re.compile(r"(trace( \d+)?|impedance) (?=\S)")
"""Beginning of a heading that states no meaning, as impedance analysers write it."""
_MEANINGS: Final[Mapping[str, tuple[str, str]]] = {
    "frequency": ("Hz", r"f|fr|freq.*|hz|hertz"),
    "angular_frequency": ("", r"w|omega|angular frequency"),
    "modulus": (
        "ohm",
        r"\|z\||z|zmod|zabs|mod(ulus)?( ?z)?|mag(nitude)?.*|impedance|abs\(?z?\)?|\|impedance\|",
    ),
    "phase": ("rad", r"phase.*|phi|theta(-z)?|θ|angle|zphz|arg.*|deg(ree)?s?"),
    "real": ("ohm", r"z'|zre(al)?|re\(?z?\)?|re\(z\)|real(?!.*permittivity).*|z real|r|resistance|zreal"),
    "imaginary": ("ohm", r"z''|z\"|zim(a?g)?|im\(?z?\)?|im\(z\)|imag(?!.*permittivity).*|z imag|x|reactance"),
    "admittance": ("S", r"\|y\||y|ymod|yabs|abs\(?y\)?|\|?admittance\|?"),
    "conductance": ("S", r"g|gp|conductance|y'|yre(al)?|re\(?y\)?"),
    "susceptance": ("S", r"b|bp|susceptance|y''|y\"|yim(ag)?|im\(?y\)?"),
    "parallel_capacitance": ("F", r"c[- ]?p|(parallel capacitance|capacitance parallel)"),
    "series_capacitance": ("F", r"c[- ]?s|(series capacitance|capacitance series)"),
    "parallel_resistance": ("ohm", r"r[- ]?p|(parallel resistance|resistance parallel)"),
    "series_resistance": ("ohm", r"r[- ]?s|esr|(equivalent )?series resistance|resistance series"),
    "quality": ("1", r"q|quality( factor)?"),
    "permittivity": (
        "1",
        r"((real|relative) )*(part of )?(the )?((relative|real) )*permittivity( real|')?|(eps(ilon)?|ε) ?r?'?|er'?"
        r"|dielectric constant",
    ),
    "loss": (
        "1",
        r"(dielectric )?loss( factor| index)?|(eps(ilon)?|ε) ?r?('{2}|\")|er('{2}|\")"
        r"|imag(inary)?\.? (part of )?(the )?(relative )?permittivity|permittivity (imag(inary)?|'{2})",
    ),
    "loss_tangent": (
        "1",
        r"loss tangent|tan ?\(?(δ|delta|d)\)?|tan|tangent( delta)?|dissipation( factor)?|d",
    ),
    "conductivity": ("S/m", r"((total|ac|electrical|effective) )*conductivity( ac)?|(sigma|σ|kappa|κ)'?"),
    "resistivity": ("ohm m", r"((electrical|effective|specific) )*resistivity|specific resistance|rho|ρ"),
}
"""Maps a meaning to its SI unit and the pattern of its headings, in small letters, without unit, sign and underscores."""
_MINUS: Final = re.compile(r"(?:[-\N{MINUS SIGN}\N{EN DASH}] ?|minus |neg(?:ative|\.)? )(?=\S)")
_SIGNED: Final = ("phase", "real", "imaginary", "susceptance")
"""Meanings whose negative a column may state, as ``minus_phase``."""
_INDUCTANCE: Final = re.compile(r"l[- ]?[ps]|(parallel |series )?inductance")
_TIMES_AREA: Final = {"ohm": "ohm m2", "S": "S/m2"}
_PAIRS: Final[Mapping[tuple[str, str], Callable[[Real, Real, Real], Any]]] = {
    ("modulus", "phase"): lambda _, size, phase: size * np.exp(1j * phase),
    ("real", "imaginary"): lambda _, real, imaginary: real + 1j * imaginary,
    ("admittance", "phase"): lambda _, size, phase: 1 / (size * np.exp(1j * phase)),
    ("conductance", "susceptance"): lambda _, g, b: 1 / (g + 1j * b),
    ("parallel_capacitance", "conductance"): lambda w, c, g: 1 / (g + 1j * w * c),
    ("parallel_capacitance", "parallel_resistance"): lambda w, c, r: 1 / (1 / r + 1j * w * c),
    ("parallel_capacitance", "loss_tangent"): lambda w, c, d: 1 / (w * c * (d + 1j)),
    ("parallel_capacitance", "quality"): lambda w, c, q: 1 / (w * c * (1 / q + 1j)),
    ("series_capacitance", "series_resistance"): lambda w, c, r: r + 1 / (1j * w * c),
    ("series_capacitance", "loss_tangent"): lambda w, c, d: (d - 1j) / (w * c),
    ("series_capacitance", "quality"): lambda w, c, q: (1 / q - 1j) / (w * c),
}
"""Pairs of columns that state an impedance, to the impedance as a function of the angular frequency and both."""
_LOSSES: Final[Mapping[tuple[str, str], Callable[[Real, Real, Real], Any]]] = {
    ("permittivity", "loss"): lambda _, real, loss: real - 1j * loss,
    ("permittivity", "loss_tangent"): lambda _, real, tangent: real * (1 - 1j * tangent),
    ("permittivity", "conductivity"): lambda w, real, sigma: real - 1j * sigma / (w * eps0),
    ("permittivity", "resistivity"): lambda w, real, rho: real - 1j / (w * eps0 * rho),
}
"""Pairs of columns that state a permittivity with its loss, in the same form."""
_APART: Final = 0.02
"""Relative difference of two statements of the loss beyond which they contradict each other."""
_NAME: Final = re.compile(r"(?:(.+), )?spectrum (\d{1,4})")
FEWEST: Final = 4
"""Fewest rows of a spectrum; a table with shorter ones is in no order of frequencies."""
_MOST_NAMED: Final = 20


@dataclass(frozen=True, kw_only=True)
class MeasuredSpectrum:
    """A spectrum in SI, over a frequency that increases.

    - `permittivity`: relative, eps' - j eps'', conduction included.
    - `lossless`: whether the table gives a permittivity without loss, which is then taken for 0.
    - `read_as`: meaning of each column that was used.
    - `among`: which of several spectra of the table it is, and which others there are; empty where there is
      one.
    - `times_area`: whether the impedance is that of an area of 1 m2 [ohm m2].
    """

    frequency: Real
    impedance: Complex | None
    permittivity: Complex | None
    lossless: bool
    read_as: str
    among: str = ""
    phase_unit: str = ""
    times_area: bool = False


def spectrum_of(
    recorded: Recorded,
    *,
    columns: Mapping[str, str] | None = None,
    spectrum: int = 0,
    phase_unit: str = "",
    scale: Mapping[str, str | float] | None = None,
) -> MeasuredSpectrum:
    """Find frequency and impedance, or permittivity, among the columns of a table, sorted by frequency.

    `columns` maps a meaning to its heading, with a unit behind it where the file states none: ``"Phase
    [deg]"``; what it lacks is found by the headings. `spectrum` counts several spectra from 1; 0 takes the
    first. Rows of the frequency 0, which a potentiostat writes for samples over time, and of an impedance of
    0 are omitted. Of the pairs of columns that state an impedance (see the module) those that `columns`
    names are read, and the one with most rows other than 0 is taken, of equal ones the first. ``minus_phase``,
    ``minus_imaginary`` and so on are meanings of columns that state a negative, and `scale` maps a meaning to
    a factor. A phase without a unit is in degrees if any value is beyond 2 pi, and otherwise refused unless
    its heading, `columns` or `phase_unit` states the unit. Where several columns state the loss, the first of
    loss factor, loss tangent, conductivity and resistivity is taken. A difference of more than 2 % between
    two statements of the loss, or of the impedance, is refused.
    """
    stated = _assigned(recorded, columns or {})
    found = _scaled(stated, columns or {}, scale or {})
    if "frequency" in found:
        grid = _in_si(found["frequency"], "Hz")
    elif "angular_frequency" in found:
        grid = found["angular_frequency"].values / (2 * math.pi)
    else:
        raise _no_spectrum(recorded, "no column is the frequency")
    unit, is_permittivity = "", "permittivity" in found
    sizes = [] if is_permittivity else [found[each] for each in ("modulus", "admittance") if each in found]
    if "phase" in found and any(each.values.any() for each in sizes):
        unit = _unit_of_phase(found["phase"], phase_unit)
        found["phase"] = dataclasses.replace(found["phase"], unit=unit)
    pairs = _LOSSES if is_permittivity else _PAIRS
    values, times_area = _by_pairs(pairs, found, 2 * math.pi * grid, set(columns or {}))
    if lossless := is_permittivity and values is None:
        values = _in_si(found["permittivity"], "1").astype(complex)
    if values is None:
        raise _no_spectrum(recorded, _missing(recorded))
    good = np.isfinite(grid) & np.isfinite(values) & (grid != 0) & (values != 0)
    rows, words = chosen_sweep(grid, spectrum)
    good &= np.isin(np.arange(grid.size), rows) | (grid < 0)
    if good.sum() < 2 or (grid[good] <= 0).any():
        raise InputError("frequency: expected two or more numbers above 0")
    order = np.flatnonzero(good)[np.argsort(grid[good], kind="stable")]
    return MeasuredSpectrum(
        frequency=grid[order],
        impedance=None if is_permittivity else values[order],
        permittivity=values[order] if is_permittivity else None,
        lossless=lossless,
        read_as=_read_as(recorded, stated, scale or {}),
        among=words,
        phase_unit=unit,
        times_area=times_area,
    )


def _by_pairs(
    pairs: Mapping[tuple[str, str], Callable[[Real, Real, Real], Any]],
    found: Mapping[str, DataColumn],
    angular_frequency: Real,
    stated: set[str],
) -> tuple[Complex | None, bool]:
    """Return what the pair of columns states that is named, or filled most, and whether it is an impedance times an area."""
    there = [pair for pair in pairs if found.keys() >= set(pair) and found[pair[0]].values.any()]
    named = {pair: sum(name in stated or f"minus_{name}" in stated for name in pair) for pair in there}
    values: dict[str, Complex] = {}
    times_area: set[bool] = set()
    for pair in (each for each in there if named[each] == max(named.values())):
        columns, units = [found[name] for name in pair], [_MEANINGS[name][0] for name in pair]
        words = " and ".join(f"'{each.name}'" for each in columns)
        if units[0] == units[1] != "1" and bool(columns[0].unit) != bool(columns[1].unit):
            raise InputError(
                f"columns: of {words} one has a unit; state that of the other, such as 'Z [ohm]'"
            )
        area = any(_kind(each) in _TIMES_AREA.values() for each in columns)
        units = [_TIMES_AREA.get(unit, unit) for unit in units] if area else units
        first, second = (_in_si(each, unit) for each, unit in zip(columns, units, strict=True))
        if pair[1] == "resistivity" and (second <= 0).any():
            raise InputError(f"column '{columns[1].name}': a resistivity has to be above 0")
        if pair == ("real", "imaginary") and not np.nan_to_num(second).any():
            raise InputError(
                f"columns: '{columns[1].name}' is 0 in every row, so {words} are a magnitude or one trace of two, no impedance:"
                " choose another table with part (--set part=TABLE), or save R-X or |Z| and its phase in one table"
            )
        with np.errstate(all="ignore"):  # rows that are not finite are omitted later
            each = np.asarray(pairs[pair](angular_frequency, first, second))
        values[words] = np.where(np.isfinite(each) & (each != 0), each, np.nan)
        times_area.add(area)
    if len(times_area) > 1:
        raise InputError("columns: some are an impedance, others one times an area; state which to read")
    _refuse_contradiction({words: each.imag if pairs is _LOSSES else each for words, each in values.items()})
    best = max(values.values(), key=lambda each: int(np.isfinite(each).sum()), default=None)
    return best, True in times_area


def _missing(recorded: Recorded) -> str:
    """State what a table lacks that holds a frequency."""
    if coil := next((each.name for each in recorded.channels if _INDUCTANCE.fullmatch(_heading(each))), ""):
        return f"'{coil}' is an inductance, which no dielectric has: set the meter to Cp-D or R-X and measure again"
    pairs = "modulus and phase, nor real and imaginary part, nor Cp or Cs with D, Q, G, Rp or Rs, nor G and B"
    return f"neither {pairs}, nor a permittivity is there"


def _read_as(recorded: Recorded, found: Mapping[str, DataColumn], scale: Mapping[str, str | float]) -> str:
    """Name the columns that were used, with their meaning and factor, and those that were not."""
    used = {channel.name for channel in found.values()}
    words = ", ".join(
        f"{meaning}: '{channel.name}'" + (f" times {scale[meaning]}" if meaning in scale else "")
        for meaning, channel in found.items()
    )
    unused = ", ".join(f"'{each.name}'" for each in recorded.channels if each.name not in used)
    return f"{words}; columns not used: {unused}" if unused else words


def _heading(channel: DataColumn) -> str:
    """Return a heading in small letters, without underscores and what analysers write before it."""
    heading = re.sub(r"\s+", " ", channel.name.lower().replace("_", " ").replace("/", " ")).strip()
    return _PREFIX.sub("", heading)


def _scaled(
    found: Mapping[str, DataColumn], columns: Mapping[str, str], scale: Mapping[str, str | float]
) -> dict[str, DataColumn]:
    """Return the columns by meaning without minus, times the stated factors, and turned where the meaning has a minus.

    A heading with a minus for which `columns` states a meaning without one needs a factor.
    """
    problems = [
        f"columns.{meaning} = '{columns[meaning]}': the heading states a minus; state columns = minus_{meaning}, or"
        f" scale.{meaning} (1 if the minus means nothing)"
        for meaning in _SIGNED
        if meaning in columns and meaning not in scale and _MINUS.match(_heading(found[meaning]))
    ]
    factors = {meaning: number_in("1", f"scale.{meaning}", value) for meaning, value in scale.items()}
    for meaning, factor in factors.items():
        if meaning not in found or not factor:
            why = "expected a number other than 0" if not factor else f"the spectrum has {', '.join(found)}"
            problems.append(f"scale.{meaning} = {factor:g}: {why}")
    refuse(problems)
    whole: dict[str, DataColumn] = {}
    for meaning in sorted(found, key=lambda each: each.startswith("minus_")):
        factor = factors.get(meaning, 1.0) * (-1 if meaning.startswith("minus_") else 1)
        turned = dataclasses.replace(found[meaning], values=found[meaning].values * factor)
        whole.setdefault(meaning.removeprefix("minus_"), turned)
    return whole


def _assigned(recorded: Recorded, columns: Mapping[str, str]) -> dict[str, DataColumn]:
    """Return the column of each meaning: as stated, else by its heading."""
    by_name = {each.name: each for each in recorded.channels}
    for stated in set(columns.values()) - set(by_name):
        name, unit = name_and_unit(stated)
        if unit and name in by_name:
            by_name[stated] = dataclasses.replace(by_name[name], unit=unit)
    problems = [
        f"columns.{meaning} = '{name}': the file has no such column; it has {', '.join(by_name)}"
        for meaning, name in columns.items()
        if name not in by_name
    ] + [
        f"columns: '{meaning}' is not among {', '.join((*_MEANINGS, *(f'minus_{each}' for each in _SIGNED)))}"
        for meaning in columns
        if meaning not in _MEANINGS and meaning.removeprefix("minus_") not in _SIGNED
    ]
    refuse(problems)
    found = {meaning: by_name[name] for meaning, name in columns.items()}
    for channel in recorded.channels:
        heading = _heading(channel)
        minus = "minus_" if _MINUS.match(heading) else ""
        heading = _MINUS.sub("", heading, count=1) if minus else heading
        for meaning in _SIGNED if minus else _MEANINGS:
            if (
                minus + meaning not in found
                and all(channel.name != each.name for each in found.values())
                and re.fullmatch(_MEANINGS[meaning][1], heading)
                and not (heading == "d" and channel.unit not in ("", "1", "%"))  # a thickness or a diameter
            ):
                found[minus + meaning] = channel
    used = {channel.name for channel in found.values()}
    left = [each for each in recorded.channels if each.name not in used]
    # beside a permittivity these are known by their units, whatever their headings are
    for meaning in ("conductivity", "resistivity") if "permittivity" in found else ():
        alike = [each for each in left if _kind(each) == _MEANINGS[meaning][0]]
        if meaning not in found and len(alike) == 1:
            found[meaning] = alike[0]
    return found


def _no_spectrum(recorded: Recorded, why: str) -> InputError:
    listed = ", ".join(f"'{each.name}'" for each in recorded.channels)
    how = "state what they are, such as frequency: 'COLUMN' (--column frequency=COLUMN)"
    return InputError(f"columns: {why}; the file has {listed}; {how}")


def _kind(channel: DataColumn) -> str:
    """Return the SI unit of the kind to which the unit of a column belongs; empty where none is known."""
    return (kind_and_factor(channel.unit) or ("",))[0]


def _in_si(channel: DataColumn, unit: str) -> Real:
    """Convert a column from its unit, which is the SI unit where the file states none."""
    written = channel.unit
    if unit == "S" and written.endswith("s"):  # a conductance is in no seconds
        written = f"{written[:-1]}S"
    if unit == "1" and written.lower() in ("delta", "δ"):  # of the heading tan(delta)
        written = "1"
    per = eps0 if unit == "1" and written.endswith("F/m") else 1.0  # a permittivity that is not relative
    written, expected = (written.removesuffix("/m"), "F") if per == eps0 else (written, unit)
    if unit == "F" and not written and np.nanmax(np.abs(channel.values), initial=0) >= 1e-3:
        raise InputError(
            f"column '{channel.name}': farads are not likely; state its unit, such as '{channel.name} [pF]'"
        )
    known = kind_and_factor(written) if written else (unit, 1.0)
    if known is None or known[0] != expected:
        raise InputError(f"column '{channel.name}': '{channel.unit}' is not a unit of {unit}")
    return np.asarray(channel.values * (known[1] / per))


def _unit_of_phase(channel: DataColumn, otherwise: str) -> str:
    """Return the unit of a phase: as stated, as its values show, or as it is otherwise known."""
    unit = channel.unit or ("deg" if re.search("deg|°", channel.name.lower()) else "")
    largest = float(np.nanmax(np.abs(channel.values)))
    if not unit and largest > 2 * math.pi:
        unit = "deg"
    if not (unit or otherwise):
        raise InputError(
            f"column '{channel.name}': it may be in degrees or radians; state columns = phase:"
            f" '{channel.name} [deg]' or '{channel.name} [rad]' (--column phase=...)"
        )
    return unit or otherwise


def _refuse_contradiction(statements: Mapping[str, Real | Complex]) -> None:
    """Refuse a table whose statements of the loss or impedance belong to different quantities or units."""
    for (first, one), (noun, other) in itertools.combinations(statements.items(), 2):
        larger = np.maximum(np.abs(one), np.abs(other))
        good = np.isfinite(larger) & (larger > 0)
        apart = float(np.median(np.abs(one - other)[good] / larger[good])) if good.any() else 0.0
        if apart > _APART:
            raise InputError(
                f"{first} differ from {noun} by {apart:.2g} of the larger one: they belong to different quantities or units."
                " State the meaning of the columns, or remove one of the two from the file"
            )


def split_part(part: str | None) -> tuple[str | None, int]:
    """Split a part such as ``"Sheet1, spectrum 2"`` into the table and the number of the spectrum, 0 where none is stated."""
    found = _NAME.fullmatch(part or "")
    return (part, 0) if found is None else (found[1], int(found[2]))


def sweeps_of(frequency: Real) -> list[np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Find the rows of each spectrum in a column of frequencies: a new one begins where the frequency turns back."""
    rows = np.flatnonzero(np.isfinite(frequency) & (frequency > 0))
    changes = np.sign(np.diff(frequency[rows]))
    begins, direction = [0], 0
    for place, change in enumerate(changes, 1):
        if direction and change == -direction:
            # both may hold the frequency of the turn
            begins.append(place if changes[place - 2] else place - 1)
            direction = 0
        elif change:
            direction = int(change)
    found = np.split(rows, begins[1:])
    return found if min(each.size for each in found) >= FEWEST else [rows]


def chosen_sweep(frequency: Real, spectrum: int) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], str]:
    """Return the rows of one spectrum, and what was chosen among several."""
    found = sweeps_of(frequency)
    if spectrum > len(found):
        has = f"{len(found)} spectra, spectrum 1 to spectrum {len(found)}" if len(found) > 1 else "1 spectrum"
        raise InputError(f"part = spectrum {spectrum}: the table has {has}")
    if len(found) == 1:
        return found[0], ""
    number = spectrum or 1
    others = ", ".join(f"spectrum {other}" for other in range(1, len(found) + 1) if other != number)
    if len(found) > _MOST_NAMED:
        others = f"{len(found) - 1} others of spectrum 1 to spectrum {len(found)}"
    return found[number - 1], f"read: spectrum {number}; not read: {others}; choose with --set part=..."
