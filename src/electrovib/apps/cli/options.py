"""The options of the commands: one table of lines for each command, which the help prints; what several have stands here."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from types import GenericAlias
from typing import Any, Final

import typer

from electrovib.core.errors import InputError
from electrovib.core.units import parse_count, parse_quantity

SHARED: Final = """
scenario               A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace.
--set PATH=VALUE       Change a parameter, or add an optional part: --set stack.gap='{ thickness = "5 um" }'; repeatable.
--models FILE.py       Python file with models of your own, which can then be named in a scenario; repeatable.
--all                  Print also the explanations, assumptions and sources.
--force                Replace a file that electrovib did not write, or that was changed.
--over PATH=FROM:TO:N[log]  Vary a parameter; repeatable.
--limits FILE.toml     Further limits beside those of the scenario; the strictest counts; repeatable.
--layer NAME           Layer of the material, where there are several.
--materials A,B,...    Materials of the insulator; 'all' of the library.
--report FILE          Write a self-contained HTML report.
--style journal        Of figures (-o x.pdf, .svg, .png): 85 mm wide, with text of 8 pt.
--space SPACE          Parameters that differ between fingers or are uncertain: a name such as fingers, or a TOML file with
    distributions.
--as hp_33120a -> instrument  Instrument whose codes are written.
--rate FREQUENCY       Samples per second, such as '192 kHz'; chosen if absent.
--ramp TIME            Ramps from and to 0 V, of this duration.
--largest-error SHARE  Error over the largest voltage above which nothing is written. [default: 0.01]
--full-scale VOLTAGE   Voltage of the drive at full scale.
--gain NUMBER          Voltage of the drive over that of the instrument. [default: 1.0]
--edge TIME|line       How samples follow each other where a waveform is played: held, with an edge that takes this time, or
    joined by straight lines (line).
--amplifier-present    The amplifier of the scenario stands before the plate: its bandwidth and limits count.
--column SIGNAL=COLUMN -> columns  Column of a signal, with a unit where the file states none: drive_voltage="Ch1 [V]";
    repeatable.
--recipe FILE.toml     Recipe by which a file is read, as 'electrovib import -o lab.toml' writes it; --set and --column add
    to it.
