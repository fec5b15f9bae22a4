"""A scenario to start from."""

from __future__ import annotations

from pathlib import Path

from electrovib.solve.scenario import DEFAULT, load_scenario


def init(scenario: str | Path = DEFAULT, *, output: str | Path | None = None) -> str:
    """Give a scenario as a commented TOML file.

    Parameters
    ----------
    scenario : str or Path
        A paper's scenario, a TOML file, or a Trace file.
    output : str or Path, optional
        Where to write it.

    Returns
    -------
    str
        The text.

    Raises
    ------
    InputError
        If there is no such scenario.
    ElectrovibError
        If the output exists already or cannot be written.
    """
    from electrovib.solve.toml import left_away, to_toml

    found = load_scenario(scenario)
    lines = [f"#   {path}: {what}" for path, what in left_away(found).items()]
    text = to_toml(found) + "".join(
        f"{line}\n"
        for line in ["", "# Parts that can be added; 'electrovib models NAME' tells what each needs:", *lines]
    )
    if output is not None:
        from electrovib.core.errors import ElectrovibError
        from electrovib.data.atomic import write_text

        if Path(output).exists():
            raise ElectrovibError(f"{output} exists already: give another name, or remove it first")
        write_text(Path(output), text)
    return text
