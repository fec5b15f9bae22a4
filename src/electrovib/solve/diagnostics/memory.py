"""Error of a response in time due to the reduction of materials to Debye sums.

The change of a linear quantity is itself linear in the drive: D = declared - reduced, the first from impedances at
each frequency, the second from modes. D is fitted by signed relaxations on a fixed dense grid of rates, a linear
least-squares problem, and the response of that fit to the drive is the error. It does not depend on the fit of the
material. The error is known at some times, the probes, and is compared with the quantity at all output times.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.budget import one_thread
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.solve.diagnostics.probes import (
    LARGEST,
    MANY,
    PROBES,
    Extremes,
    Judged,
    judge,
    probe_places,
)
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.solution import linear_quantities
from electrovib.solve.electrics.transient import amplified, transient
from electrovib.solve.stack import expand
from electrovib.solve.stack.expand import SAME, left_by_charge, lowest_frequency, phasors, shortest_time
from electrovib.solve.stack.harmonics import drive_mean
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.solve.stack.transfer import Transfer, integral_weight

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Method, Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

FORCE: Final = "force"
CURRENT: Final = "current"
SAFETY: Final = 1.5
"""Factor on the error found: for what the fit of D omits, and for what lies between two probes."""
SPREAD: Final = 3.0
"""Factor on the largest relative residual of the fit of D: what it may amount to in time."""
SMALLEST: Final = (1e-10, 1e-13)
"""Singular values over the largest below which a combination of relaxations is omitted from the fit of D; of the two fits the
one with the smaller residual is taken. A skin that loses its voltage exponentially needs the second: its D differs from 0 by
the place of one rate, which neighbouring rates of the grid express with large gains of both signs."""
MEASURED: Final = (1e-4,)
"""The same where a material is a measured table, whose noise relaxations cannot follow."""
POLES_PER_DECADE: Final = 10
"""Relaxation rates of the fit of D."""
ROWS_PER_DECADE: Final = 16
"""Frequencies at which D is fitted."""
BEYOND: Final = 10.0
"""Factor by which the relaxation rates of D extend beyond the band on both sides."""
POWERS: Final = (0.0, -0.5, 0.5)
"""Powers of the frequency by which a quantity may fall; the fit of D is weighted by the one with the least residual."""
AT_REST: Final = 1e-60
"""Frequency that replaces 0, where a power law has no value [Hz]."""
_ROUNDED: Final = 1e-13
"""Largest value over what all modes together would give, up to which a quantity is rounding."""
_NOT_OFF: Final = Judged(error=0.0, share=0.0, lost=np.inf, of_peak=0.0)
"""What is said of a quantity that is 0 but for rounding."""
AT_ONCE: Final = 1e40
"""Frequency that replaces infinity, of the response right at a discontinuity [Hz]."""


def answer_errors(
    members: Sequence[Scenario],
    section: ModalSection,
    answer: Solution,
    times: Real,
    *,
    known: tuple[float, float],
    respond: Callable[[dict[Key, Transfer], Real], dict[Key, Real]] | None = None,
    noted: Extremes | None = None,
) -> list[dict[Key, Judged]]:
    """Bound the errors of responses in time due to the reduction of materials.

    `times` (cases, n) [s] of one scenario, or of several of one stack in the periodic state of their tones, whose answer has
    one case after the other; `respond` gives the responses to their drives at some times (cases, m) [s]. `noted` has the
    extremes of the answer of one scenario at these times.

    The error is the response of D = declared - reduced to the drive, times `SAFETY`, plus `SPREAD` times the relative
    residual of the fit of D over frequency.
    """
    scenario, first, settled = members[0], times[0], members[0].time.settled
    unknown = [
        bool(settled and known[0] and lowest_frequency(each) < known[0] * (1 - SAME)) for each in members
    ]
    judged = _judged(scenario, first, known)
    steady = settled and known[0] == 0 and bool(drive_mean(scenario.drive))
    fit = None if all(unknown) else _fit(scenario, first, known, steady=steady)
    if fit is None or not np.any(judged):
        return [{} for _ in members]
    differences, residuals = _differences(scenario, section, fit, settled=settled)
    probes = _probes_among(judged) if noted is None else noted.probes
    found = {
        name: row.reshape(times.shape)
        for name, row in answer.found.items()
        if name in differences and row.ndim == 1
    }
    rounded = _rounding(members, section, found)
    some = times[:, probes]
    errors = _respond(scenario, differences, some) if respond is None else respond(differences, some)
    bounds = _bounds(scenario, {name: row[:, probes] for name, row in found.items()}, some, errors, residuals)
    straight = judged & ~_at_corner(scenario.drive, first, bends=True)
    found[FORCE] = answer.attraction.reshape(times.shape)
    each = {
        name: [_NOT_OFF] * len(members)
        if name in rounded
        else judge(found[name], times, probes, bound, straight if name == CURRENT else judged, name, noted)
        for name, bound in bounds.items()
    }
    return [
        {} if without else {name: of_cases[case] for name, of_cases in each.items()}
        for case, without in enumerate(unknown)
    ]


def _rounding(members: Sequence[Scenario], section: ModalSection, found: Mapping[Key, Real]) -> set[Key]:
    """Return the quantities that are 0 but for rounding, as behind a layer that blocks: no error is relative to them."""
    transfers = linear_quantities(members[0], section)
    largest = max(each.drive.largest() for each in members)
    sizes = {
        name: float(np.max(np.abs(each.direct if each.static is None else each.static)))
        + float(np.sum(np.abs(each.gains)))
        for name, each in transfers.items()
    }
    rounded = {
        name
        for name, row in found.items()
        if np.max(np.abs(row), initial=0.0) <= _ROUNDED * largest * sizes[name]
    }
    amplitudes = {name for name in found if isinstance(name, AmplitudeOf)}
    return rounded | ({FORCE} if amplitudes <= rounded else set())


def _fit(
    scenario: Scenario, times: Real, known: tuple[float, float], *, steady: bool
) -> _DifferenceFit | None:
    """Return the fit of D over the part of a run's band in which the materials are known; None where there is none."""
    low, high = expand.band_of_run(scenario, times)
    low, high = max(low, known[0]), min(high, known[1])
    smallest = MEASURED if known[0] else SMALLEST
    return _DifferenceFit.over(low, high, steady=steady, smallest=smallest) if low < high else None


