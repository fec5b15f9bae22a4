"""An attraction from a table over the voltage: of a rough contact that was solved, of finite elements, or measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.files import UNREAD, FileColumn
from electrovib.core.quantity import column_unit, is_unit_of
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.physics.force.base import ForceLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.physics.stack import Layer, Linear, Section


class TabulatedAttraction(ForceLaw):
    """An attraction per area that is known at some constant voltages.

    Notes
    -----
    The voltage is that across the gap and the layers that do not conduct; either sign attracts alike. Between rows the
    attraction over the squared voltage is linear in that square, below the first row it is that of the first, and beyond the
    last one a run is refused. The table is of one load and one surface. The contact follows the voltage at once: where it is
    slower than a period of the drive, the attraction is that of the root mean square times the squared ratio to it.
    `electrovib.save` writes a rough contact that was solved as such a table; without a table a run solves contact.surface =
    { model = "RoughContact", ... } for it.
    """

    status: ClassVar[str] = "derived"
    evaluation_surface: ClassVar[str] = "table"
    example: ClassVar[Mapping[str, Any]] = {
        "voltage_samples": [1000, 2000],
        "attraction_samples": [1e5, 4e5],
    }

    file: Annotated[str, Field(description="csv, npy or nc file with the table")] = ""
    voltage_column: Annotated[str | int, Field(description="name or number of the column")] = "voltage"
    voltage_unit: Annotated[str, column_unit("V"), Field(description="unit of the column")] = "V"
    attraction_column: Annotated[str | int, Field(description="name or number of the column")] = "attraction"
    attraction_unit: Annotated[str, column_unit("Pa"), Field(description="unit of the column")] = "Pa"
    voltage_samples: Annotated[Samples, Field(description="voltages [V], in place of a file")] = Samples([])
    attraction_samples: Annotated[
        Samples, Field(description="attractions per area [Pa], in place of a file")
    ] = Samples([])

    @classmethod
    def file_columns(cls, table: Mapping[str, Any]) -> Mapping[str, FileColumn]:
        """Return the columns of voltage and attraction, unless the table holds the samples."""
        if not table.get("file") or "voltage_samples" in table:
            return {}
        given = {name: cls.model_fields[name].default for name in cls.model_fields} | dict(table)
        found = {}
        for name, unit in (("voltage", "V"), ("attraction", "Pa")):
            column, stated = given[f"{name}_column"], given[f"{name}_unit"]
            if not is_unit_of(unit, stated) or not isinstance(column, str | int):
                return {}
            found[f"{name}_samples"] = FileColumn(column, stated)
        return found

    @property
    def is_solved(self) -> bool:
        """Whether there is no table, and contact.surface is solved for one."""
        return not (self.file or len(self.voltage_samples) or len(self.attraction_samples))

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        voltage, attraction = self.voltage_samples.values, self.attraction_samples.values
        why = ""
        if self.is_solved:
            return self
        if voltage.size != attraction.size:
            why = f"columns differ in length: {voltage.size} voltages and {attraction.size} attractions"
        elif not voltage.any():
            why = f"holds no voltage besides 0: {UNREAD if self.file else 'give voltages and their attractions'}"
        elif not np.all(np.diff(voltage) > 0) or voltage[0] < 0:
            why = (
                "voltages must rise from row to row, from 0 on; of a contact that falls shut keep one branch"
            )
        elif not np.all((attraction >= 0) & (attraction < np.inf) & ((attraction > 0) | (voltage == 0))):
            why = "attractions must be finite and above 0, at 0 V they may be 0"
        if why:
            raise PydanticCustomError("table", "{why}", {"why": why})
        return self

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the voltage across the gap and the layers that do not conduct."""
        layers = [section[name] for name in section.names]
        first, *others = (
            layer.field * (layer.thickness * (np.asarray(layer.material.conductivity) == 0))
            for layer in layers
        )
        return {"V": sum(others, start=first)}

    def pressure(self, V: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attraction per area [Pa] from the voltage [V]."""
        if self.is_solved:
            raise InputError(
                "force: TabulatedAttraction has no table here, where contact.surface is not solved as for a run; give one, which"
                " electrovib.save writes of electrovib.rough_contact"
            )
        given = np.asarray(V, dtype=float)
        voltage, attraction = self.voltage_samples.values, self.attraction_samples.values
        largest = np.max(np.abs(given), initial=0.0, where=np.isfinite(given))
        if largest > voltage[-1] * (1 + 1e-9):
            raise InputError(
                f"force: the table ends at {format_quantity(voltage[-1], 'V')}, but gap and layers that do not conduct have"
                f" {format_quantity(float(largest), 'V', digits=4)}; give a table up to there, or lower the drive"
            )
        known = voltage > 0
        squared, asked = voltage[known] ** 2, given**2
        found: NDArray[np.float64] = asked * np.interp(asked, squared, attraction[known] / squared)
        return found

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Return that load and surface are those of the table, which are not judged."""
        del layers
        if self.is_solved:
            return ()
        text = "load, area and surface are those of the table, and the contact follows the voltage at once"
        return (Diagnostic("table of the attraction", "unknown", text),)
