"""A. M. Rauf, S. Follmer, "Modeling the dynamics of sub-millisecond electroadhesive engagement and release", 2025.

Extreme Mechanics Letters 79, 102382: a clutch of interdigitated electrodes on a metal, not a finger.

Claims: engagement and release as squeeze film, contact mechanics, polarisation of the dielectric and rise and
fall of the drive together; in earlier clutches both are far slower than electrostatics alone predicts, and
higher drive frequencies, narrower substrates and faster drives shorten the release; engagement below 15 us, release
below 875 us. The pull takes the air gap into account and agrees with field calculations from 10 nm to 10 um.
Does not claim: fringe fields of the electrodes, anything on skin. The dependence of the shear load on the voltage is not
taken from the measured means: these belong to different sessions, between which the load at one voltage differs threefold.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from electrovib.core.citation import Check, Citation, cited, derived
from electrovib.core.constants import eps0
from electrovib.physics.material import ColeCole, Material
from electrovib.scenario import Scenario, preset, sourced
from electrovib.scenario.sources import PresetNote
from electrovib.solve.simulate import simulate
from electrovib.studies.evidence import Measurement

CITATIONS = (
    Citation(
        kind="article",
        authors=("A. M. Rauf", "S. Follmer"),
        title="Modeling the dynamics of sub-millisecond electroadhesive engagement and release times",
        journal="Extreme Mech. Lett.",
        year=2025,
        volume="79",
        pages="102382",
        doi="10.1016/j.eml.2025.102382",
        eprint="2412.16803",
        read="abstract and public code",
    ),
)
CITATION = cited(CITATIONS)
STATUS = "abstract"
PRESETS = {
    "field_50": PresetNote(
        "figure 2b", "electroadhesive clutch, interdigitated electrodes, high permittivity; not a finger"
    ),
    "field_3": PresetNote("figure 2b", "electroadhesive clutch, interdigitated electrodes; not a finger"),
    "relaxor": PresetNote(
        "figure 3, the film alone",
        "electroadhesive clutch, relaxor ferroelectric, slow polarisation; not a finger",
    ),
}
NOT_READ = (
    "the text: equation (4), its field calculations and the fit of the film are from the authors' public code; contact"
    " mechanics, squeeze film and the unit of the measured shear loads are not used"
)
DEFECTS = (
    "Rauf 2025 against stresses taken inside a dielectric: as the gap closes to 10 nm, its field calculations come to 48.0"
    " and 3.00 times eps0 k V^2 A/(8 d^2) for permittivities k of 50 and 3. The force is that of the field in the gap.",
)

THICKNESS, VOLTAGE = 24e-6, 300.0
FINGERS, WIDTH, DEPTH = 4, 1.5e-3, 2e-3
AREA = FINGERS * WIDTH * DEPTH
"""Area of all electrode fingers, half of them of each polarity [m2]."""
HIGH, LOW = 50.0, 3.0
"""Permittivities of the dielectric in the field calculations."""
FIELD_POINTS = {
    (HIGH, 10e-9): 4.983,
    (HIGH, 1e-6): 0.5516,
    (HIGH, 10e-6): 0.01151,
    (LOW, 10e-9): 0.01870,
    (LOW, 1e-6): 0.01482,
    (LOW, 10e-6): 0.003733,
}
"""Force of the finite-element calculation [N] for each permittivity [1] and air gap [m]."""
WITHIN = {HIGH: 6e-2, LOW: 1.5e-2}
"""Relative deviation allowed for the formula: the calculation includes fringe fields, which grow with the permittivity."""


def clutch_force(
    *, voltage: float, gap: float, permittivity: float, thickness: float = THICKNESS, area: float = AREA
) -> float:
    """Compute the attraction [N] of interdigitated electrodes under a dielectric to a floating metal.

    eps0 k^2 V^2 A/(8 (d + k g)^2): the Maxwell stress in the gap with V/2, half of the voltage between
    neighbouring electrodes across each interface, without fringe fields. A is the area of the electrodes of
    both polarities.
    """
    return eps0 * (permittivity * voltage) ** 2 * area / (8 * (thickness + permittivity * gap) ** 2)


def film() -> ColeCole:
    """Return the relaxor film (PVDF-TrFE-CFE) as fitted in the authors' code, without conduction."""
    return ColeCole.model_validate("p_vdf_trfe_cfe")


def materials() -> dict[str, Material]:
    """Return the film."""
    return {"relaxor": film()}


def _check(permittivity: float, gap: float) -> Check:
    return Check(
        f"finite-element force, permittivity {permittivity:g}, gap {gap * 1e6:g} um",
        expect=FIELD_POINTS[permittivity, gap],
        rtol=WITHIN[permittivity],
        source="points of figure 2b in the authors' public code",
        compute=functools.partial(clutch_force, voltage=VOLTAGE, gap=gap, permittivity=permittivity),
        status="abstract",
    )


def stack_over_formula() -> float:
    """Return the force of the stack with two contacts over that of the formula, at 1 um and permittivity 50."""
    trace = simulate(scenarios()["field_50"], time=np.array([0.0, 1e-3]))
    force = float(trace.electrostatic_force[-1])
    return force / clutch_force(voltage=VOLTAGE, gap=1e-6, permittivity=HIGH)


CHECKS = (
    *(_check(*point) for point in FIELD_POINTS),
    derived(
        "stack with two contacts over the formula",
        expect=1.0,
        rtol=1e-9,
        source="identity: the current enters through half of the electrodes and leaves through the other half",
        compute=stack_over_formula,
    ),
)