def _bounds(
    scenario: Scenario,
    found: Mapping[Key, Real],
    times: Real,
    errors: Mapping[Key, Real],
    residuals: Mapping[Key, float],
) -> dict[Key, Real]:
    """Bound the errors of linear quantities and of the attraction at some times."""
    bounds: dict[Key, Real] = {
        name: SAFETY * np.abs(errors[name]) + SPREAD * residuals[name] * np.abs(row)
        for name, row in found.items()
    }
    amplitudes = {name: row for name, row in found.items() if isinstance(name, AmplitudeOf)}
    if amplitudes and scenario.force.causal:
        bounds[FORCE] = _of_force(scenario, times, amplitudes, errors, residuals)
    return bounds


def _at_corner(drive: Drive, times: Real, *, bends: bool) -> NDArray[np.bool_]:
    """Return which output times are at a discontinuity of the drive, or with `bends` at any of its corners."""
    if bends and any(part.begins_with(times) for part in drive.parts()):
        return np.ones(len(times), bool)
    marks, heights = drive.corners(float(times[-1]))
    begins = [0.0] if bends or drive.voltage(0.0) else []
    corners = np.sort(np.append(marks if bends else marks[heights != 0], begins))
    near = SAME * corners
    first = np.searchsorted(times, corners - near, side="left")
    last = np.searchsorted(times, corners + near, side="right")
    found = np.zeros(len(times), bool)
    if np.all(last - first <= 1):
        found[first[last > first]] = True
    else:
        for begin, end in zip(first.tolist(), last.tolist(), strict=True):
            found[begin:end] = True
    return found


