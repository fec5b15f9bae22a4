"""One call to write a scenario for another program, in the format that the file name says."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.marks import Form
from electrovib.export.spice.netlist import netlist
from electrovib.physics.limits import broken
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.effort import refuse_large
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    from collections.abc import Callable

WRITERS: Final[dict[str, Callable[..., str]]] = {".cir": netlist}
"""Suffix to writer: takes the scenario, and as `name` what the file is called."""


def export(
    scenario: Source,
    path: str | Path,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    force: bool = False,
) -> Path:
    """Write a scenario for another circuit simulator.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    path : str or Path
        The output: ``.cir``, a netlist that ``ngspice -b`` runs as it is.
    set : mapping of str to value, optional
        Dotted path to value: ``{"drive.high": "150 V"}``.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written or would replace one that is read or not ours,
        something of the scenario has no exact form there, `simulate` refuses the scenario, or it exceeds one of its
        declared `limits`.
    NotCausalError
        If the force law has no form in time.
    """
    place = Path(path)
    writer = WRITERS.get(place.suffix.lower())
    if writer is None:
        allowed = ", ".join(WRITERS)
        raise InputError(f"a scenario is exported as {allowed}, not as '{place.suffix}'.", path=place)
    with inputs_noted() as inputs:
        found = read_scenario(scenario, changes=set)
    check_writable({place: Form.NETLIST}, inputs=inputs, force=force)
    refuse_large(found)
    text = writer(found, name=place.stem)
    _refuse_what_breaks_a_limit(found)
    write_text(place, text, Form.NETLIST, force=force)
    return place


def _refuse_what_breaks_a_limit(scenario: Scenario) -> None:
    """Run the scenario, which refuses what cannot be run, and refuse what exceeds a declared limit."""
    diagnostics = read_diagnostics(simulate(scenario).attrs["validity"])
    if problems := [f"{diagnostic.text}. Nothing was written" for diagnostic in broken(diagnostics)]:
        raise InputError(problems)
