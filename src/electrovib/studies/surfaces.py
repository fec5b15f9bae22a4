"""Static forces of the published laws on two stacks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from electrovib.core.answer import Table
from electrovib.core.citation import STATUSES
from electrovib.core.parsing import read_toml
from electrovib.core.units import format_quantity
from electrovib.physics.safety import FIELD_EMISSION
from electrovib.scenario import Scenario
from electrovib.studies.compare.laws import air_breaks_down, static_force

AREA: Final = 1e-4
"""Contact area of every cell [m2]."""


@dataclass(frozen=True, kw_only=True)
class PlateStack:
    """A plate and a skin at the full voltage, with the source of their values; `film` and `skin` are thicknesses [m]."""

    name: str
    status: str
    source: str
    voltage: float
    film: float
    film_permittivity: float
    skin: float
    skin_permittivity: float
    gaps: tuple[float, ...]

    def __post_init__(self) -> None:
        assert self.status in STATUSES

    def scenario(self, law: str, *, gap: float = 0.0) -> Scenario:
        """Build the scenario of one cell: no conduction, 1 cm2, a return path without resistance, a step of the voltage."""
        content: dict[str, Any] = {
            "drive": {"model": "Step", "level": self.voltage},
            "force": {"model": law},
            "friction": {"model": "Coulomb", "coefficient": 0.5},
            "contact": {"model": "FixedArea", "area": AREA},
            "load": {"normal_force": 0.5},
            "circuit": {"return_path": {"model": "Grounded", "resistance": 0.0}},
            "stack": {
                "insulator": _layer(self.film, self.film_permittivity),
                **({"gap": {"thickness": gap}} if gap else {}),
                "stratum_corneum": _layer(self.skin, self.skin_permittivity),
            },
        }
        return Scenario.model_validate(content)


def _layer(thickness: float, permittivity: float) -> dict[str, Any]:
    return {"thickness": thickness, "material": {"model": "Constant", "permittivity": permittivity}}


FILM, SCREEN = (
    PlateStack(**each)
    for each in read_toml(Path(__file__).with_name("surfaces.toml").read_text(encoding="utf-8"))["stacks"]
)
FORMS: Final = {
    "EffectiveMedium": "eps0 A V^2/(2 K (T_s + T_i))",
    "MaxwellStressInGap": "eps0 A V^2/(2 (K + g)^2)",
    "MaxwellStressInStratumCorneum": "eps0 eps_s A (V_s/T_s)^2/2",
    "MaxwellStressInInsulator": "eps0 eps_i A (V_i/T_i)^2/2",
}
"""Static force of each law; that of the effective medium is equation (1) of Vezzoli et al. 2014."""
ANSWER: Final = (
    "Believe MaxwellStressInGap: plate and finger separate only in the gap, so the stress there is the force between them;"
    " the other laws divide the same displacement by the permittivity of another medium."
)
"""Which law to believe, and why."""


def compare_surfaces() -> Table:
    """Compute the static force of each law on both stacks.

    Returns
    -------
    Table
        One row for each law and gap, with the force on each stack; K = T_i/eps_i + T_s/eps_s is the electrical thickness.
    """
    rows = []
    for law, formula in FORMS.items():
        rows.append((law, formula, "0", *(_cell(stack, law) for stack in (FILM, SCREEN))))
        if law == "MaxwellStressInGap":
            for gap in sorted({*FILM.gaps, *SCREEN.gaps}):
                cells = (_cell(stack, law, gap) for stack in (FILM, SCREEN))
                rows.append((law, "", format_quantity(gap, "m"), *cells))
    stacks = (f"{stack.name} ({stack.status})" for stack in (FILM, SCREEN))
    caption = (
        "On 1 cm2 without conduction; under a sine, half. Beyond breakdown, which no one would measure: over"
        f" {format_quantity(FIELD_EMISSION, 'V/m')} in air (a value cited from memory, unverified) or, from 5 um on,"
        " Paschen's voltage."
    )
    return Table(
        "Static force by law", ("law", "static force", "gap g", *stacks), tuple(rows), caption=caption
    )


def cell(stack: PlateStack, law: str, *, gap: float = 0.0) -> float:
    """Compute the static force of one cell, at least 0; a gap of 0 is none."""
    return static_force(stack.scenario(law, gap=gap), voltage=stack.voltage)


def _cell(stack: PlateStack, law: str, gap: float = 0.0) -> str:
    shown = format_quantity(cell(stack, law, gap=gap), "N", digits=4)
    scenario = stack.scenario(law, gap=gap)
    is_broken = law == "MaxwellStressInGap" and air_breaks_down(scenario, voltage=stack.voltage)
    return f"{shown} (beyond breakdown)" if is_broken else shown