def jump_errors(
    scenario: Scenario, section: ModalSection, answer: Solution, times: Real, known: tuple[float, float]
) -> dict[Key, float]:
    """Return the errors, over the peaks, of a response at discontinuities of the drive among its times (n,) [s].

    There the response is that of infinite frequency, at which a sum of Debye relaxations has the permittivity of what it
    leaves out at the end of its band. Of a table that is not known; behind a bandwidth or a largest current nothing jumps.
    """
    supply, drive = scenario.circuit.supply, scenario.drive
    here = np.flatnonzero(_at_corner(drive, times, bends=False))
    follows_later = bool(supply.bandwidth) or bool(np.all(np.isfinite(supply.current_limits)))
    if not here.size or np.isfinite(known[1]) or follows_later or drive.quantity == "current":
        return {}
    marks, heights = drive.corners(max(float(times[-1]), drive.period or 0.0))
    first = float(drive.voltage(0.0))
    if scenario.time.settled:
        first = float(np.sum(heights[np.isclose(marks, drive.period or 0.0, rtol=SAME, atol=0.0)]))
    marks, heights = np.append(0.0, marks), np.append(first, heights)
    jumps = supply.gain * heights[np.searchsorted(marks, times[here] * (1 + SAME), side="right") - 1]
    largest = np.sort(np.argsort(-np.abs(jumps))[:PROBES])
    here, jumps, reduced = here[largest], jumps[largest], linear_quantities(scenario, section)
    declared = linear_quantities(scenario, phasors(scenario, np.array([AT_ONCE]), leaks=False))
    found = {name: row for name, row in answer.found.items() if name in reduced and name != CURRENT}
    off = {name: jumps * (float(declared[name].real[0]) - float(reduced[name].direct)) for name in found}
    errors = {
        name: float(np.max(np.abs(off[name]))) / (float(np.max(np.abs(row))) or np.inf)
        for name, row in found.items()
    }
    amplitudes = {name: row[here] for name, row in found.items() if isinstance(name, AmplitudeOf)}
    if amplitudes and scenario.force.causal:
        exact: dict[Key, float] = dict.fromkeys(amplitudes, 0.0)
        worst = np.max(_of_force(scenario, times[here], amplitudes, off, exact)) / SAFETY
        errors[FORCE] = float(worst) / (float(np.max(np.abs(answer.attraction))) or np.inf)
    return errors


def _of_force(
    scenario: Scenario,
    times: Real,
    amplitudes: Mapping[AmplitudeOf, Real],
    errors: Mapping[Key, Real],
    residuals: Mapping[Key, float],
) -> Real:
    """Bound the error of the attraction [N] at times [s] from the errors of the law's amplitudes."""
    now = {name.name: row for name, row in amplitudes.items()}
    off = {name.name: row + errors[name] for name, row in amplitudes.items()}
    pull = total_pull(scenario, now)
    force = attraction(scenario, pull, times)
    residual = 2 * max(residuals[name] for name in amplitudes)
    moved = np.abs(attraction(scenario, total_pull(scenario, off), times) - force)
    left = np.abs(
        attraction(scenario, pull * (1 + residual), times) - force
    )  # more where the area grows with it
    return np.asarray(SAFETY * moved + SPREAD * left)


def _respond(scenario: Scenario, transfers: dict[Key, Transfer], times: Real) -> dict[Key, Real]:
    """Return the responses of linear quantities to one drive, without leaks, limits and motion, shape (1, n)."""
    amplifier, drive, settled = scenario.circuit.amplifier, scenario.drive, scenario.time.settled
    if amplifier is None or drive.quantity == "current":
        found = transient(transfers, drive, times[0], settled=settled)
    elif amplifier.is_limited:
        found = transient(transfers, drive, times[0])
        found = {name: amplifier.gain * row for name, row in found.items()}
    else:
        found = transient(amplified(transfers, amplifier), drive, times[0], settled=settled)
    return {name: row[None] for name, row in found.items()}


