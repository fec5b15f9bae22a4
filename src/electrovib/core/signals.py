"""The nomenclature: one name for each signal, with unit, symbol and meaning; a Trace is a Dataset of such signals.

The unit belongs to the name. xarray keeps attributes in arithmetic, so a squared voltage would still have the unit V;
units are therefore written when a Trace is made and when it is saved, and not relied on in between.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeGuard

import numpy as np

from electrovib.core.errors import ElectrovibError, nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray


FORMAT = "electrovib trace 1"
STUDY_FORMAT = "electrovib study"
"""Begin of the format of a study's result."""


def is_trace(source: object) -> TypeGuard[xarray.Dataset]:
    """Return whether an object is a Trace; False without an import of xarray, because no Trace exists then."""
    known = sys.modules.get("xarray")
    return known is not None and isinstance(source, known.Dataset)


def make_trace(
    variables: Mapping[str, tuple[Sequence[str], Any]],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Make a Trace, with ``units`` and ``long_name`` on every signal; structured attributes are JSON text."""
    import pandas as pd
    from xarray import Dataset, Variable

    # xarray imports dask and pint to see whether an array is one of theirs; of an index, and with `fastpath`, it does not ask
    coords = {}
    for name, values in coordinates.items():
        plain = type(values) is np.ndarray
        coords[name] = (name,), pd.Index(values, dtype=values.dtype) if plain else values, _meaning(name)
    found = {}
    for name, (dims, data) in variables.items():
        signal(name)
        found[name] = Variable(dims, data, _meaning(name), fastpath=type(data) is np.ndarray)
    return Dataset(found, coords=coords, attrs={"format": FORMAT, **attributes})


def stamp(trace: xarray.Dataset) -> xarray.Dataset:
    """Return a shallow copy of a Trace with units and meanings of its signals written again, after arithmetic for instance."""
    stamped = trace.copy()
    for name in stamped.variables:
        stamped[name].attrs.update(_meaning(str(name)))
    return stamped


def _meaning(name: str) -> dict[str, str]:
    """Return unit and meaning of a signal; empty for a name outside the nomenclature."""
    if name not in SIGNALS:
        return {}
    known = SIGNALS[name]
    return {"long_name": known.doc} if name == "layer" else {"units": known.unit, "long_name": known.doc}


def is_study_result(found: object) -> bool:
    """Return whether an object is the result of a study of a population: statistics of many fingers, which are no Trace."""
    return str(getattr(found, "attrs", {}).get("format", "")).startswith(STUDY_FORMAT)


@dataclass(frozen=True)
class Signal:
    """Declaration of a signal.

    `unit` is one of `electrovib.core.units.KINDS`; `symbol` is written in mathtext; `dims` are the dimensions
    in the Trace of one scenario, empty for a coordinate.
    """

    unit: str
    symbol: str
    doc: str
    dims: tuple[str, ...] = ("time",)


SIGNALS: Final = {
    # coordinates
    "time": Signal("s", "t", "time", ()),
    "frequency": Signal("Hz", "f", "frequency", ()),
    "layer": Signal("1", "", "layer, from the plate to the finger", ()),
    # over time
    "drive_voltage": Signal("V", "v", "voltage of the drive"),
    "drive_current": Signal("A", "i_d", "current that the drive prescribes"),
    "stack_voltage": Signal(
        "V",
        "v_{stack}",
        "voltage across the layers of the first contact, without source, return path and second contact",
    ),
    "effective_voltage": Signal("V", "v_e", "part of the voltage that attracts the finger"),
    "field": Signal("V/m", "E", "electric field in a layer", ("layer", "time")),
    "interface_field": Signal(
        "V/m", "E_g", "electric field where plate and finger separate: of the gap, or of a vanishing one"
    ),
    "displacement": Signal("C/m2", "D", "bound electric displacement in a layer", ("layer", "time")),
    "plate_voltage": Signal("V", "v_p", "voltage of the plate behind the amplifier"),
    "amplifier_current": Signal(
        "A", "i_a", "current of the amplifier into plate, stray capacitance and finger"
    ),
    "current": Signal("A", "i", "current into the contact"),
    "gap": Signal("m", "g", "gap between finger and plate"),
    "capacitance": Signal("F", "C", "capacitance seen by the drive, at the frequency of its sine"),
    "gross_contact_area": Signal("m2", "A", "area of the outline of the contact"),
    "real_contact_area": Signal("m2", "A_r", "real contact area"),
    "electrostatic_force": Signal("N", "f_e", "electrostatic attraction"),
    "normal_force": Signal("N", "f_n", "force with which the finger is pressed"),
    "lateral_force": Signal("N", "f_t", "friction force"),
    "sliding_speed": Signal("m/s", "u", "speed of the finger over the plate"),
    "bristle_deflection": Signal("m", "z", "elastic deflection of the contact before it slides"),
    "skin_displacement": Signal("m", "x", "lateral displacement of the skin"),
    "skin_speed": Signal("m/s", r"\dot{x}", "lateral speed of the skin"),
    "normal_force_measured": Signal("N", "f_{n,m}", "normal force as the tribometer reads it"),
    "lateral_force_measured": Signal("N", "f_{t,m}", "lateral force as the tribometer reads it"),
    # over frequency
    "effective_voltage_gain": Signal(
        "1", "v_e/v", "effective voltage per volt of the drive, complex", ("frequency",)
    ),
    "field_gain": Signal(
        "1", "E T/v", "voltage across a layer per volt of the drive, complex", ("layer", "frequency")
    ),
    "mean_force": Signal(
        "N",
        r"\langle f_e \rangle",
        "mean attraction under a sine of the drive's peak voltage, or current",
        ("frequency",),
    ),
    "impedance": Signal("ohm", "Z", "impedance seen by the drive, complex", ("frequency",)),
    "permittivity": Signal(
        "1",
        r"\varepsilon^*",
        "relative permittivity of a layer, conduction included, complex",
        ("layer", "frequency"),
    ),
}


def without(name: str, known: Iterable[str]) -> str:
    """Write that a scenario has no signal of a name, which ones it has, and what to do."""
    names = sorted(known)
    plain = name.removesuffix("_measured")
    if name == "capacitance":
        return (
            "signals: this scenario has no 'capacitance', which is that of a constant gap at the frequency of one sine: set"
            ' drive = { model = "Sine", frequency = "10 kHz", amplitude = "1 V" } with the frequency of the meter; where the'
            " recording holds a drive_voltage, take the scenario's with keep = ['drive'], at the command line --keep drive"
        )
    more = (
        f" It is a reading of a tribometer: declare [rig], or import the recording as '{plain}'"
        if plain != name and plain in names
        else ""
    )
    if name in ("plate_voltage", "amplifier_current"):
        more = " It is measured behind an amplifier: declare circuit.amplifier, or name the signals to fit (--quantity)"
    return f"signals: this scenario has no '{name}'. Known: {', '.join(names)}.{more}"


def signal(name: str) -> Signal:
    """Return the declaration of a signal."""
    if name not in SIGNALS:
        raise ElectrovibError(f"'{name}' is not a signal.{nearest(name, SIGNALS)}")
    return SIGNALS[name]
