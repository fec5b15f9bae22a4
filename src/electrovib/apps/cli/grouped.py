"""The commands in groups, an example at the beginning of the help of one, and arguments in another order, named."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from typer.core import TyperCommand, TyperGroup

if TYPE_CHECKING:
    from collections.abc import Iterator

_READABLE: Final = (".toml", ".nc", ".csv", ".mat")
"""Suffixes of files that hold a scenario: tables, and Traces."""
_SCENARIOS: Final = ("scenario", "second")
"""Arguments that are the scenario: the second one of `check`, after a drive."""
_ALSO_TABLES: Final = ("texture", "space")
"""Arguments beside the scenario that may be a TOML file too."""


class Commands(TyperGroup):
    """The program: lists its commands by what they are for."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, a group after the other, in the order in which they were added."""
        found = {name: self.commands[name] for name in self.list_commands(ctx)}
        room = formatter.width - 6 - max(map(len, found))
        groups: dict[str, list[tuple[str, str]]] = {}
        for name, each in found.items():
            row = (name.ljust(max(map(len, found))), each.get_short_help_str(room))
            groups.setdefault(str(getattr(each, "rich_help_panel", None) or "Commands"), []).append(row)
        for title, rows in groups.items():
            with formatter.section(title):
                formatter.write_dl(rows)


class Command(TyperCommand):
    """One command: its help begins with the example that is declared as its epilog."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write the example, then the description."""
        if self.epilog:
            formatter.write_paragraph()
            with formatter.indentation():
                formatter.write(f"{'':{formatter.current_indent}}Example: {self.epilog}\n")
        super().format_help_text(ctx, formatter)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write nothing after the options."""

    def invoke(self, ctx: Any) -> Any:
        """Refuse a scenario in the place of another argument, with the order that was meant."""
        given = list(_positional(self, ctx))
        if swapped := _swapped(given):
            from electrovib.core.errors import InputError

            first, second = swapped
            meant = [{first: second, second: first}.get(value, value) for _, value in given]
            raise InputError(
                f"'{first}' stands where the scenario belongs, which '{second}' seems to be; the order is: electrovib"
                f" {ctx.info_name} {' '.join(meant)}"
            )
        return super().invoke(ctx)


def _positional(command: TyperCommand, ctx: Any) -> Iterator[tuple[str, str]]:
    """Iterate over the arguments without a name that were given: what each is, and its text."""
    for each in command.params:
        if each.param_type_name == "argument" and each.name:
            value = ctx.params.get(each.name)
            yield from (
                (each.name, str(one))
                for one in (value if isinstance(value, (list, tuple)) else [value])
                if one
            )


def _swapped(given: list[tuple[str, str]]) -> tuple[str, str] | None:
    """Return what stands in the place of the scenario, and the TOML file that stands elsewhere; None where all is well."""
    names = [name for name, _ in given]
    place = next((names.index(name) for name in _SCENARIOS if name in names), None)
    if place is None:
        return None
    scenario = given[place][1]
    suffix = Path(scenario).suffix.lower()
    others = [(name, value) for name, value in given if value.lower().endswith(".toml") and value != scenario]
    readable = suffix in _READABLE or (not suffix and "/" in scenario)
    for name, value in others:
        if suffix != ".toml" and not (readable and name in _ALSO_TABLES):
            return scenario, value
    return None
