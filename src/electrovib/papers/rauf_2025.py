"""A. M. Rauf, S. Follmer, "Modeling the dynamics of sub-millisecond electroadhesive engagement and release", 2025.

Extreme Mechanics Letters 79, 102382: a clutch of interdigitated electrodes on a metal, not a finger.

Claims: engagement and release as squeeze film, contact mechanics, polarisation of the dielectric and rise and
fall of the drive together; in earlier clutches both are far slower than electrostatics alone predicts, and
higher drive frequencies, narrower substrates and faster drives shorten the release; engagement below 15 us, release
below 875 us. The pull takes the air gap into account and agrees with field calculations from 10 nm to 10 um.
Does not claim: fringe fields of the electrodes, anything on skin. An exponent of the voltage is not taken from the measured
means: these belong to sessions with other loads, and it is 2 to 3 by the load. The
clutches and pads of others that the authors' script quotes are declared here too.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from electrovib.core.citation import Check, derived
from electrovib.core.constants import eps0
from electrovib.papers import cited_as, defects, grigorii_2020, not_read, preset_notes, shultz_2018, tables
from electrovib.papers.vezzoli_2014.measured import ROUGH_GAP
from electrovib.physics.material import ColeCole, Material
from electrovib.scenario import Scenario, preset, sourced
from electrovib.studies.evidence import Measurement, between

CITATIONS, CITATION = cited_as(__name__)
STATUS = "in part"
PRESETS = preset_notes(__name__)
NOT_READ = not_read(__name__)
DEFECTS = defects(__name__)

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
        status="in part",
    )


def stack_over_formula() -> float:
    """Return the force of the stack with two contacts over that of the formula, at 1 um and permittivity 50."""
    from electrovib.solve.simulate import simulate

    trace = simulate(scenarios()["field_50"], time=np.array([0.0, 1e-3]))
    return float(trace.electrostatic_force[-1]) / clutch_force(voltage=VOLTAGE, gap=1e-6, permittivity=HIGH)


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
_CLOSED = (
    "Likely cause: one gap stands for rough film and pin. Averaged over the heights, 2.8 um as the authors fit them to the"
    " capacitance, the stress comes to some fifth of the force, and not to a twentieth. One gap of 0.78 to 0.98 um gives the"
    " force, and one of 2.03 to 2.45 um if the whole voltage lies between each electrode and the pin. The capacitance while the"
    " drive is on, and the voltage of each electrode, would decide the rest."
)


def clutch() -> Scenario:
    """Return the clutch of the force measurements: a pin 2 mm wide on 28 electrodes, a square drive of both polarities.

    The load is left out, because the friction before the drive is switched on is subtracted. The voltage is taken as that
    between the electrodes, as in the field calculations; the data say two electrodes in antiphase, and not of which voltage.
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


def capacitance(scenario: Scenario) -> float:
    """Compute the capacitance [F] between the electrodes of both polarities, with the gap that the surface has under the load.

    `contact.area` is that of all electrodes; half of it is in series with the other half.
    """
    layer, area = scenario.stack.layers["insulator"], scenario.contact_area
    frequency = scenario.drive.frequency  # type: ignore[attr-defined]
    permittivity = float(layer.material.complex_permittivity(frequency).real)
    surface = scenario.contact.surface
    gap = float(surface.gap(np.asarray(scenario.load.normal_force / area)))  # type: ignore[union-attr]
    return eps0 * area / (layer.thickness / permittivity + gap) / 4


def electric_part(scenario: Scenario) -> float:
    """Compute the friction [N] that the attraction adds in the state of the largest stable gap."""
    from electrovib.solve.equilibrium.of_scenario import equilibrium

    balance = equilibrium(scenario)
    stable = [force for state, force in zip(balance.states, balance.force, strict=True) if state.stable]
    return float(scenario.friction.coefficient * stable[-1])  # type: ignore[attr-defined]


def grounded(width: float) -> Scenario:
    """Return the clutch as one contact with all electrodes and half of the voltage, which attracts as two in series do."""
    plate = {
        "circuit.return_path": {"model": "Grounded", "resistance": 0.0},
        "contact.area": _ELECTRODES * WIDTH * width,
    }
    return clutch().replace({**plate, "title": "Rauf 2025, clutch as one contact", "frequency.low": 1e3})


