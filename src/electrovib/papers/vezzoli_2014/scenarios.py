"""The paper's own set-ups, ready to run."""

from __future__ import annotations

import functools
from typing import Any

from electrovib.papers.palmar_1995 import MEN, palmar
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import Scenario

NOT_PRINTED = "not printed in the paper; a choice"
PRINTED = "Vezzoli 2014, section 3.1"


def _film() -> dict[str, Any]:
    material = {"model": "Constant", "permittivity": values.FILM_PERMITTIVITY}
    return {"thickness": values.FILM_THICKNESS, "material": material}


def _skin(material: Any = None) -> dict[str, Any]:
    point = values.skins()["point"].material
    return {"thickness": values.SKIN_THICKNESS, "material": material or point}


def _common(title: str) -> dict[str, Any]:
    return {
        "title": title,
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {"model": "FixedArea", "area": values.AREA},
        "load": {"normal_force": 0.5},
        "circuit": {"return_path": {"model": "Grounded", "resistance": 1000.0}},
        "limits": {"current": 250e-6},
        "sources": {
            "friction.coefficient": NOT_PRINTED,
            "contact.area": PRINTED,
            "load.normal_force": NOT_PRINTED,
            "circuit.return_path.resistance": "not printed: the paper does not say whether the subject was grounded",
            "stack.insulator.thickness": PRINTED,
            "stack.insulator.material.permittivity": PRINTED,
            "stack.stratum_corneum.thickness": f"{PRINTED} (its reference 7)",
            "stack.stratum_corneum.material.permittivity": f"{PRINTED} (its reference 6), frequency not printed",
            "stack.stratum_corneum.material.conductivity": "inverse of the printed 7.7 ms, read as the voltage's; circular",
            "limits.current": "Vezzoli 2014, section 4",
        },
    }


def _trapezium() -> dict[str, Any]:
    return {
        "model": "Trapezium",
        "high": values.VOLTAGE,
        "rise": values.RAMP,
        "hold": 0.1,
        "fall": values.RAMP,
    }


_TRAPEZIUM_SOURCES = {
    "drive.high": "Vezzoli 2014, section 4",
    "drive.rise": "not printed; 36 ms gives the paper's 2.5 mN with 7.7 ms and law (1)",
    "drive.hold": NOT_PRINTED,
    "drive.fall": NOT_PRINTED,
}


def _figure_6() -> dict[str, Any]:
    content = _common("Vezzoli 2014, figure 6: 0 to 1000 V trapezium on a plastic film")
    content |= {"drive": _trapezium(), "force": {"model": "Vezzoli2014Causal"}}
    content["stack"] = {"insulator": _film(), "stratum_corneum": _skin()}
    content["sources"] |= _TRAPEZIUM_SOURCES
    return content


def _figure_6_static() -> dict[str, Any]:
    return _figure_6() | {
        "title": "Vezzoli 2014, figure 6 with the static law (1): no charge is lost",
        "force": {"model": "EffectiveMediumPlane"},
    }


def _figure_6_gap() -> dict[str, Any]:
    content = _figure_6() | {
        "title": "Vezzoli 2014, figure 6 as a stack with a leaky gap, cut in the gap",
        "force": {"model": "GapPlane"},
    }
    gap = {
        "thickness": 1e-6,
        "material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1 / 8.7e8},
    }
    content["stack"] = {"insulator": _film(), "gap": gap, "stratum_corneum": _skin()}
    content["sources"] |= {
        "stack.gap.thickness": "not in the paper; of the order of skin roughness",
        "stack.gap.material.permittivity": "air",
        "stack.gap.material.conductivity": "not in the paper; gives a time constant near 8 ms",
    }
    return content


def _figure_2() -> dict[str, Any]:
    content = _figure_6_gap() | {
        "title": "Vezzoli 2014, figure 2: finger held off the plate, a gap that does not conduct",
        "drive": _trapezium() | {"hold": 1.0},
    }
    content["stack"] = content["stack"] | {"gap": {"thickness": 100e-6}}
    content["motion"] = {"distance": {"model": "HeldOff"}}
    content["load"] = {"normal_force": 0.0}
    content["sources"] |= {
        "stack.gap.thickness": "not printed: the finger was held close to the plate by hand",
        "load.normal_force": "Vezzoli 2014, figure 2: no contact",
    }
    del content["sources"]["stack.gap.material.conductivity"]
    return content


def _figure_2_tremor() -> dict[str, Any]:
    content = _figure_2() | {
        "title": "Vezzoli 2014, figure 2: finger held off the plate by a hand that trembles"
    }
    tremor = {"model": "TremblingDistance", "mean": 100e-6, "amplitude": 10e-6, "frequency": 8.0}
    content["motion"] = {"distance": tremor}
    content["rig"] = {
        "model": "Tribometer",
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
        "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
    }
    chosen = {
        "motion.distance": ("mean", "amplitude", "frequency"),
        "rig.normal": ("natural_frequency", "damping_ratio", "time_constant"),
        "rig.lateral": ("natural_frequency", "damping_ratio"),
    }
    paths = [f"{where}.{name}" for where, names in chosen.items() for name in names]
    content["sources"] |= dict.fromkeys(paths, NOT_PRINTED)
    return content


def _figure_7() -> dict[str, Any]:
    content = _common("Vezzoli 2014, figure 7: mean force over frequency on a thin coat")
    content |= {
        "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 1000.0},
        "force": {"model": "Vezzoli2014PerFrequency"},
        "time": {"initial_state": {"model": "PeriodicState"}},
        "frequency": {"low": 100.0, "high": 1e4, "samples": 81},
    }
    coat = {"model": "Constant", "permittivity": values.COAT_PERMITTIVITY}
    skin = _skin(palmar(exponent=MEN, conductance=20e-6))
    content["stack"] = {
        "insulator": {"thickness": values.COAT_THICKNESS, "material": coat},
        "stratum_corneum": skin,
    }
    assumed = "not printed: only that C_i is comparable with C_s"
    content["sources"] |= {
        "drive.amplitude": NOT_PRINTED,
        "drive.frequency": "one point of the paper's 100 Hz to 10 kHz",
        "stack.insulator.thickness": assumed,
        "stack.insulator.material.permittivity": assumed,
        "stack.stratum_corneum.material.permittivity": "palmar_1995, anchored to the paper's 6.9 nF",
        "stack.stratum_corneum.material.reference_frequency": "palmar_1995, where it is anchored",
        "stack.stratum_corneum.material.exponent": "palmar_1995",
        "stack.stratum_corneum.material.conductivity": "palmar_1995, 20 uS",
    }
    return content


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Give the paper's set-ups.

    Returns
    -------
    dict of str to Scenario
        Every value has its source; what the paper does not print says so.
    """
    contents = {
        "fig2": _figure_2(),
        "fig2_tremor": _figure_2_tremor(),
        "fig6": _figure_6(),
        "fig6_static": _figure_6_static(),
        "fig6_gap": _figure_6_gap(),
        "fig7": _figure_7(),
    }
    return {name: Scenario.model_validate(content) for name, content in contents.items()}
