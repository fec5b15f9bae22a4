"""Design of a drive for a target of the electrostatic force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, nearest
from electrovib.core.units import parse_quantity
from electrovib.physics.drive.current import CurrentSine
from electrovib.physics.drive.sines import Sine
from electrovib.study.check import checked
from electrovib.study.design.drive.carrier import design_carrier
from electrovib.study.design.drive.direct import design_direct
from electrovib.study.design.drive.limits import Bounds, unlimited
from electrovib.study.design.drive.played import Played
from electrovib.study.design.drive.result import DesignedDrive
from electrovib.study.design.drive.target import TargetSource, read_target

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.study.check import LimitsSource
    from electrovib.study.design.drive.found import FoundDrive

METHODS: Final = {
    "dc": "a slow voltage without a carrier, by the inverse of root, leak and dispersion",
    "carrier": "a carrier whose envelope is corrected until its mean force over each period is the target",
    "sqrt-am": "a carrier whose envelope is the square root of the target over the gain at the carrier, not corrected",
    "current": "as carrier, with a prescribed current",
}
"""Methods with their meanings."""


def design_drive(
    scenario: Scenario,
    *,
    target: TargetSource,
    method: str,
    carrier: float | str | None = None,
    rate: float | str | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    progress: Callable[[int, int], None] | None = None,
) -> DesignedDrive:
    """Find the drive whose predicted electrostatic force is a target, or that follows it best within the limits.

    The carrier is by default the one that allows the largest force, from the larger of 1 kHz and ten times
    the highest frequency of the target on; the rate 64 in a period of the carrier, or 40 in one of the
    target. `progress` is not called: a design is one evaluation.
    """
    del progress
    if method not in METHODS:
        raise InputError(
            f"expected one of {', '.join(METHODS)}.{nearest(str(method), METHODS)}",
            path="method",
            value=str(method),
        )
    wanted = read_target(target)
    frequency, samples = _frequency(carrier, "carrier"), _frequency(rate, "rate")
    if method == "dc" and frequency is not None:
        raise InputError("method 'dc' has no carrier; omit it, or take another method", path="carrier")
    bounds = Bounds.of(scenario, limits)
    own = scenario.model_copy(update={"drive": _quantity(method)})
    linear = unlimited(own)
    if method == "dc":
        found = design_direct(linear, wanted, bounds, rate=samples)
    else:
        corrected = method != "sqrt-am"
        found = design_carrier(linear, wanted, bounds, carrier=frequency, rate=samples, corrected=corrected)
    played = Played(own, found.rate)
    final = played.scenario(found.values)
    several = tuple(limits) if isinstance(limits, Sequence) and not isinstance(limits, str) else (limits,)
    return DesignedDrive(
        scenario=final,
        target=wanted,
        method=method,
        solution=found,
        predicted=found.predicted if own is linear else _predicted(played, found),
        bounds=bounds.declared,
        limits=several,
        check=checked(final, limits=list(several), name="the designed drive"),
    )


def _predicted(played: Played, found: FoundDrive) -> Real:
    """Return the mean forces of the full model with the limits of the amplifier [N]."""
    edges = found.edges
    width = round(float(edges[1] - edges[0]) * played.rate)
    first = round(float(edges[0]) * played.rate)
    return played.means(played.force(found.values), first, len(edges) - 1, width)


def _quantity(method: str) -> Drive:
    """Return a drive of the quantity that a method prescribes; it is replaced by the design."""
    if method == "current":
        return CurrentSine(amplitude=1e-6, frequency=1e3)
    return Sine(amplitude=1.0, frequency=1e3)


def _frequency(value: float | str | None, path: str) -> float | None:
    if value is None or not isinstance(value, str):
        return value
    try:
        return parse_quantity(value, "Hz")
    except ValueError as error:
        raise InputError(str(error), path=path, value=value) from None
