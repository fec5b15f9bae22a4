"""A measured dielectric: a table of permittivity and loss over frequency."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from electrovib.core.arrays import Complex
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.files import UNREAD, FileColumn
from electrovib.core.model import Model
from electrovib.core.quantity import ColumnName, Number, Quantity, column_unit
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.physics.kramers_kronig import kramers_kronig_residual
from electrovib.physics.material.base import Material

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import ArrayLike, NDArray

    Real = NDArray[np.float64]
    from numpy.typing import NDArray

FEWEST = 4
"""Rows of the shortest table: fewer do not show the course over frequency."""
NOISE = 0.05
"""Share of the declared conduction by which noise may bring the loss of a row below it."""
RESOLUTION = 1e-3
"""Loss tangent below which an ordinary impedance bridge resolves nothing."""
SUSPICIOUS = 0.05
"""Kramers-Kronig residual that a noise of some percent does not explain."""


class LossColumn(Model, family=True):
    """The column of a table that gives the loss, and its quantity.

    Notes
    -----
    It is the whole loss, conduction included. Rows with NaN are refused by the table.
    """

    noun: ClassVar[str] = "loss"
    needs: ClassVar[str] = "0 or more"

    column: str | int
    unit: str

    def allowed(self, values: Real) -> NDArray[np.bool_]:
        """Mark the values [unit of the column] that a passive dielectric may have."""
        passive: NDArray[np.bool_] = values >= 0
        return passive

    @abstractmethod
    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Convert the column to the loss factor eps''.

        Parameters
        ----------
        frequency : ndarray, shape (N,)
            Frequency [Hz].
        permittivity : ndarray, shape (N,)
            Relative permittivity eps', dimensionless.
        values : ndarray, shape (N,)
            Values of the column, in SI units.

        Returns
        -------
        loss_factor : ndarray, shape (N,)
            Relative loss factor eps'', dimensionless.
        """


class LossFactor(LossColumn):
    """The column is eps'' itself."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "values"}

    noun: ClassVar[str] = "loss factor"

    column: ColumnName = "loss"
    unit: Annotated[str, column_unit("1"), Field(description="unit of the column")] = "1"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return the column as it is."""
        del frequency, permittivity
        return values


class LossTangent(LossColumn):
    """The column is tan delta = eps''/eps'."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "permittivity*values"}

    noun: ClassVar[str] = "loss tangent"

    column: ColumnName = "loss_tangent"
    unit: Annotated[str, column_unit("1"), Field(description="unit of the column")] = "1"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return eps' tan delta."""
        del frequency
        return permittivity * values


class Conductivity(LossColumn):
    """The column is the whole conductivity, w eps0 eps''."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "values/(2*pi*frequency*eps0)"}

    noun: ClassVar[str] = "conductivity"

    column: ColumnName = "conductivity"
    unit: Annotated[str, column_unit("S/m"), Field(description="unit of the column")] = "S/m"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return sigma/(w eps0)."""
        del permittivity
        return values / (2 * np.pi * frequency * VACUUM_PERMITTIVITY)


class Resistivity(LossColumn):
    """The column is the resistivity, 1/(w eps0 eps'')."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "1/(2*pi*frequency*eps0*values)"}

    noun: ClassVar[str] = "resistivity"
    needs: ClassVar[str] = "above 0"

    column: ColumnName = "resistivity"
    unit: Annotated[str, column_unit("ohm m"), Field(description="unit of the column")] = "ohm m"

    def allowed(self, values: Real) -> NDArray[np.bool_]:
        """Mark the values [ohm m] that a passive dielectric may have; 0 would be an infinite loss."""
        passive: NDArray[np.bool_] = values > 0
        return passive

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return 1/(w eps0 rho)."""
        del permittivity
        return 1 / (2 * np.pi * frequency * VACUUM_PERMITTIVITY * values)


