"""The paper's own set-ups, ready to run."""

from __future__ import annotations

import functools
from typing import Any, Final

from electrovib.papers import preset_notes
from electrovib.papers.palmar_1995 import MEN, palmar
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import AIR, Scenario, preset

PRESETS = preset_notes(__name__)

NOT_PRINTED = "not printed in the paper; a choice"
PRINTED = "Vezzoli 2014, section 3.1"

_FILM: Final = (values.FILM, PRINTED)
_THICKNESS: Final = (values.SKIN_THICKNESS, f"{PRINTED} (its reference 7)")
_SKIN: Final = {
    "thickness": _THICKNESS,
    "material": {
        "model": "Constant",
        "permittivity": (values.SKIN_PERMITTIVITY, f"{PRINTED} (its reference 6), frequency not printed"),
        "conductivity": (
            values.CONDUCTIVITY,
            "from the printed 7.7 ms, taken as the time constant of the voltage; circular",
        ),
    },
}
_GAP: Final = {
    "thickness": (1e-6, "not in the paper; of the order of the roughness of skin"),
    "material": {
        "model": "Constant",
        "permittivity": (1.0, "air"),
        "conductivity": (1 / 8.7e8, "not in the paper; gives a time constant near 8 ms"),
    },
}
_TRAPEZIUM: Final = {
    "model": "Trapezium",
    "high": (values.VOLTAGE, "Vezzoli 2014, section 4"),
    "rise": (values.RAMP, "not printed; 36 ms gives the paper's 2.5 mN with 7.7 ms and law (1)"),
    "hold": (0.1, NOT_PRINTED),
    "fall": (values.RAMP, NOT_PRINTED),
}


def _set_up(title: str, changes: dict[str, Any]) -> Scenario:
    """Return the set-up common to figures 6 and 7, with changes."""
    common = {
        "contact.area": (values.AREA, PRINTED),
        "circuit.return_path.resistance": (
            1000.0,
            "not printed: the paper does not state whether the subject was grounded",
        ),
        "limits.current": (250e-6, "Vezzoli 2014, section 4"),
    }
    return preset(title=title, unchanged=NOT_PRINTED, changes=common | changes)


def _figure_2(figure_6_gap: Scenario) -> dict[str, Scenario]:
    fig2 = preset(
        figure_6_gap,
        title="Vezzoli 2014, figure 2: finger held off the plate, a gap that does not conduct",
        changes={
            "drive.hold": (1.0, NOT_PRINTED),
            "stack.gap.thickness": (100e-6, "not printed: the finger was held close to the plate by hand"),
            "stack.gap.material": AIR,
            "motion.distance": {"model": "HeldOff"},
            "load.normal_force": (0.0, "Vezzoli 2014, figure 2: no contact"),
        },
    )
    tremor = {"model": "TremblingDistance", "mean": 100e-6, "amplitude": 10e-6, "frequency": 8.0}
    rig = {
        "model": "Tribometer",
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
        "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
    }
    held = preset(
        fig2,
        title="Vezzoli 2014, figure 2: finger held off the plate by a hand that trembles",
        changes={"motion.distance": (tremor, NOT_PRINTED), "rig": (rig, NOT_PRINTED)},
    )
    return {"fig2": fig2, "fig2_tremor": held}


def _figure_6() -> dict[str, Scenario]:
    fig6 = _set_up(
        "Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse on a plastic film",
        {
            "drive": _TRAPEZIUM,
            "force.model": "Vezzoli2014Causal",
            "stack": {"insulator": _FILM, "stratum_corneum": _SKIN},
        },
    )
    static = preset(
        fig6,
        title="Vezzoli 2014, figure 6 with the static law (1): no charge is lost",
        changes={"force.model": "EffectiveMedium"},
    )
    gap = preset(
        fig6,
        title="Vezzoli 2014, figure 6 as a stack with a leaky gap, Maxwell stress in the gap",
        changes={
            "force.model": "MaxwellStressInGap",
            "stack": {"insulator": _FILM, "gap": _GAP, "stratum_corneum": _SKIN},
        },
    )
    return {"fig6": fig6, "fig6_static": static, "fig6_gap": gap}


def _figure_7() -> Scenario:
    palm = palmar(exponent=MEN, conductance=20e-6)
    skin = {
        "model": "ConstantPhase",
        "permittivity": (palm.permittivity, "palmar_1995, anchored to the paper's 6.9 nF"),
        "reference_frequency": (palm.reference_frequency, "palmar_1995, where it is anchored"),
        "exponent": (palm.exponent, "palmar_1995"),
        "conductivity": (palm.conductivity, "palmar_1995, 20 uS"),
    }
    return _set_up(
        "Vezzoli 2014, figure 7: mean force over frequency on a thin coating",
        {
            "drive.model": "Sine",
            "drive.amplitude": (100.0, NOT_PRINTED),
            "drive.frequency": (1000.0, "one point of the paper's 100 Hz to 10 kHz"),
            "force.model": "Vezzoli2014PerFrequency",
            "time.initial_state.model": "PeriodicState",
            "frequency": {"low": 100.0, "high": 1e4, "samples": 81},
            "stack": {
                "insulator": (values.COATING, "not printed: only that C_i is comparable with C_s"),
                "stratum_corneum": {"thickness": _THICKNESS, "material": skin},
            },
        },
    )


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return the paper's set-ups: every value has its source, and what the paper does not print is marked."""
    figure_6 = _figure_6()
    return {**_figure_2(figure_6["fig6_gap"]), **figure_6, "fig7": _figure_7()}
