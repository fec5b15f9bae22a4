"""Write a scenario, or the result of a design, for another program in the format of the suffix of the file name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.diagnostics import Diagnostic, diagnostics_of, warning_lines
from electrovib.core.errors import InputError
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import check_writable, output_path, write_text
from electrovib.data.marks import Form
from electrovib.exports.spice.netlist import netlist
from electrovib.exports.waveform import check_waveform_file, export_waveform
from electrovib.exports.waveform_formats import FORMATS
from electrovib.physics.limits import broken
from electrovib.scenario import Source, read_scenario
from electrovib.solve.effort import refuse_large
from electrovib.solve.simulate import simulate
from electrovib.studies.design.drive import DesignedDrive
from electrovib.studies.design.result import Designed
from electrovib.studies.texture.drive import TextureDrive
from electrovib.view.files import check_document, save_answer, written

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


WRITERS: Final[dict[str, Callable[..., str]]] = {".cir": netlist}
"""Suffix to writer, which takes the scenario and the `name` of the file."""


def export(
    scenario: Source,
    path: str | Path,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    force: bool = False,
    **options: Any,
) -> Path:
    """Write a scenario as a netlist for a circuit simulator, or its drive as a waveform.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    path : str or Path
        The output: ``.cir``, a netlist that ``ngspice -b`` runs as it is, or a waveform: ``.csv``, ``.npy``, ``.mat``,
        ``.wav`` or ``.pwl``.
    set : mapping of str to value, optional
        Dotted path to value: ``{"drive.high": "150 V"}``.
    force : bool
        Whether a file that was not written by electrovib may be replaced.
    **options
        Of a waveform, as for `electrovib.export_waveform`: ``limits``, ``rate``, ``largest_error`` and others.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written or would replace an input or a file not written by
        electrovib, a part of the scenario has no exact form in a netlist, `simulate` refuses the scenario, or a result
        exceeds one of its declared `limits`.
    NotCausalError
        If the force law has no time-domain form.

    Examples
    --------
    >>> ev.export("vezzoli_2014/fig6", "fig6.cir").read_text().splitlines()[0]
    '* Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse on a plastic film'
    """
    place = output_path(path)
    if options or place.suffix.lower() in FORMATS:
        return export_waveform(scenario, place, set=set, force=force, **options).path
    return export_netlist(scenario, place, changes=set, force=force).path


@dataclass(frozen=True, kw_only=True)
class WrittenNetlist:
    """A netlist that was written, with the diagnostics of its scenario, which the file states too."""

    path: Path
    diagnostics: tuple[Diagnostic, ...]


def export_netlist(
    scenario: Source, place: Path, *, changes: Mapping[str, Any] | None = None, force: bool = False
) -> WrittenNetlist:
    """Write a scenario as a netlist, as `export` does."""
    writer = WRITERS.get(place.suffix.lower())
    if writer is None:
        allowed = ", ".join(WRITERS)
        waves = ", ".join(FORMATS)
        why = f"a scenario is exported as {allowed}, and its drive as {waves}, not as '{place.suffix}'."
        raise InputError(why, path=place)
    with inputs_noted() as inputs:
        found = read_scenario(scenario, changes=changes)
    check_writable({place: Form.NETLIST}, inputs=inputs, force=force)
    refuse_large(found)
    text = writer(found, name=place.stem)
    diagnostics = tuple(diagnostics_of(simulate(found)))
    if problems := [f"{each.text}. Nothing was written" for each in broken(diagnostics)]:
        raise InputError(problems)
    stated = "".join(f"* {line}\n" for line in warning_lines(diagnostics))
    head, newline, rest = text.partition("\n")
    write_text(place, f"{head}{newline}{stated}{rest}", Form.NETLIST, force=force)
    return WrittenNetlist(path=place, diagnostics=diagnostics)


def check_design_file(
    kind: type[Designed],
    path: str | Path,
    *,
    edge: float | str | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check before a computation that its result can be written."""
    place = output_path(path)
    if place.suffix.lower() in FORMATS:
        check_waveform_file(place, edge=edge, inputs=inputs, force=force)
    else:
        waveforms = {f"drive{suffix}": None for suffix in FORMATS if place.suffix}
        check_document(place, {**kind.FILES, **waveforms}, inputs=inputs, force=force)


def write_design(
    found: Designed, path: str | Path, *, edge: float | str | None = None, force: bool = False
) -> list[str]:
    """Write the drive of a design as a waveform, or the design as any other answer."""
    place = output_path(path)
    check_design_file(type(found), place, edge=edge, force=force)
    suffix = place.suffix.lower()
    if suffix not in {".toml", *FORMATS}:
        save_answer(found, place, force=force)
        return [written(place, lambda: found.document)]
    if found.scenario is None:
        raise InputError(
            "there is no result within the limits that could be written; nothing was written. All numbers are written as .json",
            path=place,
        )
    if suffix == ".toml":
        return [f"written: {path}" for path in save_answer(found, place, force=force)]
    rate, notes = (found.rate, found.notes) if isinstance(found, DesignedDrive | TextureDrive) else (None, ())
    waveform = export_waveform(
        found.scenario, place, limits=list(found.limits), force=force, rate=rate, remarks=notes, edge=edge,
    )  # fmt: skip
    return [*(each for each in waveform.document.sentences if each not in notes), f"written: {waveform.path}"]
