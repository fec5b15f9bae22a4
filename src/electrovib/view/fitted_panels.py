"""Figures of a fit as data: each signal with its model, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.study.reproduction import REFERENCE, Curve, Panel

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from electrovib.recordings.fit.prediction import Residuals

_MOST_POINTS: Final = 600
"""Samples of a recording that a figure shows."""
_BOTH: Final = "Points: data. Lines: model with the estimated parameters."


def fit_panels(residuals: Sequence[Residuals]) -> list[Panel]:
    """Make the figures of a fit: data with model, and residuals, one figure for all recordings of a signal."""
    panels: list[Panel] = []
    for signal in dict.fromkeys(each.observed.signal for each in residuals):
        panels += _of_signal(signal, [each for each in residuals if each.observed.signal == signal])
    return panels


def _of_signal(signal: str, own: Sequence[Residuals]) -> list[Panel]:
    words, axis = signal.replace("_", " "), own[0].observed.axis
    is_complex = own[0].observed.parts == 2
    shared: dict[str, Any] = {"x": (axis, SIGNALS[axis].unit), "log_x": axis == "frequency"}
    found = [
        Panel(
            id=f"data-{signal}",
            title=f"{words[0].upper()}{words[1:]}: data and model",
            caption=_BOTH,
            y=(f"modulus of the {words}" if is_complex else words, SIGNALS[signal].unit),
            curves=_both(own, np.abs if is_complex else np.real),
            log_y=is_complex,
            **shared,
        )
    ]
    if is_complex:
        found.append(
            Panel(
                id=f"phase-{signal}",
                title=f"Phase of the {words}: data and model",
                caption=_BOTH,
                y=("phase", "rad"),
                curves=_both(own, np.angle),
                **shared,
            )
        )
    found.append(
        Panel(
            id=f"residuals-{signal}",
            title=f"Residuals of the {words}",
            caption="Data less model over the standard deviation of the noise; of complex data the real part.",
            y=("residual over noise", "1"),
            curves=tuple(
                Curve(
                    label=each.recording,
                    x=each.observed.x[_few(each)],
                    y=np.real(each.values / (each.noise * each.observed.scale))[_few(each)],
                    kind="points",
                    look=at,
                )
                for at, each in enumerate(own)
            ),
            **shared,
        )
    )
    return found


def _both(own: Sequence[Residuals], part: Callable[..., NDArray[np.float64]]) -> tuple[Curve, ...]:
    curves = []
    for at, each in enumerate(own):
        x, few = each.observed.x, _few(each)
        data = np.asarray(part(each.observed.y))
        shade = at if own[1:] else REFERENCE  # a line over points of its own colour hides them
        curves += [
            Curve(label=f"{each.recording}, data", x=x[few], y=data[few], kind="points", look=shade),
            Curve(label=f"{each.recording}, model", x=x, y=np.asarray(part(each.predicted)), look=at),
        ]
    return tuple(curves)


def _few(each: Residuals) -> NDArray[np.int64]:
    """Indices of at most `_MOST_POINTS` samples, evenly over the recording."""
    size = each.observed.x.size
    return np.unique(np.linspace(0, size - 1, min(size, _MOST_POINTS)).astype(np.int64))