"""
"""What several commands have; each names it by its flag alone."""
_TYPES: Final[dict[str, type]] = {"N": int, "ROUNDS": int, "SHARE": float, "NUMBER": float, "PER_CENT": float}
"""What is read of an option, by the word after it; of any other a text."""


_SEARCHED: Final = ("query", "measured")
"""Arguments that are words to search for, of which a blank one is none."""


def _refuse_blank(flag: str, value: object) -> None:
    """Refuse a blank text, as of a variable that is not set: by it a file would not be written, or a wish forgotten."""
    for text in value if isinstance(value, (list, tuple)) else (value,):
        if isinstance(text, str) and not text.strip():
            raise InputError(
                "is blank, as a variable is that is not set; give a value, or omit it", path=flag
            )


class Arguments(dict[str, Any]):
    """What a command was given: the value of each option by its parameter, those with a default included."""

    def __init__(self, context: typer.Context) -> None:
        self.context = context
        self.flags = {str(each.name): each.opts[0] for each in context.command.params}
        sources = {name: context.get_parameter_source(name) for name in self.flags}
        self.typed = [name for name, source in sources.items() if source and source.name == "COMMANDLINE"]
        super().__init__()
        for each in context.command.params:
            name, value = str(each.name), context.params.get(str(each.name))
            if name in self.typed and name not in _SEARCHED:
                _refuse_blank(self.flags[name], value)
            if not (value in (None, [], (), [""]) or value is False or value == ""):
                self[name] = names_of(value) if ",..." in str(each.metavar) else value
        if style := self.pop("style", ""):
            from electrovib.view.files import in_style

            self.typed.remove("style")  # which every form of a command takes
            outputs = self.get("output", [])
            context.with_resource(in_style(style, [outputs] if isinstance(outputs, str) else outputs))

    def only(self, accepted: str, of: str, always: str = "models laws force") -> None:
        """Refuse every option that was given and is not among the names `accepted`, because `of` does not take it."""
        if surplus := self.surplus(f"{always} {accepted}"):
            raise InputError(f"{flag}: does not belong to {of}; omit it" for flag in surplus)

    def surplus(self, accepted: str) -> list[str]:
        """Return the flags that were given of options that are not among the names `accepted`."""
        return [self.flags[name] for name in self.typed if name not in accepted.split()]

    def read_set(self) -> None:
        """Read the changes of the scenario as values by dotted path."""
        from electrovib.apps.changes import read_changes

        self["set"] = read_changes(self.get("set", ()))

    def read_laws(self) -> list[str] | None:
        """Import the files among the laws, and return the names; None where no name is given, which stands for all."""
        from electrovib.core.own_models import use_models

        named = self.pop("laws", None)
        named = named and ["all" if name.lower() == "all" else name for name in named]
        files = [name for name in named or () if name.endswith(".py")]
        for file in files:
            use_models(file)
        laws = [name for name in dict.fromkeys(named or ()) if name not in files]
        return laws if laws or (named is not None and not files) else None

    def put_changes(self) -> None:
        """Put the changes into the scenario, for a function that takes none."""
        from electrovib.scenario import read_scenario

        if "set" in self:
            self.read_set()
            self["scenario"] = read_scenario(self["scenario"], changes=self.pop("set"))

    def take(self, names: str) -> dict[str, Any]:
        """Remove and return the values of these parameters that were given."""
        return {name: self.pop(name) for name in names.split() if name in self}


def takes(
    options: str, *, example: str = "", **eager: Callable[[Any], None]
) -> Callable[[Callable[[Arguments], object]], Callable[..., None]]:
    """Make a command of a function, with the arguments and options of a table.

    An entry has the flags, a word for the value if one follows, ``->`` and the name of the parameter if that is another one,
    and after two blanks the help, which may end with ``; repeatable.``, ``[required]``, ``[default: VALUE]`` or ``[env var:
    NAME]``. One without help is that of `SHARED`. An argument may be ``[optional]``, and have several values: ``files...``.
    The help begins with the `example`; `eager` are called with the values of options before any other is read.
    """
    eager = {"models": _use_models} | eager
    parameters = [_parameter(*entry, eager) for entry in _entries(options)]

    def made(command_of: Callable[[Arguments], object]) -> Callable[..., None]:
        def command(context: typer.Context, **_: Any) -> None:
            command_of(Arguments(context))

        own = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
        command.__signature__ = inspect.Signature([own, *parameters])  # type: ignore[attr-defined]
        command.__doc__, command.__name__, command.example = command_of.__doc__, command_of.__name__, example  # type: ignore[attr-defined]
        return command

    return made


def _entries(options: str) -> Iterator[tuple[str, str]]:
    """Iterate over the entries of a table: what stands before the help, and the help."""
    for entry in re.split(r"\n(?=\S)", options.strip()):
        head, _, words = entry.strip().partition("  ")
        words = " ".join(words.split())
        if head in _SHARED and (not words or words.startswith("[")):
            head, words = _SHARED[head][0], f"{_SHARED[head][1]} {words}".strip()
        yield head, words


_SHARED: Final[dict[str, tuple[str, str]]] = {}
_SHARED.update((entry[0].split()[0], entry) for entry in list(_entries(SHARED)))
_HEAD: Final = re.compile(r"(?P<flags>(?:-\S, )?-*\S+)(?: (?P<word>(?!->).*?))?(?: -> (?P<name>\S+))?")
_HELP: Final = re.compile(
    r"(?P<words>.*?) ?(?:\[(?:(?P<required>required)|default: (?P<default>.*)|env var: (?P<variable>.*))\])?"
)


def _parameter(head: str, words: str, eager: Mapping[str, Callable[[Any], None]]) -> inspect.Parameter:
    """Return an argument or an option, as typer reads it from the parameter of a function."""
    flags, word, name = _HEAD.fullmatch(head).groups()  # type: ignore[union-attr]
    about, required, default, variable = _HELP.fullmatch(words).groups()  # type: ignore[union-attr]
    name = name or flags.rpartition(", ")[2].strip("-[.]").replace("-", "_")
    kind = _TYPES.get(word, str) if word else bool
    many = about.endswith("; repeatable.") or (",..." in str(word) and not default)
    shown: dict[str, Any] = {"help": about, "metavar": word or None, "show_default": default is not None}
    if flags.startswith("-"):
        value = ... if required else False if kind is bool else default and kind(default)
        if name in eager:
            shown |= {"callback": eager[name], "is_eager": True, "expose_value": False}
        if kind in {int, float}:
            shown["parser"] = functools.partial(_number, flags.split(", ")[-1], kind)
        found = typer.Option(value, *flags.split(", ")[::-1], envvar=variable, **shown)
    else:
        kind, many = str, flags.endswith("...")
        value = default if default or flags.startswith("[") else ...
        found = typer.Argument(value, hidden=not about, **shown)
    found.autocompletion = _COMPLETED.get(name)
    annotation = GenericAlias(list, kind) if many else kind
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=found, annotation=annotation)


def _number(flag: str, kind: type, text: object) -> float:
    """Read the number of an option."""
    _refuse_blank(flag, text)
    try:
        return parse_count(str(text)) if kind is int else parse_quantity(str(text), "1")
    except ValueError as error:
        raise InputError(str(error), path=flag, value=str(text)) from None


def scenario_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper's scenario; only the paper that is already written is imported.

    Where several papers can be meant, their names are offered with a slash: ``author_year/``.
    """
    from electrovib.core.discovery import offers, paper_names

    author_year, slash, _ = incomplete.partition("/")
    papers = [
        name for name in paper_names() if name == author_year or (not slash and name.startswith(author_year))
    ]
    if len(papers) > 1:
        yield from (f"{name}/" for name in papers)
        return
    for name in papers:
        yield from (
            found for found in offers(("scenarios",), of=name) if found.startswith(incomplete) or not slash
        )


