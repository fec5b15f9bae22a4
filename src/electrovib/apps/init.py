"""A commented scenario file to start from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from electrovib.core.errors import InputError
from electrovib.core.files import inputs_noted
from electrovib.scenario import DEFAULT, Source, read_scenario

_NAMES = '# A material, or the whole stack, can be named: material = "silica" of the library, "gabriel_1996/wet" of a paper'


def init(
    scenario: Source = DEFAULT,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    output: str | Path | None = None,
    force: bool = False,
) -> str:
    """Return a scenario as a commented TOML file.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; of a sweep the scenario from which it began.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    output : str or Path, optional
        The file to write; no file if absent.
    force : bool
        Whether a file that electrovib did not write may be replaced.

    Returns
    -------
    text : str
        TOML, which reads back as the same scenario.

    Raises
    ------
    InputError
        If there is no such scenario, or if the output cannot be written or would replace a file that is read, that
        electrovib did not write, or that was changed since.
    """
    from electrovib.scenario.toml import left_away

    with inputs_noted() as inputs:
        found = read_scenario(scenario, changes=set, before_sweep=True)
    lines = [f"#   {path}: {what}" for path, what in left_away(found).items()]
    added = "# Parts that can be added; 'electrovib list NAME' lists what each needs:"
    text = "\n".join([found.to_toml(), _NAMES, added, *lines, ""])
    if output is not None:
        from electrovib.data.atomic import Form, check_writable, output_path, unsigned, write_text

        place = output_path(output)
        if place.suffix.lower() != ".toml":
            raise InputError(
                f"a scenario is written as .toml, such as '{place.with_suffix('.toml')}'", path=place
            )
        check_writable({place: Form.SCENARIO}, inputs=inputs, force=force)
        write_text(place, f"# {unsigned(Form.SCENARIO)}\n{text}", Form.SCENARIO, force=force)
    return text
