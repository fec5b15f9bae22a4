"""How what plays a file of samples passes from one to the next, and what of the amplifier may hold its current."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.scenario import TimeGrid
from electrovib.study.check import (
    cleared_as_played,
    cleared_for_output,
    sampled,
    with_drive,
    without_its_limits,
)

if TYPE_CHECKING:
    from electrovib.export.waveform.formats import WaveformFormat
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult, LimitsSource
    from electrovib.study.waveform import Waveform

_LINE: Final = "line"
"""Edge of a player that joins samples by straight lines."""
_DECLARE: Final = "Declare the edge that the output has: --edge TIME, such as --edge 10us"
_NOT_PRESENT: Final = (
    "Bandwidth, saturation and current limit of circuit.amplifier count in the current only where this very amplifier stands"
    " before the plate: declare --amplifier-present, or its maker and model as circuit.amplifier.hardware"
)


@dataclass(frozen=True, kw_only=True)
class Playing:
    """What is declared of the output that plays a file, without an amplifier that is only assumed.

    `edge` is the height of a step between held samples over its steepest slope [s]; None for steps.
    """

    held: bool
    edge: float | None
    scenario: Scenario
    is_assumed: bool

    @classmethod
    def declared(
        cls, scenario: Scenario, form: WaveformFormat, *, edge: float | str | None, amplifier_present: bool
    ) -> Playing:
        """Read the declarations of an export, or refuse those that do not suit the format."""
        refuse_unsuited(form, edge)
        amplifier = scenario.circuit.amplifier
        is_present = amplifier_present or (amplifier is not None and bool(amplifier.hardware))
        relied_on = scenario if is_present else without_its_limits(scenario)
        held = form.played and not isinstance(edge, str)
        lasting = None if isinstance(edge, str) else edge
        return cls(held=held, edge=lasting, scenario=relied_on, is_assumed=relied_on is not scenario)

    @property
    def _consequence(self) -> str:
        return f"Nothing was written. {_NOT_PRESENT}" if self.is_assumed else "Nothing was written"

    def clear_drive(self, what: str, *, limits: LimitsSource | Sequence[LimitsSource]) -> None:
        """Refuse a drive that exceeds a limit between its samples."""
        end = float(self.scenario.time.times(self.scenario.drive)[-1])
        from_rest = self.scenario.model_copy(update={"time": TimeGrid(duration=end)})
        cleared_for_output(from_rest, limits=limits, what=what, consequence=self._consequence)

    def cleared(
        self, wave: Waveform, what: str, *, limits: LimitsSource | Sequence[LimitsSource]
    ) -> CheckResult:
        """Compare the samples as they are played with the limits, or refuse them."""
        name = "the samples as written"
        if self.held:
            return cleared_as_played(
                self.scenario, times=wave.times, voltages=wave.voltages, edge=self.edge, declare=_DECLARE,
                limits=limits, what=what, name=name, consequence=self._consequence,
            )  # fmt: skip
        joined = with_drive(self.scenario, sampled(wave.times, wave.voltages))
        return cleared_for_output(joined, limits=limits, what=what, name=name, consequence=self._consequence)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the comparison of the current with its limit relied on, as sentences."""
        edges = "steps" if self.edge is None else f"edges of {format_quantity(self.edge, 's', digits=4)}"
        judged = (
            f"the current was checked with each sample held until the next and {edges} between them"
            if self.held
            else "the current was checked with straight lines between the samples: an output that holds them makes steps, which"
            " were not checked"
        )
        amplifier = self.scenario.circuit.amplifier
        if amplifier is None or (amplifier.source_current is None and amplifier.bandwidth is None):
            return (judged,)
        name = amplifier.hardware or "declared to be present"
        return (
            judged,
            f"the current was checked with current limit and bandwidth of circuit.amplifier ({name}): the amplifier that is used"
            " has to have them in hardware",
        )


def refuse_unsuited(form: WaveformFormat, edge: float | str | None) -> None:
    """Refuse an edge that a format has no use for, and a file without one whose player is not known."""
    if not form.played and edge is not None:
        raise InputError(
            f"a {form.name} joins samples by straight lines; omit it", path="edge", value=str(edge)
        )
    if edge is None and form.played and not form.held:
        raise InputError(
            f"how the samples follow each other where a {form.name} is played is not declared: --edge {_LINE} if they are joined"
            " by straight lines, or --edge 10us, the height of a step over its steepest slope, if each is held until the next",
            path="edge",
        )
    if isinstance(edge, str) and (edge != _LINE or form.held):
        why = (
            f"{form.name} holds each sample: give a time"
            if form.held
            else f"must be '{_LINE}' or a time in s"
        )
        raise InputError(why, path="edge", value=edge)
    if edge is not None and not isinstance(edge, str) and not (math.isfinite(edge) and edge > 0):
        raise InputError("must be a time above 0 s", path="edge", value=str(edge))
