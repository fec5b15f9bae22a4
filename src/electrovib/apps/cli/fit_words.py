"""What ``electrovib fit`` prints: its verdict, or every estimate, note and residual."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.fit.power_law import PowerLawFit
    from electrovib.recordings.fit.sessions import SeparateFits
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.recordings.spectra.fitted import FittedMaterial
    from electrovib.view.fitted import FitResult

_MOST: Final = 5  # lines of a verdict


def posterior_lines(found: FitResult) -> list[str]:
    """Report the posterior distribution of each parameter, and the diagnostics of its chains."""
    from electrovib.core.units import format_quantity

    if found.posterior is None:
        return []
    units = {row.name: (row.unit, row.digits) for row in found.rows}
    lines, steps = [], found.posterior.steps
    for name, time in found.posterior.autocorrelation_time.items():
        unit, digits = units[name]
        lower, upper = (format_quantity(each, unit, digits=digits) for each in found.posterior.interval(name))
        lines.append(
            f"{name}: posterior 95 % interval {lower} to {upper}; autocorrelation time {time:.3g} of {steps} steps"
        )
    return lines + [
        f"warning: the samples may not represent the posterior: {each}" for each in found.posterior.problems
    ]


def brief(lines: Sequence[str]) -> list[str]:
    """Return five lines at most, of which the last one states what is omitted."""
    if len(lines) <= _MOST:
        return list(lines)
    return [*lines[: _MOST - 1], f"and {len(lines) - _MOST + 1} more lines: --all prints them"]


def separate_verdict(found: SeparateFits) -> list[str]:
    """State which recordings the model does not describe or that could not be fitted, and the means over all."""
    lines = [f"{record}: failed: {why}" for record, why in found.failures.items()]
    lines = [f"warning: {record}: {why}" for record, why in found.misfits.items()] + lines
    if len(lines) > 2:
        counted = f"{len(found.misfits)} of {len(found.fits)} recordings, and {len(found.failures)} could not be fitted"
        lines = [lines[0], f"warning: the model does not describe {counted}: --all names them"]
    return lines + _mean_lines(found) if found.means else separate_summary(found)


def separate_summary(found: SeparateFits) -> list[str]:
    """Report the estimates of each recording with their intervals, and their mean and scatter over the recordings."""
    lines = []
    for each in found.fits:
        if each.found is None:
            lines.append(f"{each.record}: failed: {each.problem}")
            continue
        fitted = [line for row in each.rows for line in row_lines(row)]
        lines += [f"{each.record}:", *(f"  {line}" for line in (*each.found.prescribed, *fitted))]
        if not each.found.estimate.converged:
            lines.append("  warning: the search ended without having converged")
        if each.record in found.misfits:
            lines.append(f"  warning: {found.misfits[each.record]}")
    return lines + _mean_lines(found)


def _mean_lines(found: SeparateFits) -> list[str]:
    """Report the mean of each parameter over the recordings, and its scatter."""
    lines = []
    for row in found.means:
        first, *notes = row_lines(row)
        counted = len(found.spreads[row.name].values)
        lines += [first.replace(row.name, f"{row.name}, mean of {counted} recordings", 1), *notes]
    return lines


def row_lines(row: EstimatedParameter) -> list[str]:
    """Write one estimate with its interval, or why it has none."""
    from electrovib.core.units import format_quantity

    line = f"{row.name}: {row.in_words(row.unit, why=row.note)}"
    if not row.method:
        return [line]
    if math.isfinite(row.systematic):
        ends = (format_quantity(end, row.unit, digits=row.digits) for end in row.systematic_ends)
        line += f", by calibration {' to '.join(ends)}"
    return [line, f"  {row.note}"] if row.note else [line]


def verdict(found: FitResult) -> list[str]:
    """State whether the model describes the data, which one they support, and each estimate with its interval."""
    lines = _warnings(found)
    if found.comparison is not None:
        lines.append(found.comparison.sentence)
    means = [row for row in found.rows if row.method == "sessions"]
    lines += [line for row in means for line in row_lines(row)]
    lines += posterior_lines(found)
    for row in found.rows:
        if row not in means:  # a note that two estimates share is stated once
            lines += [line for line in row_lines(row) if line not in lines]
    return lines


def _warnings(found: FitResult) -> list[str]:
    lines = [f"warning: {found.best.misfit.sentence}"] if found.best.misfit.sentence else []
    lines += ["; ".join(found.best.prescribed)] if found.best.prescribed else []
    if not found.best.estimate.converged:
        lines.append("warning: the search ended without having converged")
    return lines


def summary(found: FitResult) -> list[str]:
    """Report each estimate with its interval, what is not determined, and which model the data support."""
    lines = _warnings(found) + [line for row in found.rows for line in row_lines(row)]
    lines += [
        f"{each.recording}, {each.observed.signal}: {each.observed.x.size} samples, residual"
        f" {_spread(each.root_mean_square, each.observed.signal, relative=each.observed.relative)} rms"
        for each in found.best.residuals
    ]
    lines += posterior_lines(found)
    if found.comparison is not None:
        lines.append(found.comparison.sentence)
    return lines


def _spread(value: float, signal: str, *, relative: bool) -> str:
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import format_quantity

    return f"{100 * value:.3g} %" if relative else format_quantity(value, SIGNALS[signal].unit, digits=3)


def material_summary(found: FittedMaterial) -> list[str]:
    """Report how the material was fitted, each parameter with both uncertainties, and the diagnostics."""
    from electrovib.core.units import format_quantity
    from electrovib.recordings.spectra.fitted import both_uncertainties

    return [
        *found.history,
        *(
            f"{each.name}: {format_quantity(each.value, each.unit, digits=4)}, {both_uncertainties(each)}"
            for each in found.parameters
        ),
        *(f"{each.state}: {each.text}" for each in found.diagnostics),
    ]


def law_summary(law: PowerLawFit) -> list[str]:
    """Report the exponent with its interval, and that of each session."""
    return [
        f"exponent {law.exponent:.4g}, 95 % interval {law.lower:.4g} to {law.upper:.4g}",
        *(
            f"  {name}: exponent {each.exponent:.4g}, standard error {each.standard_error:.2g}"
            f" (ln y scatters by {each.scatter:.2g}), y at x = 1 in SI {each.factor:.4g}"
            for name, each in law.sessions.items()
        ),
        law.sentence,
    ]