def over_load(shared: dict[str, Any]) -> dict[str, Measurement]:
    """Return the electric part of the force and the capacitance over the load, which judge the surface topography."""
    found, data = {}, tables("rauf_2025")
    rough: dict[str, Any] = {
        "over": "load.normal_force", "judges": "contact.surface", "of_model": data["of_model"], "on": "metal pin",
        "group": shared["group"], "how": "data file", "status": "in part", "spread_of": "repeats",
    }  # fmt: skip
    surface = {"contact.surface": {"model": "LinearSpring", "stiffness": 1e10, "free_gap": 1e-5}}
    loads = tuple(data["load"]["at"])
    for level, (start, start_error, slope, slope_error) in data["load"]["lines"].items():
        values = tuple(start + slope * load for load in loads)
        found[f"load_{level}V"] = Measurement(
            title=f"electric part of the shear force over load, {level} V",
            source="Rauf 2025, authors' data of figure 8d",
            scenario=grounded(DEPTH).replace(
                {"drive": {"model": "Step", "level": float(level) / 2}, **surface}
            ),
            quantity=electric_part,
            unit="N",
            at=loads,
            values=values,
            spread=tuple(
                math.hypot(start_error, slope_error * load) / value
                for load, value in zip(loads, values, strict=True)
            ),
            unknown={"friction.coefficient": data["unknown"]["friction.coefficient"]},
            note="Four points on the straight line through 25 to 33 runs, and its standard errors. The load comes from the same"
            " load cell; up to 0.14 of the slope could be friction at rest in the maximum.",
            **rough,
        )
    for each in data["capacitances"]:
        width, runs = each["width"], each["runs"]
        means = np.mean(runs, axis=0)
        found[f"capacitance_{width * 1e3:g}mm"] = Measurement(
            title=f"capacitance over load without a high voltage, pin {width * 1e3:g} mm wide",
            source="Rauf 2025, authors' data of figure 6",
            scenario=grounded(width).replace(
                {"drive": {"model": "Sine", "amplitude": 1.0, "frequency": 1e3}, **surface}
            ),
            quantity=capacitance,
            unit="F",
            at=tuple(each["at"]),
            values=tuple((means * 1e-12).tolist()),
            spread=tuple(np.maximum(np.std(runs, axis=0, ddof=1) / means, 0.02).tolist()),
            unknown={"drive.frequency": between(1e3, 1e5, "frequency of the meter, not stated")},
            note=f"Mean of {len(runs)} runs and their deviation, at least 2 %; loads interpolated between the stored ones."
            " Wide bars sit on dirt or bow at low loads.",
            **rough,
        )
    return found


def pad(group: str, area: float | None, values: dict[float, float], note: str, **more: Any) -> Measurement:
    """Return the shear force [N] of a pad over voltage, or its stress [Pa] where the area [cm2] is not given."""
    half = (area or 1.0) * 1e-4 / 2
    several: dict[str, Any] = {"over": "drive.level", "at": tuple(values)} if len(values) > 1 else {}
    film = {"thickness": 2e-5, "material": {"model": "Constant", "permittivity": 10.0}}
    scenario = clutch().replace(
        {
            "title": f"pad of {group}", "drive": {"model": "Step", "level": next(iter(values))}, "time": {"duration": 1e-3},
            "contact.area": half, "circuit.return_path.area": half, "stack.insulator": film, "stack.gap.thickness": 1e-6,
        }
    )  # fmt: skip
    known: dict[str, Any] = {
        "title": f"shear {'force' if area else 'stress'} of a pad, {', '.join(f'{each:g} V' for each in values)}",
        "source": f"{group}, quoted by Rauf 2025, authors' script of figure 1", "quantity": "mean lateral_force",
        "unit": "N" if area else "Pa", "scale": 1.0 if area else 1e4, "how": "quoted by others", "status": "second-hand",
        "spread": (0.1,) * len(values), "spread_of": "a choice", "on": "pad",
        "unknown": tables("rauf_2025")["of_pad"],
    }  # fmt: skip
    numbers: dict[str, Any] = {
        "scenario": scenario, "group": group, "values": tuple(values.values()), "note": note,
    }  # fmt: skip
    return Measurement(**numbers | several | known | more)