class Tabulated(Material):
    """A measured dielectric.

    Notes
    -----
    The conductivity at zero frequency is declared, because a table does not give it: it cannot be distinguished from
    polarisation slower than the lowest frequency. `conduction_bounds` gives the values between which it may be declared;
    results that depend on it lie between those of the two bounds.

    Between rows the logarithm of eps', and eps'' itself, are linear in the logarithm of the frequency. Beyond the rows
    nothing was measured: there the value at the edge is extrapolated as one Debye relaxation, below the band with the time
    1/(2 pi f_min), above it with 1/(2 pi f_max) or, where the loss at the edge exceeds half of eps', with a shorter time so
    that eps' stays positive. The extrapolation is passive and continuous, but not measured; `band` gives the ends of the
    table.

    Where the declared conduction exceeds the loss of a row by no more than noise (5 % of it, or 0.001 as loss tangent), the
    polarisation has no loss there.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "frequency_samples": [10, 21.54, 46.42, 100, 215.4, 464.2, 1e3, 2154, 4642, 1e4, 21540, 46420, 1e5],
        "permittivity_samples": [1270, 906, 580, 354, 220, 144, 103, 80.4, 67.5, 60.1, 55.9, 53.4, 52],
        "loss_samples": [4186, 2272, 1284, 730, 412, 231, 129, 72.4, 40.7, 23, 13.1, 7.44, 4.26],
        "conductivity": 2e-6,
    }

    file: Annotated[str, Field(description="csv, npy or nc file with the table")] = ""
    frequency_column: ColumnName = "frequency"
    frequency_unit: Annotated[str, column_unit("Hz"), Field(description="unit of the column")] = "Hz"
    permittivity_column: ColumnName = "permittivity"
    loss: LossColumn = LossFactor()
    conductivity: Annotated[
        Number, Quantity("S/m", 0, 1e3, "conductivity at zero frequency, at most the smallest of the table")
    ]
    frequency_samples: Annotated[Samples, Field(description="frequencies [Hz], in place of a file")] = (
        Samples([])
    )
    permittivity_samples: Annotated[
        Samples, Field(description="relative permittivities [1], in place of a file")
    ] = Samples([])
    loss_samples: Annotated[
        Samples, Field(description="loss in the quantity of its column, in place of a file")
    ] = Samples([])

    @classmethod
    def file_columns(cls, table: Mapping[str, Any]) -> Mapping[str, FileColumn]:
        """Add the column of the loss to those of frequency and permittivity."""
        found = super().file_columns(table)
        try:
            loss = LossColumn.model_validate(table.get("loss", cls.model_fields["loss"].default))
        except ValidationError:
            return {}
        forms = ", ".join(sorted(find_members(LossColumn)))  # type: ignore[type-abstract]
        others = f' The loss may be given in other quantities: loss = {{ model = "..." }} with {forms}.'
        return {**found, "loss_samples": FileColumn(loss.column, loss.unit, others)} if found else {}

    @classmethod
    def file_variants(cls, table: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
        """Return every form of the loss, unless one is declared: the file has the column of one of them."""
        forms = () if "loss" in table else sorted(find_members(LossColumn))  # type: ignore[type-abstract]
        return tuple({"loss": {"model": name}} for name in forms)

    @model_validator(mode="after")
    def _is_passive(self) -> Self:
        for why in self._faults():
            raise ValueError(why)
        return self

    def _faults(self) -> Iterator[str]:
        """Describe what is wrong with the table; each check assumes that those before it have passed."""
        columns = {
            "frequency": self.frequency_samples.values,
            "permittivity": self.permittivity_samples.values,
            self.loss.noun: self.loss_samples.values,
        }
        sizes = {name: len(values) for name, values in columns.items()}
        if not any(sizes.values()):
            named = 'name the measured table, for instance file = "skin.csv"'
            yield f"holds no rows: {UNREAD if self.file else named}"
        if len(set(sizes.values())) > 1:
            yield "columns differ in length: " + ", ".join(f"{name} {size}" for name, size in sizes.items())
        if sizes["frequency"] < FEWEST:
            yield f"a table needs at least {FEWEST} rows, not {sizes['frequency']}"
        for name, values in columns.items():
            if not np.isfinite(values).all():
                row = int(np.argmin(np.isfinite(values)))
                yield f"row {row} (first is 0): {name} = {values[row]} is not a finite number"
        yield from self._disorder(columns["frequency"])
        rules = {
            "permittivity": (columns["permittivity"] > 0, "above 0"),
            self.loss.noun: (self.loss.allowed(columns[self.loss.noun]), self._passive_needs()),
        }
        for name, (allowed, needs) in rules.items():
            if not allowed.all():
                row = int(np.argmin(allowed))
                yield f"{self._place(row)}: {name} = {columns[name][row]:.6g} must be {needs}"
        if not np.isfinite(self._loss() + self._conduction()).all():
            row = int(np.argmin(np.isfinite(self._loss() + self._conduction())))
            yield f"{self._place(row)}: the loss is too large for a number; check units"
        yield from self._overdrawn()

    def _disorder(self, frequency: Real) -> Iterator[str]:
        if frequency.min() <= 0:
            row = int(np.argmax(frequency <= 0))
            yield f"{self._place(row)}: frequency must be above 0 Hz"
        falls = np.flatnonzero(np.diff(frequency) <= 0) + 1
        if falls.size:
            row = int(falls[0])
            word = "repeats" if frequency[row] == frequency[row - 1] else "comes after"
            yield (
                f"frequency must rise from row to row, but {self._place(row)}, {word}"
                f" {frequency[row - 1]:.6g} Hz; sort the table and keep one row of each frequency"
            )

    def _passive_needs(self) -> str:
        return (
            f"{self.loss.needs}: with Im eps* > 0 the dielectric would be active and release energy;"
            " check the sign of the column, and omit rows that the instrument could not resolve"
        )

    def _overdrawn(self) -> Iterator[str]:
        """Refuse a declared conduction that exceeds the loss of the table."""
        loss, conduction = self._loss(), self._conduction()
        missing = (1 - NOISE) * conduction - loss - RESOLUTION * self.permittivity_samples.values
        if (missing > 0).any():
            row = int(np.argmax(missing / conduction))
            declared, most = (
                format_quantity(s, "S/m", digits=4) for s in (self.conductivity, self.conduction_bounds()[1])
            )
            yield (
                f"conductivity = {declared} alone gives eps'' = {conduction[row]:.4g} at {self._place(row)},"
                f" but the whole loss of the table there is {loss[row]:.4g}; declare from 0 to {most}"
            )

    def _place(self, row: int) -> str:
        return f"row {row} (first is 0), {self.frequency_samples.values[row]:.6g} Hz"

    def _loss(self) -> Real:
        frequency, permittivity = self.frequency_samples.values, self.permittivity_samples.values
        with np.errstate(all="ignore"):  # what overflows is refused as not finite
            return self.loss.loss_factor(frequency, permittivity, self.loss_samples.values)

    def _conduction(self) -> Real:
        """Return eps'' of the declared conduction at the rows."""
        with np.errstate(all="ignore"):
            loss: Real = self.conductivity / (2 * np.pi * self.frequency_samples.values * VACUUM_PERMITTIVITY)
        return loss

    def table(self) -> tuple[Real, Complex]:
        """Return the rows without the declared conduction.

        They are the frequency [Hz], rising, and the relative permittivity of the bound charge alone, passive,
        each of shape (N,).
        """
        loss = np.maximum(self._loss() - self._conduction(), 0.0)
        return self.frequency_samples.values, self.permittivity_samples.values - 1j * loss

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency of the table [Hz]."""
        frequency = self.frequency_samples.values
        return float(frequency[0]), float(frequency[-1])

    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone, measured within `band` only."""
        asked = np.asarray(frequency, dtype=float)
        hertz, rows = self.table()
        low, high = self.band
        place, places = np.log(np.clip(asked, low, high)), np.log(hertz)
        real = np.exp(np.interp(place, places, np.log(rows.real)))
        inside = real - 1j * np.interp(place, places, -rows.imag)
        above = max(1.0, -2 * rows[-1].imag / rows[-1].real)
        slower = _relaxation_through(rows[0], np.where(asked < low, asked / low, 1.0), 1.0)
        faster = _relaxation_through(rows[-1], np.where(asked > high, asked / high, 1.0), above)
        return np.where(asked < low, slower, np.where(asked > high, faster, inside))

    @property
    def slowest_relaxation(self) -> float:
        """Longest relaxation time that the lowest frequency resolves, 1/(2 pi f_min) [s]."""
        return float(1 / (2 * np.pi * self.frequency_samples.values[0]))

    def conduction_bounds(self) -> tuple[float, float]:
        """Return the smallest and the largest conductivity at zero frequency [S/m] that the table allows.

        The smallest is 0: all loss is slow polarisation. The largest is the smallest w eps0 eps'' of all
        rows: that loss is all conduction. The conductivity of a passive sum of relaxations does not decrease
        with frequency, so its value at zero frequency is at most the smallest in the table; without noise
        that is the one of the first row.
        """
        angular = 2 * np.pi * self.frequency_samples.values
        return 0.0, float(np.min(angular * VACUUM_PERMITTIVITY * self._loss()))

    @property
    def kramers_kronig(self) -> float:
        """Relative misfit of the Kramers-Kronig relations, rms, dimensionless; NaN with too few rows."""
        frequency = self.frequency_samples.values
        conductivity = 2 * np.pi * frequency * VACUUM_PERMITTIVITY * self._loss()
        try:
            return kramers_kronig_residual(frequency, self.permittivity_samples.values, conductivity)
        except InputError:
            return float("nan")

    def diagnostics(self, name: str) -> tuple[Diagnostic, ...]:
        """Report passivity, band and Kramers-Kronig residual."""
        residual, (low, high) = self.kramers_kronig, self.band
        state = "unknown" if np.isnan(residual) else "warning" if residual > SUSPICIOUS else "ok"
        said = "unknown, because there are too few rows" if np.isnan(residual) else f"{100 * residual:.2g} %"
        text = (
            f"the table of '{name}' is passive in all {len(self.frequency_samples)} rows, from"
            f" {format_quantity(low, 'Hz')} to {format_quantity(high, 'Hz')}; its Kramers-Kronig residual is {said}"
            f" (suspicious above {100 * SUSPICIOUS:.0f} %)"
        )
        return (*super().diagnostics(name), Diagnostic("measured table", state, text))


def _relaxation_through(edge: complex, ratio: Real, place: float) -> Complex:
    """Return the Debye relaxation that has this value at w = place/tau, at a frequency higher by this ratio."""
    fast = edge.real + edge.imag / place
    return np.asarray(fast + (edge.real - fast) * (1 + place**2) / (1 + 1j * place * ratio))
