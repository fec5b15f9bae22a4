"""The force over voltage that contacts fitted to a capacitance predict, beside a measured one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.topography import MeasuredHeights, SelfAffine
from electrovib.solve.rough_contact import Loaded, follow_voltages, words_of_spots
from electrovib.solve.stack.blocking import BlockingStack


class FittedDraw(NamedTuple):
    """One draw of the phases, or a measured map, with the roughness and the body that agree best with the capacitances."""

    seed: int
    roughness: SelfAffine | MeasuredHeights
    body: Elastic | Coated

    def attractions(
        self, stack: BlockingStack, voltages: Sequence[float], shape: tuple[int, int], share: float
    ) -> tuple[list[float], float]:
        """Return the attraction [Pa] at each voltage [V] in this order, and the widest gap [m].

        On a grid of the shape, spots having that share of the field of insulating ones.
        """
        periods = self.roughness.periods
        loaded = Loaded(
            heights=self.roughness.heights(shape, periods, seed=self.seed),
            periods=periods,
            compliance=self.body.compliance,
            pressure=stack.pressure,
        )
        rests = follow_voltages(loaded, voltages, electrical_thickness=stack.electrical_thickness)
        pulls = [rest.with_field_share(share).mean_attraction for rest in rests]
        return pulls, max(float(rest.gap.max()) for rest in rests)


@dataclass(frozen=True, kw_only=True, repr=False)
class ContactPrediction(Answer):
    """Attraction of a contact that was fitted to its capacitance, at voltages that the fit has not seen.

    Parameters
    ----------
    stack : BlockingStack
        Load, area and layers under which the force is predicted.
    voltage : ndarray, shape (n,)
        Voltages [V] in the order in which the contact goes through them.
    forces : ndarray, shape (draws, n)
        Attraction [N] by each draw of the phases of the roughness.
    measured : ndarray, shape (n,), or None
        Measured attraction at each voltage [N].
    field_share : float
        Field where faces touch, over that of insulating spots [1].
    diagnostics : tuple of Diagnostic
        Of what the scenario declares, and of films, air and limits where the faces touch.
    """

    FILES: ClassVar = {"prediction.csv": Form.TABLE}
    stack: BlockingStack
    voltage: Real
    forces: Real
    measured: Real | None
    field_share: float
    diagnostics: tuple[Diagnostic, ...]

    @property
    def force(self) -> Real:
        """Geometric mean of the attraction over the draws, at each voltage [N]; 0 where there is none."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(np.log(self.forces).mean(axis=0)))

    @property
    def typical_factor(self) -> float:
        """Factor between predicted and measured forces: exp of the root mean square of ln(predicted/measured); NaN without."""
        if self.measured is None:
            return math.nan
        return float(np.exp(np.sqrt(np.mean(np.log(self.force / self.measured) ** 2))))

    @property
    def slopes(self) -> tuple[float, float]:
        """Exponents of the voltage in the predicted and the measured force, by a straight line through the logarithms."""
        return self._slope(self.force), self._slope(self.measured)

    def _slope(self, force: Real | None) -> float:
        size = np.abs(self.voltage)
        if force is None or np.unique(size).size < 2:
            return math.nan
        return float(np.polyfit(np.log(size), np.log(force), 1)[0])

    @property
    def document(self) -> Document:
        """How far prediction and measurement agree, and a row for each voltage."""
        lowest, highest = self.forces.min(axis=0), self.forces.max(axis=0)
        numbers = [self.voltage, self.force, lowest, highest]
        headings = ["voltage", "force", "least of the draws", "largest of the draws"]
        rows = [
            [_shown(each, unit) for each, unit in zip(row, "VNNN", strict=True)]
            for row in zip(*numbers, strict=True)
        ]
        if self.measured is not None:
            headings += ["measured", "predicted over measured"]
            for row, seen, own in zip(rows, self.measured.tolist(), self.force.tolist(), strict=True):
                row += [_shown(seen, "N"), f"{own / seen:.3f}"]
        return Document(
            title="Force predicted from the capacitance",
            sentences=[self._at_most(), *self._compared(), *words_of_spots(self.field_share)],
            numbers=[Table("", tuple(headings), tuple(map(tuple, rows)))],
            diagnostics=self.diagnostics,
            figures=[self._figure()],
            remarks=[
                "no number of the prediction is free. It is the attraction under a constant voltage across the layers, with their"
                " permittivities at the lowest frequency of the scenario; a force along the plate is this times a coefficient of"
                " friction",
                *self._draws(),
                *reasons(self.diagnostics),
            ],
        )

    def content(self, name: str) -> str:
        """Write voltages, attraction per area, predicted forces of each draw and measured ones as CSV, in SI."""
        del name
        columns = {"voltage": self.voltage, "force": self.force, "attraction": self.force / self.stack.area}
        columns |= {f"draw {number}": each for number, each in enumerate(self.forces, 1)}
        if self.measured is not None:
            columns["measured"] = self.measured
        return csv_text(
            tuple(columns), np.column_stack(list(columns.values())).tolist(), remarks=self.document.sentences
        )

    def _draws(self) -> list[str]:
        alone = len(self.forces) == 1
        return (
            []
            if alone
            else ["the draws differ in the random phases of the roughness alone, which no capacitance tells"]
        )

    def _at_most(self) -> str:
        at = int(np.argmax(np.abs(self.voltage)))
        ends = (_shown(end, "N") for end in (self.forces[:, at].min(), self.forces[:, at].max()))
        count = len(self.forces)
        over = f"{' to '.join(ends)} over {count} draws of the phases" if count > 1 else "of one surface"
        return (
            f"at {_shown(self.voltage[at], 'V')} under a load of {_shown(self.stack.pressure, 'Pa')} the attraction is"
            f" {_shown(self.force[at], 'N')}, {over}"
        )

    def _compared(self) -> list[str]:
        if self.measured is None:
            return []
        said = f"predicted and measured forces differ by a typical factor of {self.typical_factor:.3g}"
        own, seen = self.slopes
        if math.isfinite(own):
            said += f"; the force grows with the power {own:.3g} of the voltage, measured {seen:.3g}"
        return [said]

    def _figure(self) -> Panel:
        low, high = self.forces.min(axis=0), self.forces.max(axis=0)
        curves = [Curve(label="predicted", x=self.voltage, y=self.force, kind="bold", look=0)]
        if len(self.forces) > 1:
            band = Curve(label="draws", x=self.voltage, y=low, upper=high, kind="band", look=0)
            curves = [band, replace(curves[0], label="predicted, with the range of draws")]
        if self.measured is not None:
            curves.append(Curve(label="measured", x=self.voltage, y=self.measured, kind="points", look=1))
        return Panel(
            id="force", title="Force over voltage", x=("voltage", "V"), y=("force", "N"), curves=tuple(curves),
            caption="Predicted from the capacitance over the load, with each draw of the phases.",
        )  # fmt: skip


def _shown(value: float, unit: str) -> str:
    return format_quantity(float(value), unit, digits=4)