def pads() -> dict[str, Measurement]:
    """Return the shear forces and stresses of other clutches and pads, and two contacts of the size of a finger."""
    read = "Read off figures by those who quote it, without film, gap and friction. "
    data, found = tables("rauf_2025"), {}
    for each in data["pads"]:
        values = dict(zip(each["at"], each["values"], strict=True))
        found[each["name"]] = pad(each["group"], each["area"], values, read + each["note"])
    apart = f"{read}Its values at other voltages do not grow with it as a square, so they are probably other pads: scored apart."
    for each in data["apart"]:
        for at, value in zip(each["at"], each["values"], strict=True):
            found[f"{each['name']}_{at:.0f}V"] = pad(each["group"], each.get("area"), {at: value}, apart)
    for cause in data["causes"]:
        found |= {name: replace(found[name], cause=cause["text"]) for name in cause["of"]}
    for each in data["several"]:
        several = each["values"]
        logs = np.log(several)
        middle, wide = float(np.exp(logs.mean())), float(np.sqrt(np.expm1(np.var(logs, ddof=1))))
        said = (
            f"{read}Geometric mean and deviation of {len(several)} stresses on as many substrates, probably."
        )
        found[each["name"]] = pad(
            each["group"], None, {each["at"]: middle}, said, spread=(wide,), spread_of="devices"
        )
    finger = shultz_2018.scenarios()["sliding"].replace({"drive.amplitude": 250.0, "load.normal_force": 0.0})
    for name, force in (("low", 0.0807), ("high", 0.933)):
        found[f"shultz_{name}"] = pad(
            grigorii_2020.GROUP, 1.0, {250.0: force}, "Two values of one work that differ 12 times, conditions not given.",
            title=f"shear force of 1 cm2 at 250 V peak, the {name}er of two",
            source="Shultz 2023, quoted by Rauf 2025, authors' script of figure 1",
            scenario=finger, on="area of a finger", unknown=grigorii_2020.DISPLAY, of_model=ROUGH_GAP,
        )  # fmt: skip
    printed: dict[str, Any] = {"how": "printed", "status": "abstract"}
    found["hundred_pads"] = pad(
        "Sci. Rep. 13 (2023)", None, {400.0: 10e3},
        "Printed are 1 to 100 kPa: the geometric mean, and the deviation of this range. It is up to ten times the pressure before"
        " contact.",
        title="pull-off pressure of over 100 pads at 400 V, conductive objects",
        source="doi:10.1038/s41598-023-38872-6, abstract", quantity="mean electrostatic_force", spread=(1.6,),
        spread_of="devices", **printed,
    )  # fmt: skip
    found["capstan"] = pad(
        "Amish 2024", None, {500.0: 31e4},
        "A capstan, which multiplies friction; the polymer conducts, and its thickness is not printed.",
        title="shear stress of a Johnsen-Rahbek clutch at 500 V", source="doi:10.1109/ICRA57147.2024.10611283, summary",
        cause="Likely cause: the wrap multiplies the friction, and a conducting polymer leaves a gap of nanometres. The torque"
        " with the drive off and on, and the angle of the wrap, would decide.", **printed,
    )  # fmt: skip
    return found


def _relative(table: dict[str, Any]) -> tuple[float, ...]:
    """Return the deviations of a table over its forces."""
    return tuple(each / value for each, value in zip(table["deviation"], table["force"], strict=True))


def measurements() -> dict[str, Measurement]:
    """Return the shear force over voltage, frequency, width and load, the capacitance over load, and the pads of others."""
    data = tables("rauf_2025")
    voltage, frequency, width = data["voltage"], data["frequency"], data["width"]
    shared: dict[str, Any] = {
        "quantity": "mean lateral_force", "unit": "N", "spread_of": "repeats", "group": "Rauf and Follmer", "on": "metal pin",
        "how": "data file", "status": "in part",
        "unknown": data["unknown"], "cause": _CLOSED,
    }  # fmt: skip
    found = {
        "voltage": Measurement(
            title="electric part of the shear force over voltage, 1 kHz",
            source="Rauf 2025, authors' data of figures 8a and 9a",
            scenario=clutch(),
            over="drive.amplitude",
            at=tuple(voltage["at"]),
            values=tuple(voltage["force"]),
            spread=_relative(voltage),
            note="Preload 0.08 to 0.18 N; at 300 V the electric part grows by 0.58 N per newton of preload.",
            **shared,
        )
    }
    for level, forces in frequency["force"].items():
        found[f"frequency_{level}V"] = Measurement(
            title=f"largest shear force over frequency, {level} V",
            source="Rauf 2025, authors' data of figure 7a",
            scenario=clutch().replace({"drive.amplitude": float(level)}),
            over="drive.frequency",
            at=tuple(frequency["at"]),
            values=tuple(forces),
            spread=(frequency["spread"],) * len(forces),
            note="The preload differs between the cells, 0.04 to 0.26 N; its part in the force is not subtracted.",
            **shared,
        )
    found["width"] = Measurement(
        title="largest shear force over the width of the pin, as the area of all electrodes",
        source="Rauf 2025, authors' data of figure 8b",
        scenario=grounded(DEPTH).replace({"drive.amplitude": VOLTAGE / 2}),
        over="contact.area",
        at=tuple(_ELECTRODES * WIDTH * each for each in width["at"]),
        values=tuple(width["force"]),
        spread=tuple(each or frequency["spread"] for each in _relative(width)),
        note="Single runs at 2.5 and 4 mm, with the spread of five runs elsewhere. Friction before the drive is included.",
        **shared | {"unknown": {**data["unknown"], **width["unknown"]}},
    )
    return {**found, **over_load(shared), **pads()}
