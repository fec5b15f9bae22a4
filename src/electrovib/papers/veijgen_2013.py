"""N. K. Veijgen, M. A. Masen, E. van der Heide: friction of skin at four body sites, Tribology Letters 49, 251, 2013.

doi:10.1007/s11249-012-0062-1. Coefficients that other laboratories measured on skin without electrovibration are declared here
too, each with its own group.

Claims: median coefficients of 0.52 at rest and 0.36 in motion over 450 tests on steel, aluminium, polyethylene and PTFE;
hydration explains most of the spread. Does not claim: one coefficient for a material, or for a fingertip: fingertips are at 0.43
on polyamide and at 2.79 on rosin-coated glass (Smith and Scott), above what the tables of body sites give.
"""

from __future__ import annotations

from typing import Any

from electrovib.core.citation import Check
from electrovib.papers import cited_as, shultz_2018
from electrovib.scenario import Scenario
from electrovib.studies.evidence import Measurement, between
from electrovib.studies.evidence.quantities import coefficient, load_exponent

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"

AT_REST, IN_MOTION = 0.52, 0.36
"""Median coefficients of friction over 450 tests."""

_SPAN = between(
    0.1,
    1.3,
    "",
    source="Wolfram 1989, review of skin friction, quoted by a public code file",
    status="second-hand",
)
LAWS: dict[str, dict[str, Any]] = {
    "Coulomb": {"friction.coefficient": _SPAN},
    "PowerLaw": {
        "friction.coefficient": _SPAN,
        "friction.at_force": between(0.9, 1.1, "1 N, about the loads of the review"),
        "friction.exponent": between(-0.4, -0.05, "about -0.2, of aluminium", model="Uniform"),
    },
    "AdhesiveShear": {
        "friction.shear_strength": between(
            1.5e6, 1.5e7, "15 MPa fits the friction of a wrist (Persson 2013), or less"
        ),
        "contact.surface.modulus": between(1e6, 1e8, "1 to 2 MPa across the skin when wet, more when dry"),
        "contact.surface.rms_slope": between(0.3, 1.5, "of the order of 1", model="Uniform"),
    },
}
"""What the laws of friction take for skin, from other sources than the measurements below."""


def bare(load: float = 1.0) -> Scenario:
    """Return a finger that slides without a drive, with a rough surface for the laws that need one."""
    rough = {
        "model": "PerssonSurface", "modulus": 1e7, "rms_slope": 1.0, "rms_gap": 2e-5, "pressure_factor": 1.0,
        "decay_factor": 0.5,
    }  # fmt: skip
    return shultz_2018.scenarios()["sliding"].replace({"contact.surface": rough, "load.normal_force": load})


def friction(
    group: str,
    source: str,
    title: str,
    value: float,
    spread: tuple[float, str],
    *,
    how: str = "printed",
    load: float | None = None,
    **more: Any,
) -> Measurement:
    """Return a measurement of friction without a drive; a load that is not printed is drawn."""
    width, of = spread
    pressed = (0.2, 3.0, "not printed") if load is None else (0.99 * load, 1.01 * load, "the printed weight")
    read = {"status": "second-hand" if how == "quoted by others" else "abstract"} | more
    return Measurement(
        title=title, source=source, scenario=bare(load or 1.0), quantity=read.pop("quantity", coefficient), unit="1",
        values=(value,), spread=(width,), spread_of=of, group=group, how=how, judges="friction",
        unknown={"load.normal_force": between(*pressed)}, of_model=LAWS, **read,
    )  # fmt: skip


_SMITH = ("Smith and Scott", "Smith and Scott, subjective scaling of smooth surface friction, abstract")
_ZHANG = ("Zhang and Mak", "Zhang and Mak 1999, quoted by a public code file")
_DZIDEK = ("Dzidek, Adams and Hayward (Birmingham)", "Dzidek 2014, LNCS 8618, 109, abstract")
_QUOTED: dict[str, Any] = {"how": "quoted by others", "load": 0.981}


def measurements() -> dict[str, Measurement]:
    """Return coefficients of friction of fingertips and skin, and how the friction grows with the load."""
    own = ("Veijgen, Masen and van der Heide", "Veijgen 2013, abstract")
    people, digits = "people", "digits"
    sites = "Body sites, not fingertips; four materials and 450 tests pooled."
    stroked = "Means of ten people with washed and dried index fingers, at their own force and speed; no spread is printed."
    occluded = "After some 50 s on the surface; a finger that slides as in use has no time for it."
    return {
        "polyamide": friction(*_SMITH, "fingertip on polyamide", 0.43, (0.3, "a choice"), note=stroked),
        "rosin": friction(*_SMITH, "fingertip on rosin-coated glass", 2.79, (0.3, "a choice"), note=stroked),
        "at_rest": friction(*own, "skin at rest, median", AT_REST, (0.3, "a choice"), on="skin", note=sites),
        "in_motion": friction(*own, "skin in motion, median", IN_MOTION, (0.3, "a choice"), on="skin", note=sites),
        "all_sites": friction(
            *_ZHANG, "skin, six sites and five materials", 0.46, (0.33, people), on="skin", **_QUOTED
        ),
        "palm": friction(*_ZHANG, "palm, five materials", 0.62, (0.35, people), on="skin", **_QUOTED),
        "silicone": friction(*_ZHANG, "skin on silicone", 0.61, (0.33, "a choice"), on="skin", **_QUOTED),
        "nylon": friction(*_ZHANG, "skin on nylon", 0.37, (0.33, "a choice"), on="skin", **_QUOTED),
        "aluminium": friction(
            "Taylor and Lederman", "Taylor and Lederman 1975, quoted by a public code file", "fingertip on aluminium", 0.6,
            (0.08, digits), how="quoted by others", note="At least 75 % lower with soap, which no law here describes.",
        ),
        "exponent_smooth": friction(
            *_DZIDEK, "power of the load, smooth glass", 5 / 6, (0.12, "a choice"), quantity=load_exponent,
            note=f"Printed is 2/3 to 1: its middle, and the deviation of this range. {occluded}",
        ),
        "exponent_rough": friction(
            *_DZIDEK, "power of the load, rough surface", 1.0, (0.05, "a choice"), quantity=load_exponent, note=occluded
        ),
    }  # fmt: skip


CHECKS = (
    Check(
        "coefficient in motion over that at rest",
        expect=0.69,
        rtol=1e-2,
        source="abstract, two medians of two digits",
        compute=lambda: IN_MOTION / AT_REST,
        status="derived",
    ),
)
