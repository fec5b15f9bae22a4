"""The candidate causes, each a change of the paper's own scenario."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from electrovib.papers.kaczmarek_2006 import FAST, SLOW, rectifying, skin_conductivity
from electrovib.papers.vezzoli_2014 import compute
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.scenario import Scenario

RAMP, HOLD = 25e-3, 200e-3
"""Of the trapezoidal pulse on which the candidates are compared, a choice [s]."""
FILM_CHARGE = 70e-6
"""Charge that an earlier pass left on the film, a choice: 210 V [C/m2]."""
TRIBOCHARGE = 7e-6
"""Charge on the film as rubbing leaves it: 21 V, of the size of the effective voltage [C/m2]."""


@dataclass(frozen=True)
class Candidate:
    """One possible cause.

    `changes` are put into the paper's scenario by dotted path; `test` is the experiment that would
    distinguish the cause from the others, `signal` where it appears, `values` what was taken, marked where it
    is a choice. `linear`: its response is linear in the drive, so that a periodic trapezoidal pulse of equal
    halves gives equal pulses.
    """

    name: str
    changes: Mapping[str, Any]
    test: str
    values: str
    signal: str = "electrostatic_force"
    linear: bool = True

    def scenario(self, *, ramp: float = RAMP, hold: float = HOLD) -> Scenario:
        """Put the change into the paper's scenario with a ramp and a hold [s]."""
        pulse = {"drive.rise": ramp, "drive.hold": hold, "drive.fall": ramp}
        return scenarios()["fig6"].replace(pulse).replace(self.changes)


_CHOICE = "a choice"
_ALL_SKIN: Final = {"stack.stratum_corneum.material.conductivity": 0.0}
"""The leak alone then conducts in the skin."""


def _polarity(positive: float, negative: float) -> dict[str, Any]:
    leak = rectifying(skin_conductivity, positive=positive, negative=negative)
    return _ALL_SKIN | {"stack.stratum_corneum.leak": leak}


def _sliding(speed: float, charge: float = 0.0) -> dict[str, Any]:
    return {"motion.speed": speed, "motion.renews_film": True, "stack.insulator.initial_charge": charge}


def _skin(name: str) -> dict[str, Any]:
    return {"stack.stratum_corneum.material": compute.force_skins()[name].material}


_MEMORY_TEST = "vary the hold: the ratio returns to 1 as a power of it; both halves of a periodic trapezoidal pulse are equal"
_SLIDING_TEST = (
    "vary the speed: the plateau of the hold is proportional to it; a finger at rest shows neither"
)

_RELAXING: Final = {
    "model": "Tribometer",
    "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
    "lateral": {
        "natural_frequency": 500.0,
        "damping_ratio": 0.5,
        "bandwidth": 1e3,
        "creep": {"share": 0.25, "time": 50e-3},
    },
}
"""A rig whose sensor creeps."""


@functools.cache
def candidates() -> tuple[Candidate, ...]:
    """Return every candidate at plausible values."""
    return (
        Candidate("the paper's model", {}, "the reference", "one relaxation time of 7.7 ms"),
        *(
            Candidate(f"dispersive skin, {name}", _skin(name), _MEMORY_TEST, "cited skin, causal law")
            for name in ("palmar men 2 uS", "palmar women 10 uS", "1963 impedance")
        ),
        *_of_polarity(),
        *_of_sliding(),
        *_of_charge_and_field(),
        *_beyond_the_field(),
    )


def _of_polarity() -> tuple[Candidate, ...]:
    """Return a skin that conducts better for positive voltages, and one that conducts better for negative ones."""
    two_taus = f"time constants {SLOW * 1e3:g} and {FAST * 1e3:g} ms by polarity, {_CHOICE}"
    test = "invert the drive, 0 to -1000 V, on a neutral film with the plate voltage recorded: the ratio is inverted"
    weaker, stronger = _polarity(FAST, SLOW), _polarity(SLOW, FAST)
    return (
        Candidate("positive pulses weaker", weaker, test, f"{two_taus}, as Kaczmarek 2006", linear=False),
        Candidate("positive pulses stronger", stronger, test, f"{two_taus}, the other sign", linear=False),
    )


def _of_sliding() -> tuple[Candidate, ...]:
    """Return a finger that slides onto fresh film, neutral or charged."""
    charged = f"{FILM_CHARGE * 1e6:g} uC/m2 on the fresh film, {_CHOICE}; 30 mm/s"
    wiped = "neutralise the film before the pass, then do not: only this changes"
    neutral = [
        Candidate(
            f"sliding at {speed * 1e3:g} mm/s",
            _sliding(speed),
            _SLIDING_TEST,
            "fresh film, the paper's 7.7 ms",
        )
        for speed in (0.01, 0.03, 0.1)
    ]
    over_charge = [
        Candidate(f"sliding over {word} film", _sliding(0.03, sign * FILM_CHARGE), wiped, charged)
        for word, sign in (("positive", 1), ("negative", -1))
    ]
    return (*neutral, *over_charge)


def _of_charge_and_field() -> tuple[Candidate, ...]:
    """Return charge left by an earlier touch, and a skin that conducts better in a large field."""
    growing = {"model": "FieldConduction", "conductivity": skin_conductivity(SLOW), "onset_field": 3e3}
    return (
        Candidate(
            "charge left on the film, finger at rest",
            {"stack.insulator.initial_charge": -TRIBOCHARGE},
            "discharge the film before touching: only the first milliseconds change",
            f"{-TRIBOCHARGE * 1e6:g} uC/m2 under the finger at the beginning, {_CHOICE}",
        ),
        Candidate(
            "leak that grows with the field",
            _ALL_SKIN | {"stack.stratum_corneum.leak": growing},
            "vary the voltage: the force is not proportional to its square, and the decay changes",
            f"conductivity doubled at 3 kV/m in the skin, {_CHOICE}",
            linear=False,
        ),
    )


def _beyond_the_field() -> tuple[Candidate, ...]:
    """Return the candidates that change neither the stack nor the charge: mechanics, amplifier and sensor."""
    creeping = {
        "model": "Creep",
        "steady": {"model": "Coulomb", "coefficient": 0.5},
        "relaxations": [{"share": 0.2, "time": tau} for tau in (4e-3, 70e-3, 1.4)],
    }
    sinking = {"source_current": 250e-6, "sink_current": 2e-6, "stray_capacitance": 50e-12}
    return (
        Candidate(
            "viscoelastic skin",
            {"friction": creeping},
            "step the friction without a voltage, by load or squeeze film: the same asymmetry",
            f"shares of 0.2 at 4 ms, 70 ms and 1.4 s (times Pawluk and Howe 1999, shares {_CHOICE})",
            signal="lateral_force",
        ),
        Candidate(
            "amplifier sinks less than it sources",
            {"circuit.amplifier": sinking},
            "record the voltage at the plate: its falling ramp is slower than commanded",
            f"250 uA out, 2 uA back, 50 pF of stray capacitance, {_CHOICE}",
            linear=False,
        ),
        Candidate(
            "sensor relaxes",
            {"rig": _RELAXING},
            "step the sensor with a weight: the same relaxation without finger and voltage",
            f"a quarter of the signal follows with 50 ms, {_CHOICE}; the cause that the paper suspects",
            signal="lateral_force_measured",
        ),
    )
