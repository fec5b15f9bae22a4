"""``electrovib equilibrium``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.solve.equilibrium import Balance, Equilibrium


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("equilibrium")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario, with contact.surface and a layer 'gap'.")
    ],
    changes: Changes = None,
    voltage: Annotated[
        str | None,
        typer.Option(help="Constant voltage, such as '100 V'; by default the largest of the drive."),
    ] = None,
    models: Models = None,
) -> None:
    """Find every state of gap and attraction, stable or not.

    The voltage is held constant: the largest of the drive, or that of --voltage.
    """
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.chosen import chosen
    from electrovib.apps.progress import tracked
    from electrovib.core.units import parse_quantity
    from electrovib.scenario import read_scenario
    from electrovib.solve.equilibrium import equilibrium

    found = read_scenario(scenario, changes=read_changes(changes or []))
    held = None
    if voltage is not None:
        try:
            held = parse_quantity(voltage, "V")
        except ValueError as error:
            raise InputError(f"--voltage {voltage}: {error}") from None
    with tracked("finding equilibria"):
        balance = equilibrium(found, voltage=held)
    say(*summary(balance), *chosen(found, scenario))


def summary(found: Balance) -> list[str]:
    """Describe the states in a few lines."""
    from electrovib.core.diagnostics import warning_lines
    from electrovib.core.units import format_quantity

    def shown(value: float, unit: str) -> str:
        return format_quantity(value, unit, digits=4)

    lines = [
        f"{shown(found.voltage, 'V')} held across {', '.join(found.blocking)} and the gap: electrical thickness"
        f" {shown(found.electrical_thickness, 'm')}, load {shown(found.pressure, 'Pa')} on {shown(found.area, 'm2')}"
    ]
    for state, force, area in zip(found.states, found.force, found.areas, strict=True):
        grown = f" on {shown(area, 'm2')}" if area != found.area else ""
        lines.append(
            f"gap {shown(state.gap, 'm')}: attraction {shown(force, 'N')}{grown}, {_kind(state)}"
            f" (residual {state.residual:.1e} Pa)"
        )
    if len(found.stable) > 1:
        lines.append(
            "two stable states: which of them is reached depends on the previous gap, so the force has a hysteresis"
        )
    if found.beyond:
        lines.append(
            "a flatter state, with more than half of the area in contact, is not described by this surface topography"
        )
    return lines + warning_lines(found.diagnostics)


def _kind(state: Equilibrium) -> str:
    words = "stable" if state.stable else "a fold, where a branch ends" if state.fold else "unstable"
    return f"{words}, pressed on the plate" if state.touching else words
