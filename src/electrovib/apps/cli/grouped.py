"""The commands in groups, an example at the beginning of the help of one, and arguments in another order, named."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from typer.core import TyperCommand, TyperGroup

if TYPE_CHECKING:
    from collections.abc import Iterator

_SCENARIOS: Final = ("scenario", "second", "files")
"""Arguments that are or begin with the scenario: the second one of `check`, after a drive; the first one of `fit`."""
_MERGED: Final = {
    "perceive": "run", "equilibrium": "run --states", "sensitivity": "study --sensitivity", "fit-material": "fit",
    "fit-power-law": "fit", "design-plate": "design", "texture": "design --texture", "swipe": "times --swipes",
    "scenarios": "list scenarios", "models": "list", "spaces": "list spaces",
}  # fmt: skip
"""Word that names what a command does, where the command has another name."""
_ALIKE: Final = (
    ("--quantity", "--want", "--exceed", "--signal", "--target", "--maximise", "--minimise"),
    ("--set", "--over", "--free", "--between"),
    ("--material", "--materials"),
    ("--output", "--csv"),
    ("--workers", "--scheduler"),
    ("--column", "--x", "--y"),
    ("--gain-error", "--systematic"),
    ("--layer", "--into"),
    (
        "--set",
        "--step",
        "--stamps",
        "--offset",
        "--shift",
        "--baseline",
        "--trigger",
        "--detrend",
        "--crop",
        "--average",
    ),
    ("--set", "--resample", "--with", "--clock-shift", "--calibration", "--conductivity"),
)
"""Options, or words that one may try, for the same in different commands."""


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

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find a command; of a word that is none name the command that is meant."""
        from electrovib.core.errors import InputError, nearest

        word, path = args[0], "electrovib" if ctx.parent is None else f"electrovib {ctx.info_name}"
        if word in self.commands or word.startswith("-"):
            return super().resolve_command(ctx, args)
        if word in _MERGED:
            raise InputError(f"'{word}' is no command; this is done by '{path} {_MERGED[word]}'")
        raise InputError(f"'{word}' is no command.{nearest(word, self.commands)} '{path} -h' lists them.")


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

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; an option of another command is answered with the command that has it."""
        try:
            order = self.make_parser(ctx).parse_args(args=list(args))[2]
            twice = [each for each in order if order.count(each) > 1 and _is_single(each)]
            if not twice:
                return super().parse_args(ctx, args)
        except Exception as wrong:
            if type(wrong).__name__ != "NoSuchOption":  # of click, or of the copy of it within typer
                raise
            from electrovib.core.errors import InputError

            name = getattr(wrong, "option_name", "")
            raise InputError(_option_meant(name, self, ctx)) from None
        from electrovib.core.errors import InputError

        raise InputError(
            f"{each.opts[0]}: given {order.count(each)} times; give it once" for each in dict.fromkeys(twice)
        )

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


def _is_single(parameter: Any) -> bool:
    """Return whether a parameter is an option with one value."""
    return parameter.param_type_name == "option" and not (parameter.multiple or parameter.is_flag)


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
    if place is None or Path(given[place][1]).suffix.lower() == ".toml":
        return None
    others = [value for name, value in given if value.lower().endswith(".toml") and name != "others"]
    return (given[place][1], others[0]) if others else None


def _option_meant(wrong: str, command: TyperCommand, ctx: Any) -> str:
    """Say which commands have an option, and which one of this command is for the same."""
    from electrovib.core.errors import nearest

    own = _options(command)
    alike = [name for names in _ALIKE if wrong in names for name in names if name in own]
    owners = [name for name, each in _every(ctx.find_root().command) if wrong in _options(each)]
    if wrong in _options(ctx.find_root().command):
        said = f"'{wrong}' stands before the command: electrovib {wrong} ... {ctx.info_name}"
    elif owners:
        said = f"'{wrong}' belongs to {', '.join(repr(name) for name in owners)}"
    else:
        said = f"no command has an option '{wrong}'"
    if alike:
        return f"{said}; '{ctx.info_name}' takes '{alike[0]}'"
    return f"{said}; '{ctx.info_name}' has no such option.{nearest(wrong, own)}"


def _options(command: TyperCommand) -> list[str]:
    return [name for each in command.params if each.param_type_name == "option" for name in each.opts]


def _every(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over all commands, those of a group after its name."""
    for name, each in group.commands.items():
        yield from _every(each, f"{name} ") if hasattr(each, "commands") else [(f"{before}{name}", each)]
