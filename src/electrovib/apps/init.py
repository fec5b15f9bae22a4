"""A scenario to start from."""

from __future__ import annotations

from pathlib import Path

from electrovib.core.files import inputs_noted
from electrovib.scenario import DEFAULT, Source, read_scenario

_NAMES = (
    '# A material, or the whole stack, can be the name of what a paper offers: material = "gabriel_1996/wet"'
)


def init(scenario: Source = DEFAULT, *, output: str | Path | None = None, force: bool = False) -> str:
    """Give a scenario as a commented TOML file.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; of a sweep the scenario from which it began.
    output : str or Path, optional
        Where to write it.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    str
        The text.

    Raises
    ------
    InputError
        If there is no such scenario, or if the output cannot be written or would replace a file that is read, that
        we did not write, or that was changed since.
    """
    from electrovib.scenario.toml import left_away, to_toml

    with inputs_noted() as inputs:
        found = read_scenario(scenario, before_sweep=True)
    lines = [f"#   {path}: {what}" for path, what in left_away(found).items()]
    text = to_toml(found) + "".join(
        f"{line}\n"
        for line in [
            "",
            _NAMES,
            "# Parts that can be added; 'electrovib models NAME' tells what each needs:",
            *lines,
        ]
    )
    if output is not None:
        from electrovib.data.atomic import check_writable, write_text
        from electrovib.data.marks import Form, unsigned

        place = Path(output)
        check_writable({place: Form.SCENARIO}, inputs=inputs, force=force)
        write_text(place, f"# {unsigned(Form.SCENARIO)}\n{text}", Form.SCENARIO, force=force)
    return text