_CODE = "Rauf 2025, the authors' public code of figure 2b"
_NONE = "not in the field calculation"


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return the clutch with an air gap of 1 um: as in the field calculations, and with the film as fitted."""
    dielectric = {"model": "Constant", "permittivity": HIGH}
    field_50 = preset(
        title="Rauf 2025, figure 2b: clutch with a dielectric of permittivity 50",
        unchanged=_CODE,
        changes={
            "drive.level": (VOLTAGE, _CODE),
            "time.duration": 1e-3,
            "friction.coefficient": (0.0, _NONE),
            "contact.area": (AREA / 2, _CODE),
            "load.normal_force": (0.0, _NONE),
            "circuit.return_path": {"model": "SecondElectrode", "area": AREA / 2, "resistance": 0.0},
            "stack": {
                "insulator": {"thickness": THICKNESS, "material": dielectric},
                "gap": {"thickness": 1e-6},
            },
        },
    )
    field_3 = preset(
        field_50,
        title="Rauf 2025, figure 2b: clutch with a dielectric of permittivity 3",
        changes={"stack.insulator.material.permittivity": (LOW, _CODE)},
    )
    edges = {"rise": (1e-5, "a choice"), "hold": (9e-4, "a choice"), "fall": (1e-5, "a choice")}
    relaxor = preset(
        field_50,
        title="Rauf 2025, film with slow polarisation, edges of a choice",
        changes={
            "drive": {"model": "Trapezium", "high": VOLTAGE, **edges},
            "stack.insulator.material": (film(), "Rauf 2025, the authors' public code of figure 3"),
        },
    )
    found = {"field_50": field_50, "field_3": field_3, "relaxor": relaxor}
    return {name: sourced(scenario, {"": _CODE, "time": ""}) for name, scenario in found.items()}


_ELECTRODES = 28
_VOLTAGES = (100.0, 125.0, 150.0, 175.0, 200.0, 225.0, 250.0, 275.0, 300.0)
_ELECTRIC = (0.100, 0.141, 0.166, 0.269, 0.316, 0.481, 0.504, 0.730, 0.838)
_REPEATS = (0.010, 0.007, 0.026, 0.026, 0.067, 0.030, 0.055, 0.046, 0.070)
"""Shear force with the drive on less that before it, and its standard deviation over 4 to 14 runs [N]."""
_STRESS = {
    0.1: (0.228, 0.383, 0.634, 0.768), 1.0: (0.263, 0.485, 0.812, 0.787), 10.0: (0.214, 0.517, 0.535, 0.789),
    100.0: (0.218, 0.444, 0.559, 0.694), 2e3: (0.200, 0.380, 0.483, 0.647), 5e3: (0.172, 0.345, 0.446, 0.549),
    1e4: (0.141, 0.274, 0.364, 0.437),
}  # fmt: skip
"""Largest shear force at 150, 200, 250 and 300 V over the frequency of the drive [N]; 1 kHz pools other loads and is left out."""
_SPREAD = 0.14
"""Typical standard deviation over the mean of five runs."""
_GAP = {
    "model": "LogUniform",
    "low": 3.9e-6,
    "high": 8.4e-6,
    "source": "gap from the capacitance without a high voltage, three runs from 0.1 to 8 N, authors' data of figure 6",
    "status": "full text",
}
_FRICTION = {
    "model": "Uniform",
    "low": 0.154,
    "high": 0.188,
    "source": "kinetic and static coefficient of the film on brass, authors' script of figure 7",
    "status": "full text",
}


def clutch() -> Scenario:
    """Return the clutch of the force measurements: a pin 2 mm wide on 28 electrodes, a square drive of both polarities.

    The load is left out, because the friction before the drive is switched on is subtracted.
    """
    area = _ELECTRODES * WIDTH * DEPTH / 2
    return scenarios()["relaxor"].replace(
        {
            "title": "Rauf 2025, clutch of figures 7 and 8",
            "drive": {"model": "Square", "amplitude": 150.0, "frequency": 1e3},
            "time": {"initial_state": {"model": "PeriodicState"}},
            "contact.area": area,
            "circuit.return_path.area": area,
            "friction.coefficient": 0.17,
        }
    )


def measurements() -> dict[str, Measurement]:
    """Return the shear force over voltage at 1 kHz and over frequency at four voltages."""
    shared: dict[str, Any] = {
        "quantity": "mean lateral_force", "unit": "N", "spread_of": "repeats", "group": "Rauf and Follmer", "on": "metal pin",
        "how": "data file", "status": "full text",
        "unknown": {"stack.gap.thickness": _GAP, "friction.coefficient": _FRICTION},
    }  # fmt: skip
    found = {
        "voltage": Measurement(
            title="electric part of the shear force over voltage, 1 kHz",
            source="Rauf 2025, authors' data of figures 8a and 9a",
            scenario=clutch(),
            over="drive.amplitude",
            at=_VOLTAGES,
            values=_ELECTRIC,
            spread=tuple(each / value for each, value in zip(_REPEATS, _ELECTRIC, strict=True)),
            note="Preload 0.08 to 0.18 N; at 300 V the electric part grows by 0.58 N per newton of preload.",
            **shared,
        )
    }
    for place, level in enumerate((150.0, 200.0, 250.0, 300.0)):
        found[f"frequency_{level:.0f}V"] = Measurement(
            title=f"largest shear force over frequency, {level:.0f} V",
            source="Rauf 2025, authors' data of figure 7a",
            scenario=clutch().replace({"drive.amplitude": level}),
            over="drive.frequency",
            at=tuple(_STRESS),
            values=tuple(each[place] for each in _STRESS.values()),
            spread=(_SPREAD,) * len(_STRESS),
            note="The preload differs between the cells, 0.04 to 0.26 N; its part in the force is not subtracted.",
            **shared,
        )
    return found