def _differences(
    scenario: Scenario, section: ModalSection, fit: _DifferenceFit, *, settled: bool
) -> tuple[dict[Key, Transfer], dict[Key, float]]:
    """Return the fits of declared - reduced of every linear quantity, and their relative residuals."""
    declared = linear_quantities(scenario, phasors(scenario, fit.frequency, leaks=False))
    reduced = linear_quantities(scenario, section)
    reduced.pop("stack_voltage")  # the sum of the layer voltages, and 0 under a drive of 0 V
    transfers, residuals = {}, {}
    for name in reduced:
        # a current is the rate of change of its charge, which varies far less over frequency
        axis = 2j * np.pi * fit.frequency if name == CURRENT else 1.0
        pair = declared[name] / axis, reduced[name].at(fit.frequency) / axis
        unasked = name == CURRENT or bool(integral_weight(reduced[name]))
        found, residuals[name] = fit.of(*pair, unasked=unasked)
        transfers[name] = _slope(found) if name == CURRENT else found
    if settled or not np.any(section.modes.charges):
        return transfers, residuals
    left = linear_quantities(scenario, left_by_charge(scenario, fit.frequency, section.modes.charges))
    for name in reduced:
        found, residual = fit.of(left[name], reduced[name].free_at(fit.frequency))
        transfers[name] = replace(transfers[name], free=found.gains * found.rates)
        residuals[name] = max(residual, residuals[name])
    return transfers, residuals


def _slope(transfer: Transfer) -> Transfer:
    """Return the transfer function of the rate of change of a quantity: s times that of the quantity."""
    weights = transfer.gains * transfer.rates
    return Transfer(
        rates=transfer.rates, gains=-weights, direct=float(np.sum(weights)), slope=transfer.direct, static=0.0
    )


class _DifferenceFit:
    """Signed relaxations on a fixed grid of rates that follow D over a band.

    Parameters
    ----------
    low, high : float
        Band [Hz].
    steady : bool
        Whether D is fitted at zero frequency as well.
    smallest : tuple of float
        Smallest singular values over the largest that are kept; the fit is made with each [1].
    """

    def __init__(self, low: float, high: float, *, steady: bool, smallest: tuple[float, ...]) -> None:
        self.frequency = _spaced(low, high, ROWS_PER_DECADE)
        self.rates = 2 * np.pi * _spaced(low / BEYOND, high * BEYOND, POLES_PER_DECADE)
        falls = [(self.frequency / low) ** -power for power in POWERS]
        if steady:
            self.frequency = np.append(AT_REST, self.frequency)
            self.rates = np.append(1e-6 * self.rates[0], self.rates)
            falls = [np.append(fall[0], fall) for fall in falls]
        s = 2j * np.pi * self.frequency[:, None]
        columns = np.concatenate([np.ones((len(s), 1)), self.rates / (s + self.rates)], axis=1)
        self.columns = np.concatenate([columns.real, columns.imag])
        weights = [np.tile(1 / fall, 2) for fall in falls]
        with one_thread():
            self.inverses = np.concatenate([_inverses(self.columns, row, smallest) for row in weights])

    @staticmethod
    @functools.lru_cache(maxsize=16)
    def over(low: float, high: float, *, steady: bool, smallest: tuple[float, ...]) -> _DifferenceFit:
        """Return the fit over a band: the same object for the same band."""
        return _DifferenceFit(low, high, steady=steady, smallest=smallest)

    def of(self, declared: Complex, reduced: Complex, *, unasked: bool = False) -> tuple[Transfer, float]:
        """Return the fit of one D and its largest residual over the quantity; with `unasked` without zero frequency."""
        difference, size = declared - reduced, np.maximum(np.abs(declared), np.abs(reduced))
        if unasked and self.frequency[0] == AT_REST:
            difference[0], size[0] = difference[1], size[1]
        wanted = np.concatenate([difference.real, difference.imag])
        size[0] = max(size[:2])  # at rest a quantity may vanish
        floor = np.finfo(float).eps * float(np.max(size, initial=0.0))
        weights = 1 / np.tile(np.maximum(size, floor or 1.0), 2)
        tried = (self.inverses @ wanted).reshape(-1, self.columns.shape[1])
        left = np.max(np.abs(tried @ self.columns.T - wanted) * weights, axis=1)
        best = int(np.argmin(left))
        found = tried[best]
        return Transfer(rates=self.rates, gains=found[1:], direct=float(found[0])), float(left[best])


