"""The commands in groups, an example at the beginning of the help of one, and arguments in another order, named."""

from __future__ import annotations

import functools
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from typer.core import TyperCommand, TyperGroup

from electrovib.apps.cli import options
from electrovib.apps.cli.gone import GONE, taken
from electrovib.apps.cli.meant import QUOTED, command_meant, explained, options_of, refuse_other_forms
from electrovib.core.deprecation import former_values
from electrovib.core.errors import InputError

_SCENARIOS: Final = ("scenario", "second")
"""Arguments that are the scenario: the second one of `check`, after a drive."""
_SECTION: Final = re.compile(r"\n\n(\w+)\n-+\n")
_PARAMETER: Final = re.compile(r"^(\w+)(?: : (.*))?\n((?: .*(?:\n|$))+)", re.MULTILINE)
"""A parameter in numpydoc: its name, the word that stands for its value, and what it is."""


@functools.cache
def _described(doc: str) -> dict[str, tuple[str | None, str]]:
    """Return the word for its value, and what it is, of each parameter in a numpydoc."""
    found = _PARAMETER.findall(_sections(doc).get("Parameters", ""))
    return {name: (word or None, " ".join(words.split())) for name, word, words in found}


def _sections(doc: str) -> dict[str, str]:
    """Return the sections of a numpydoc by their titles; what stands before them has none."""
    before, *rest = _SECTION.split(doc)
    return {"": before} | dict(zip(rest[::2], rest[1::2], strict=True))


def _describe(command: Any) -> None:
    """Describe the parameters of a command by its numpydoc, that of its module, or that of `options`."""
    docs = options.__doc__, sys.modules[command.callback.__module__].__doc__, inspect.getdoc(command.callback)
    described = {name: text for doc in docs for name, text in _described(doc or "").items()}
    for each in command.params:
        each.metavar, each.help = described.get(each.name.strip("_"), (each.metavar, each.help))
        each.secondary_opts = []  # a flag is given or not: there is no --no-...


class _Arguments:
    """What reads the arguments of the program and those of each command."""

    def parse_args(self: Any, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; what they do not fit, as an option given twice, is answered with what was meant.

        'help' before a command shows the help, of the command after it if one is given.
        """
        if args[:1] == ["help"] and "help" not in getattr(self, "commands", {"help"}):
            args = [*args[1:2], "--help"]
        gone = GONE.get(ctx.command_path.partition(" ")[2], {})
        if any(word.partition("=")[0] in gone for word in args):
            args, former = taken(gone, args)
            ctx.with_resource(former_values(**former))
        if "--version" in args and "--version" not in options_of(self):
            ctx.find_root().command.main(["--version"], prog_name="electrovib")
        flags = {name for each in self.params if getattr(each, "is_flag", False) for name in each.opts}
        pairs = zip(["", *args], args, strict=False)
        # an option may be given any word, but not in quotation marks of a word processor
        odd = (word for last, word in pairs if last[:1] != "-" or last in flags or QUOTED.search(word))
        refuse_other_forms(odd, self)
        with explained(self, ctx):
            order = self.make_parser(ctx).parse_args(args=list(args))[2]
            twice = dict.fromkeys(each for each in order if order.count(each) > 1 and _is_single(each))
            if twice:
                raise InputError(
                    f"{each.opts[0]}: given {order.count(each)} times; give it once" for each in twice
                )
            return super().parse_args(ctx, args)  # type: ignore[misc, no-any-return]  # of typer


class Commands(_Arguments, TyperGroup):
    """The program: lists its commands by what they are for."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        if self.callback:
            _describe(self)

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

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Find a command; of a word that is none name the command that is meant."""
        if cmd_name not in self.commands:
            raise InputError(command_meant(cmd_name, ctx.command_path, self.commands))
        return super().get_command(ctx, cmd_name)


class Command(_Arguments, TyperCommand):
    """One command: its numpydoc describes its parameters, that of its module or of `options` those it shares.

    A section `Examples` stands at the beginning of the help.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        sections = _sections(self.help or "")
        self.help, self.epilog = sections[""], sections.get("Examples")
        _describe(self)

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write the example, then the description."""
        if self.epilog:
            formatter.write_paragraph()
            with formatter.indentation():
                formatter.write(f"{'':{formatter.current_indent}}Example: {self.epilog}\n")
        super().format_help_text(ctx, formatter)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options of the command, and what every answer has, below a heading each."""
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for each in self.get_params(ctx):
            title = "Options" if each.param_type_name == "option" else "Arguments"
            if row := each.get_help_record(ctx):
                groups.setdefault(getattr(each, "rich_help_panel", None) or title, []).append(row)
        for title, rows in groups.items():
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write nothing after the options."""

    def invoke(self, ctx: Any) -> Any:
        """Refuse a scenario in the place of another argument, with the order that was meant."""
        given = list(_positional(self, ctx))
        if swapped := _swapped(given):
            first, second = swapped
            meant = [{first: second, second: first}.get(value, value) for _, value in given]
            raise InputError(
                f"'{first}' stands where the scenario belongs, which '{second}' seems to be; the order is: electrovib"
                f" {ctx.info_name} {' '.join(meant)}"
            )
        options.refuse_blank(ctx)
        if style := ctx.params.get("style"):
            from electrovib.view.files import in_style

            outputs = ctx.params["output"] or []
            ctx.with_resource(in_style(style, [outputs] if isinstance(outputs, str) else outputs))
        return super().invoke(ctx)


def _is_single(parameter: Any) -> bool:
    """Return whether a parameter is an option with one value."""
    return parameter.param_type_name == "option" and not (parameter.multiple or parameter.is_flag)


def _positional(command: TyperCommand, ctx: Any) -> Iterator[tuple[str, str]]:
    """Iterate over the arguments without a name that were given: what each is, and its text."""
    for each in command.params:
        if each.param_type_name == "argument" and each.name:
            value = ctx.params.get(each.name)
            values = value if isinstance(value, (list, tuple)) else [value]
            yield from ((each.name, str(one)) for one in values if one)


def _swapped(given: list[tuple[str, str]]) -> tuple[str, str] | None:
    """Return what stands in the place of the scenario, and the TOML file that stands elsewhere; None where all is well."""
    names = [name for name, _ in given]
    place = next((names.index(name) for name in _SCENARIOS if name in names), None)
    if place is None or Path(given[place][1]).suffix.lower() == ".toml":
        return None
    others = [value for name, value in given if value.lower().endswith(".toml") and name != "others"]
    return (given[place][1], others[0]) if others else None
