"""Figures of parameters over recordings that were fitted one by one, as data."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.study.reproduction import REFERENCE, Curve, Panel

if TYPE_CHECKING:
    from electrovib.recordings.fit.separate import SeparateFits


def parameter_panels(found: SeparateFits) -> list[Panel]:
    """Make one figure of each parameter over the numbered recordings, with 95 % intervals and the mean."""
    return [_panel(found, path) for path in found.free]


def _panel(found: SeparateFits, path: str) -> Panel:
    own = [next((row for row in each.rows if row.name == path), None) for each in found.fits]
    rows = [row for row in own if row is not None]
    numbers = np.array([number for number, row in enumerate(own, start=1) if row is not None], dtype=float)
    gap = np.full(numbers.size, math.nan)
    ends = np.array([[row.lower, row.upper, math.nan] for row in rows]).ravel()
    curves = [
        Curve(
            label="95 % interval",
            x=np.column_stack([numbers, numbers, gap]).ravel(),
            y=np.where(np.isfinite(ends), ends, math.nan),
            look=0,
        ),
        Curve(label="estimate", x=numbers, y=np.array([row.value for row in rows]), kind="points", look=0),
    ]
    if path in found.spreads:
        spread = found.spreads[path]
        across = np.array([0.5, len(own) + 0.5])
        curves.append(Curve(label="mean", x=across, y=np.full(2, spread.mean), kind="dashed", look=REFERENCE))
    names = ", ".join(f"{number}: {each.record}" for number, each in enumerate(found.fits, start=1))
    return Panel(
        id=f"parameter-{path.replace('.', '-')}",
        title=f"{path} over the recordings",
        caption=f"Recordings {names}. An interval that has no end is not drawn.",
        x=("recording", "1"),
        y=(path.rpartition(".")[2].replace("_", " "), rows[0].unit if rows else "1"),
        curves=tuple(curves),
    )