def _inverses(columns: Real, weights: Real, smallest: tuple[float, ...]) -> Real:
    """Return pseudo-inverses of weighted rows with columns scaled to equal norms, one below the other."""
    weighted = columns * weights[:, None]
    sizes = np.linalg.norm(weighted, axis=0)
    left, values, right = np.linalg.svd(weighted / sizes, full_matrices=False)
    parts = []
    for least in smallest:
        kept = values > least * values[0]
        inverse = (right[kept].T / values[kept]) @ left[:, kept].T
        parts.append(inverse / sizes[:, None] * weights)
    return np.concatenate(parts)


def _spaced(low: float, high: float, per_decade: int) -> Real:
    return np.geomspace(low, high, max(2, int(np.ceil(per_decade * np.log10(high / low))) + 1))


def extremes(scenario: Scenario, times: Real, known: tuple[float, float]) -> Extremes | None:
    """Return what to note of very many times (n,) [s] for `answer_errors`; None where it needs all values."""
    judged = _judged(scenario, times, known)
    if len(times) <= MANY or not np.any(judged):
        return None
    unjudged = {"drive_voltage", "plate_voltage", "stack_voltage", "interface_field", "amplifier_current"}
    if any(part.begins_with(times) for part in scenario.drive.parts()):
        unjudged.add(CURRENT)  # every time is at a corner
    return Extremes(times, _probes_among(judged), unjudged)