def model_names(incomplete: str) -> Iterator[tuple[str, str]]:
    """Complete the name of a model, a paper, a material, a skin or a scenario, with what it is."""
    from electrovib.studies.catalogue.items import everything

    for item in everything():
        if item.name.startswith(incomplete):
            yield item.name, item.kind


def paper_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper, without importing it."""
    from electrovib.core import discovery

    yield from (name for name in discovery.paper_names() if name.startswith(incomplete))


def quantity_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a quantity of a scenario."""
    from electrovib.core.signals import SIGNALS
    from electrovib.solve.quantities.names import TAKEN, signals_over_time

    for signal in signals_over_time():
        where = " in" if "layer" in SIGNALS[signal].dims else ""
        yield from (name for taken in TAKEN if (name := f"{taken} {signal}{where}").startswith(incomplete))


def space_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a shipped population."""
    from electrovib.scenario.space.shipped import shipped_names

    yield from (name for name in shipped_names() if name.startswith(incomplete))


def parameter_paths(ctx: typer.Context, incomplete: str) -> Iterator[tuple[str, str]]:
    """Complete the dotted path of a physical parameter of the scenario that stands before it, with what it means."""
    from electrovib.core.errors import ElectrovibError
    from electrovib.scenario import read_scenario

    try:
        # the parser stops at an option without its value, and leaves the arguments before it unassigned
        scenario = read_scenario(ctx.params.get("scenario") or next(iter(ctx.args), ""))
    except ElectrovibError:
        return
    for path, _, quantity in scenario.parameters():
        if path.startswith(incomplete):
            yield path, quantity.doc


_COMPLETED: Final = {
    "scenario": scenario_names, "query": model_names, "paper": paper_names, "want": quantity_names,
    "space": space_names, "free": parameter_paths,
}  # fmt: skip


def _use_models(files: list[str] | None) -> None:
    for file in files or ():
        from electrovib.core.own_models import use_models

        _refuse_blank("--models", file)
        use_models(file)


def names_of(texts: list[str] | str | None) -> list[str]:
    """Split names at commas."""
    each = [texts] if isinstance(texts, str) else texts or []
    return [name.strip() for text in each for name in text.split(",") if name.strip()]


def pair_of(text: str, name: str, form: str) -> tuple[str, str]:
    """Split ``NAME=VALUE`` at the last equals sign."""
    first, sign, second = text.rpartition("=")
    if not (sign and first.strip() and second.strip()):
        raise InputError(f"{name} {text}: expected {form}")
    return first.strip(), second.strip()
