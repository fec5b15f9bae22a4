"""One pulse as an animation: where the charge is, the voltage across each layer and the force, at every moment that is shown."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.fading_words import answer, sentences
from electrovib.apps.explorer.pictures import rounded
from electrovib.physics.material import Constant
from electrovib.view.plots.layers import drawn_heights
from electrovib.view.style import layer_colours, prefix_for, pretty_quantity, pretty_unit

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario

FRAMES: Final = 300
"""Moments of an animation, at most."""
SIGNS: Final = 12
"""Signs of charge that stand for the largest charge of an animation, at most."""
_TURNS: Final = 8
"""Highest and lowest voltages after which a drive that goes on is shown no longer."""
_UNCHANGED: Final = 0.01
"""Part of its largest value by which a signal may still change where it is shown no longer."""
_LIKE_THE_FORCE: Final = 0.05
"""Largest difference between the force and the squared field of the layer that the force follows, over their peaks."""
_NEEDED: Final = ("field", "displacement", "drive_voltage", "electrostatic_force")


@dataclass(frozen=True, eq=False, kw_only=True)
class Pulse:
    """The part of a run that is shown, at its n times.

    Parameters
    ----------
    layers : tuple of str
        Names in words, from the plate to the finger.
    time, drive, force : ndarray, shape (n,)
        Time [s], voltage of the drive [V] and attraction [N].
    fields, voltages, displacements : ndarray, shape (layers, n)
        Field [V/m], voltage [V] and bound displacement [C/m2] of each layer; positive from the plate to the finger. The
        displacement holds all polarisation, however slow, and no conducted charge.
    conductivity : tuple of float
        Of each layer [S/m]; NaN for one with a leak that is not ohmic.
    followed : int or None
        Place of the layer whose squared field the force follows; None where there is no such layer.
    is_moving : bool
        Whether a layer changes its thickness.
    caption : str
        Which part of the run is shown.
    """

    layers: tuple[str, ...]
    time: Real
    drive: Real
    force: Real
    fields: Real
    voltages: Real
    displacements: Real
    conductivity: tuple[float, ...]
    followed: int | None
    is_moving: bool
    caption: str

    @property
    def charges(self) -> Real:
        """Free charge on the plate, on each interface between layers and on the finger's tissue, (layers + 1, n) [C/m2].

        Gauss's law: the displacement of a layer begins and ends on free charge, so that the sum is 0 at any time.
        """
        return np.diff(self.displacements, axis=0, prepend=0.0, append=0.0)


def why_not(found: Computed) -> str:
    """Return why a run has no animation of its charges; empty where it has one."""
    if found.has("drive_current"):
        return (
            "There is no animation here: the drive prescribes a current, and with it the charge that flows to the plate. The"
            " animation is that of a prescribed voltage, such as a Trapezium."
        )
    lacking = [name for name in _NEEDED if not (found.has(name) and np.isfinite(found.values(name)).all())]
    if lacking:
        words = " and ".join(name.replace("_", " ") for name in lacking)
        return (
            f"There is no animation here: it needs {words} at every time, which this scenario does not have."
        )
    if not np.any(found.values("displacement")):
        return "There is no animation here: no layer is charged at any time."
    return ""


def pulse_of(found: Computed) -> Pulse:
    """Return one period of a run, or all of it until nothing changes any more."""
    scenario, layers = found.scenario, found.scenario.stack.layers
    thickness = np.array([layer.thickness for layer in layers.values()])[:, None]
    gap = scenario.stack.gap_name
    if found.has("gap") and gap:
        thickness = np.where(np.array([[name == gap] for name in layers]), found.values("gap"), thickness)
    fields, force = found.values("field"), found.values("electrostatic_force")
    kept, caption = _shown(found)
    return Pulse(
        layers=tuple(name.replace("_", " ") for name in layers),
        time=found.values("time")[kept],
        drive=found.values("drive_voltage")[kept],
        force=force[kept],
        fields=fields[:, kept],
        voltages=(fields * thickness)[:, kept],
        displacements=found.values("displacement")[:, kept],
        conductivity=tuple(
            math.nan if layer.leak else float(layer.material.conductivity) for layer in layers.values()
        ),
        followed=_followed(scenario, fields[:, kept], force[kept]),
        is_moving=thickness.shape[1] > 1,
        caption=caption,
    )


def _shown(found: Computed) -> tuple[Indices, str]:
    """Choose the samples of one pulse, and say which they are."""
    time, drive = found.values("time"), found.values("drive_voltage")
    period, whole = found.scenario.drive.period, _seconds(time[-1])
    places = np.arange(len(time))
    words = f"Shown is the whole run, {whole}"
    if period is not None and period < time[-1]:
        places = np.flatnonzero(time <= period * (1 + 1e-9))
        words = f"Shown is one period, {_seconds(period)}"
    elif (end := _quiet_from(found)) < len(time):
        places = places[:end]
        words = f"Shown are the first {_seconds(time[end - 1])} of {whole}, after which little changes"
    slope = np.sign(np.diff(drive[places]))
    moves = np.flatnonzero(slope)
    turns = moves[1:][np.diff(slope[moves]) != 0]
    if len(turns) > _TURNS:
        places = places[: turns[_TURNS] + 1]
        words = f"Shown are the first {_seconds(time[places[-1]])} of {whole}"
    return _without_jumps(places, drive[places], is_settled=found.scenario.time.settled), words


def _without_jumps(places: Indices, drive: Real, *, is_settled: bool) -> Indices:
    """Omit the samples at a jump of the drive, which have its voltage after the jump and the fields before it."""
    jumps = np.abs(np.diff(drive, prepend=drive[:1])) > 0.5 * np.ptp(drive)
    jumps[0] = is_settled and jumps[-1]
    return places[~jumps]


def _quiet_from(found: Computed) -> int:
    """Return the number of samples until voltage, force and charges stay as they are, with a few of them."""
    signals = ("drive_voltage", "electrostatic_force", "displacement")
    changing = [
        np.abs(rows - rows[:, -1:]) > _UNCHANGED * np.abs(rows).max()
        for rows in (np.atleast_2d(found.values(name)) for name in signals)
    ]
    last, count = int(np.flatnonzero(np.any(np.vstack(changing), axis=0)).max(initial=0)), len(changing[0][0])
    return min(max(last + count // 20, count // 4), count)


def _seconds(value: float) -> str:
    return pretty_quantity(float(value), "s", digits=3)


def _followed(scenario: Scenario, fields: Real, force: Real) -> int | None:
    """Return the layer whose squared field has the course of the force: that of the force law, if it is one of several."""
    squares, names = fields**2, list(scenario.stack.layers)
    peaks, peak = squares.max(axis=1), float(np.abs(force).max())
    if not (peak > 0 and np.all(peaks > 0)):
        return None
    apart = np.abs(squares / peaks[:, None] - force / peak).max(axis=1)
    surface = scenario.force.evaluation_surface
    preferred = scenario.stack.gap_name if surface == "gap" else surface
    best = min(range(len(names)), key=lambda each: (names[each] != preferred, apart[each]))
    if apart[best] > _LIKE_THE_FORCE:
        best = int(np.argmin(apart))
    return best if apart[best] <= _LIKE_THE_FORCE else None


def animation(found: Computed) -> dict[str, Any]:
    """Return everything that the browser draws, with numbers of few digits in SI; empty where there is no animation."""
    if why_not(found):
        return {}
    pulse = pulse_of(found)
    places, charges = _frames(pulse), pulse.charges
    sign = _round_up(float(np.abs(charges).max()) / SIGNS, range(1, 11))
    layers = found.scenario.stack.layers
    heights = drawn_heights({name: layer.thickness for name, layer in layers.items()})
    spoken = sentences(pulse)
    starts = [int(np.searchsorted(places, start)) for start, _ in spoken]
    return {
        "answer": answer(pulse),
        "layers": [
            {"name": words, "height": round(heights[name], 3), "colour": layer_colours(list(layers))[name]}
            for name, words in zip(layers, pulse.layers, strict=True)
        ],
        "time": rounded(pulse.time[places]),
        "drive": rounded(pulse.drive[places]),
        "force": rounded(pulse.force[places]),
        "voltages": [rounded(row) for row in pulse.voltages[:, places]],
        "charges": [rounded(row) for row in charges[:, places]],
        "lines": [rounded(row / sign) for row in pulse.displacements[:, places]],
        "starts": starts,
        "said": [words for _, words in spoken],
        "axes": {
            "time": _axis("time", pulse.time, "s", is_zero_in=False),
            "drive": _axis("voltage", pulse.drive, "V"),
            "force": _axis("force", pulse.force, "N"),
        },
        "caption": f"{pulse.caption}. {_legend(sign, found.scenario)}",
    }


def _legend(sign: float, scenario: Scenario) -> str:
    """Explain signs and lines; a layer that polarises slowly can have a field without a line."""
    instantaneous = all(isinstance(layer.material, Constant) for layer in scenario.stack.layers.values())
    without = ": a layer that no line crosses has hardly any field" if instantaneous else ""
    return (
        f"A sign stands for {pretty_quantity(sign, 'C/m2', digits=3)}, and the lines of the electric displacement join + and"
        f" −{without}. Layers are drawn enlarged where they are thin. The animation runs slower where more changes."
    )


def _frames(pulse: Pulse) -> Indices:
    """Choose samples whose distance is even in time and in what changes together, so that a short event is seen as well."""
    rows = np.vstack([pulse.drive, pulse.force, pulse.charges])
    largest = np.abs(rows).max(axis=1, keepdims=True)
    changes = np.abs(np.diff(rows / np.where(largest > 0, largest, 1.0))).max(axis=0)
    passed = np.diff(pulse.time) / (pulse.time[-1] - pulse.time[0])
    gone = np.append(0.0, np.cumsum(passed + changes / (changes.sum() or 1.0)))
    wanted = np.linspace(0.0, gone[-1], min(FRAMES, len(gone)))
    return np.unique(np.minimum(np.searchsorted(gone, wanted), len(gone) - 1))


def _axis(words: str, values: Real, unit: str, *, is_zero_in: bool = True) -> dict[str, Any]:
    """Return label, range and ticks of an axis, each with its place [SI] and its number in the unit of the label."""
    low, high = float(values.min()), float(values.max())
    if is_zero_in:
        low, high = min(low, 0.0), max(high, 0.0)
    if low == high:
        high = low + 1.0
    prefix, scale = prefix_for(max(abs(low), abs(high)), unit)
    step = _round_up((high - low) / scale / 5, (1, 2, 5, 10))
    counts = range(math.ceil(low / scale / step - 1e-9), math.floor(high / scale / step + 1e-9) + 1)
    return {
        "words": f"{words} [{pretty_unit(prefix + unit)}]",
        "low": low,
        "high": high,
        "ticks": [
            {"at": count * step * scale, "text": f"{count * step:.6g}".replace("-", "\N{MINUS SIGN}")}
            for count in counts
        ],
    }


def _round_up(value: float, digits: Iterable[int]) -> float:
    """Return the smallest of some digits times a power of ten that is not below the value."""
    power = 10.0 ** math.floor(math.log10(value) + 1e-9)
    return min(digit for digit in digits if digit * power >= value * (1 - 1e-9)) * power