def _judged(scenario: Scenario, times: Real, known: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which times (n,) [s] are judged: those at which the material is known, without discontinuities of the drive."""
    lasts = 1 / (2 * np.pi * known[0]) if known[0] and not scenario.time.settled else np.inf
    return (times <= lasts) & ~_at_corner(scenario.drive, times, bends=False)


def _probes_among(judged: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the indices of the probes among the judged times."""
    places = probe_places(int(np.count_nonzero(judged)))
    return places if np.all(judged) else np.flatnonzero(judged)[places]


def known_band(scenario: Scenario) -> tuple[float, float]:
    """Return the band in which the permittivities of all layers are known."""
    bands = [layer.material.band for layer in scenario.stack.layers.values()]
    return max(low for low, _ in bands), min(high for _, high in bands)


def memory_diagnostics(
    scenario: Scenario,
    errors: Mapping[Key, Judged],
    times: Real,
    *,
    known: tuple[float, float],
    method: Method,
) -> list[Diagnostic]:
    """Return the error of a response at times (n,) [s] due to the Debye sums of materials, and from when on it is unknown."""
    layers = scenario.stack.layers
    reduced = [name for name, layer in layers.items() if layer.material.debye() is None]
    if not reduced:
        return []
    return [*_of_error(reduced, errors, method, times, known), *_beyond_tables(scenario, times, known)]


def _of_error(
    reduced: list[str],
    errors: Mapping[Key, Judged],
    method: Method,
    times: Real,
    known: tuple[float, float],
) -> list[Diagnostic]:
    if not errors:
        return []
    names = " and ".join(f"'{name}'" for name in reduced)
    judged = {name: found for name, found in errors.items() if name != CURRENT}
    largest = {"fields and voltages": max(found.of_peak for name, found in judged.items() if name != FORCE)}
    largest |= {
        what: errors[name].of_peak
        for name, what in ((FORCE, "the attraction"), (CURRENT, "the current"))
        if name in errors
    }
    parts = ", ".join(f"{what} by at most {100 * error:.2g} %" for what, error in largest.items())
    change = f"{parts} of their peak"
    stands = f"{names} {'is' if len(reduced) == 1 else 'are'} represented by a sum of Debye relaxations"
    if not method.by_modes:  # else the error found bounds the response, which is linear in the drive
        text = (
            f"{stands}: without leak, motion, limits and renewal that changes {change};"
            f" its effect on the result of the solver '{method.name}' is not known"
        )
        return [Diagnostic("memory", "unknown", text)]
    text = f"{stands}, which changes {change}"
    at_once = {
        what: max(
            (found.jump for name, found in errors.items() if (name == FORCE) == (what == "attraction")),
            default=0.0,
        )
        for what in ("fields and voltages", "attraction")
    }
    jumps = max(at_once.values()) > LARGEST
    if jumps:
        each = ", ".join(f"{what} by up to {100 * error:.2g} %" for what, error in at_once.items())
        text += (
            f"; right at a discontinuity of the drive, where the response is that of infinite frequency, it changes {each}:"
            " declare the edge time of the real source or circuit.source_resistance, or leave that output time out"
        )
    share, lost = max(found.share for found in judged.values()), min(found.lost for found in judged.values())
    if np.isfinite(lost):
        first = next(name for name, found in judged.items() if found.lost == lost)
        called = first.replace("_", " ") if isinstance(first, str) else str(first)
        text += (
            f"; the {called} is not known to {100 * LARGEST:g} % of its remaining amplitude from"
            f" {format_quantity(lost, 's', digits=3)} on"
        )
        if np.isfinite(known[1]):
            text += f"; {_better_table(times, known)}"
    state = "warning" if np.isfinite(lost) or jumps else "ok"
    return [Diagnostic("memory", state, text, value=max(share, *at_once.values()), limit=LARGEST, unit="1")]


def _better_table(times: Real, known: tuple[float, float]) -> str:
    """State how a table has to be measured so that the response of a run is known."""
    lowest = min(known[0], 1 / (2 * np.pi * float(times[-1])))
    ends = " to ".join(format_quantity(end, "Hz", digits=3) for end in (lowest, known[1]))
    return f"measure the table from {ends} with three rows a decade or more, or fit a dispersion to it (electrovib fit-material)"


def _beyond_tables(scenario: Scenario, times: Real, known: tuple[float, float]) -> list[Diagnostic]:
    """Return which times of a response depend on frequencies outside the tables of materials."""
    (low, high), said = known, []
    if not low and np.isinf(high):
        return []
    last = 1 / (2 * np.pi * low) if low else np.inf
    first = 1 / (2 * np.pi * high)
    if scenario.time.settled:
        slowest = lowest_frequency(scenario)
        if slowest < low * (1 - SAME):
            said.append(f"the drive contains {format_quantity(slowest, 'Hz', digits=3)}, below the table")
    elif times[-1] > last:
        said.append(f"the response is not known from {format_quantity(last, 's', digits=3)} on")
    if shortest_time(scenario, times) < first * (1 - SAME):
        moment = format_quantity(first, "s", digits=3)
        said.append(f"the response is not known within {moment} after a corner of the drive")
    if not said:
        return []
    tables = " and ".join(
        f"'{name}'" for name, layer in scenario.stack.layers.items() if np.isfinite(layer.material.band[1])
    )
    ends = " to ".join(format_quantity(end, "Hz", digits=3) for end in known)
    text = f"{tables} is measured from {ends} only: {', and '.join(said)}"
    return [Diagnostic("measured band", "unknown", text, value=float(times[-1]), limit=last, unit="s")]
