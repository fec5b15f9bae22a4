"""What several commands have: kinds of options, their completion, and what was given.

A parameter that the numpydoc of a command does not describe is one of these.

Parameters
----------
scenario
    A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace.
set : PATH=VALUE
    Change a parameter, or add an optional part: --set stack.gap='{ thickness = "5 um" }'; repeatable.
models : FILE.py
    Python file with models of your own, which can then be named in a scenario; repeatable.
all
    Print also the explanations, assumptions and sources.
force
    Replace a file that electrovib did not write, or that was changed.
over : PATH=FROM:TO:N[log]
    Vary a parameter; repeatable.
limits : FILE.toml
    Further limits beside those of the scenario; the strictest counts; repeatable.
layer : NAME
    Layer of the material, where there are several.
materials : A,B,...
    Materials of the insulator; 'all' of the library.
output : FILE|DIR
    A page (.html), a figure (.pdf, .svg, .png), tables (.csv, .tex), or a folder with all.
report : FILE
    Write a report: a page (.html) that holds everything, or what else -o of report takes.
style : journal
    Of figures (-o x.pdf, .svg, .png): 85 mm wide, with text of 8 pt.
space : SPACE
    Parameters that differ between fingers or are uncertain: a name such as fingers, or a TOML file with distributions.
rate : FREQUENCY
    Samples per second, such as '192 kHz'; chosen if absent.
ramp : TIME
    Ramps from and to 0 V, of this duration.
edge : TIME|line
    How samples follow each other where a waveform is played: held, with an edge that takes this time, or joined by straight
    lines (line).
columns : SIGNAL=COLUMN
    Column of a signal, with a unit where the file states none: drive_voltage="Ch1 [V]"; repeatable.
recipe : FILE.toml
    Recipe by which a file is read, as 'electrovib import -o lab.toml' writes it; --set and --column add to it.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, is_dataclass
from typing import Annotated, Any, Final, get_type_hints

import typer

from electrovib.core.errors import InputError
from electrovib.core.units import parse_count, parse_quantity


def _blank(flag: str) -> InputError:
    """Say of an option that its text is blank: by it a file would not be written, or a wish forgotten."""
    return InputError("is blank, as a variable is that is not set; give a value, or omit it", path=flag)


def refuse_blank_text(flag: str, text: str) -> None:
    """Refuse a blank text of an option."""
    if not text.strip():
        raise _blank(flag)


def read_number(flag: str, kind: type, text: object) -> float:
    """Read the number of an option."""
    refuse_blank_text(flag, str(text))
    try:
        return parse_count(str(text)) if kind is int else parse_quantity(str(text), "1")
    except ValueError as error:
        raise InputError(str(error), path=flag, value=str(text)) from None


def scenario_names(incomplete: str) -> Iterator[str]:
    """Complete the name of a paper's scenario; only the paper that is already written is imported.

    Where several papers can be meant, their names are offered with a slash: ``author_year/``.
    """
    from electrovib.core.discovery import offered_by, paper_names

    author_year, slash, _ = incomplete.partition("/")
    papers = [
        name for name in paper_names() if name == author_year or (not slash and name.startswith(author_year))
    ]
    if len(papers) > 1:
        yield from (f"{name}/" for name in papers)
        return
    for name in papers:
        found = (f"{name}/{key}" for key in offered_by(name, "scenarios"))
        yield from (each for each in found if each.startswith(incomplete) or not slash)


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


def use_models(file: str) -> None:
    """Import a file with models of a user."""
    from electrovib.core import own_models

    refuse_blank_text("--models", file)
    own_models.use_models(file)


def _use_each(files: list[str] | None) -> None:
    for file in files or ():
        use_models(file)


def refuse_blank(context: typer.Context) -> None:
    """Refuse each blank text that was typed, but that of words to search for, of which a blank one is none."""
    for name, flag in _typed(context).items():
        value = context.params[name]
        texts = value if isinstance(value, (list, tuple)) else (value,)
        if name not in ("query", "measured") and any(
            isinstance(each, str) and not each.strip() for each in texts
        ):
            raise _blank(flag)


def _typed(context: typer.Context) -> dict[str, str]:
    """Return the flag of each parameter that was typed, and is neither absent nor of the environment."""
    flags = {str(each.name): str(each.opts[0]) for each in context.command.params}
    sources = {name: context.get_parameter_source(name) for name in flags}
    return {name: flags[name] for name, found in sources.items() if found and found.name == "COMMANDLINE"}


def surplus(context: typer.Context, accepted: str) -> list[str]:
    """List the flags that were typed of options that are not among the names `accepted`."""
    return [flag for name, flag in _typed(context).items() if name not in accepted.split()]


def only(context: typer.Context, accepted: str, of: str) -> None:
    """Refuse every option that was typed and is not among the names `accepted`, because `of` does not take it."""
    if found := surplus(context, f"style force {accepted}"):
        raise InputError(f"{flag}: does not belong to {of}; omit it" for flag in found)


def given(**values: Any) -> dict[str, Any]:
    """Return the values that were given; for any other the function that is called has its default."""
    return {name: value for name, value in values.items() if value is not None}


def changes(set: Sequence[str] | None) -> dict[str, Any]:
    """Read the changes of ``--set`` as values by dotted path."""
    from electrovib.core.tables import read_changes

    return read_changes(set)


def changed(scenario: str, set: Sequence[str] | None) -> Any:
    """Put changes into a scenario, for a function that takes none."""
    from electrovib.scenario import read_scenario

    return read_scenario(scenario, changes=changes(set)) if set else scenario


def read_laws(named: list[str] | None) -> list[str] | None:
    """Import the files among the laws, and return the names; None where no name is given, which stands for all."""
    from electrovib.core.own_models import use_models

    named = named and ["all" if name.lower() == "all" else name for name in names_of(named)]
    files = [name for name in named or () if name.endswith(".py")]
    for file in files:
        use_models(file)
    laws = [name for name in dict.fromkeys(named or ()) if name not in files]
    return laws if laws or (named is not None and not files) else None


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


def number(flag: str, kind: type = float) -> Any:
    """Declare an option with a number: a whole one, or one that may have a unit such as %."""
    return typer.Option(flag, parser=functools.partial(read_number, flag, kind))


def split(param: typer.CallbackParam, value: list[str] | None) -> list[str] | None:
    """Split names at commas, unless an option is absent."""
    if not all(text.strip(", ") for text in value or ()):
        raise _blank(param.opts[0])
    return value and names_of(value)


ANSWER: Final = "What is printed and written"
"""Heading of the options of every answer in the help of a command."""
Scenario = Annotated[str, typer.Argument(autocompletion=scenario_names)]
Files = Annotated[list[str], typer.Argument()]
Text = Annotated[str | None, typer.Option()]
Texts = Annotated[list[str] | None, typer.Option()]
Names = Annotated[list[str] | None, typer.Option(callback=split)]
Needed = Annotated[str, typer.Option()]
Flag = Annotated[bool, typer.Option()]
Output = Annotated[str | None, typer.Option("--output", "-o", rich_help_panel=ANSWER)]
Force = Annotated[bool, typer.Option("--force", rich_help_panel=ANSWER)]
Changes = Annotated[list[str] | None, typer.Option("--set")]
Models = Annotated[list[str] | None, typer.Option("--models", callback=_use_each, is_eager=True)]
Style = Annotated[str | None, typer.Option("--style", rich_help_panel=ANSWER)]
Columns = Annotated[list[str] | None, typer.Option("--column")]
Details = Annotated[bool, typer.Option("--all", rich_help_panel=ANSWER)]
Space = Annotated[str, typer.Option(autocompletion=space_names)]
Seed = Annotated[int, number("--seed", int)]
Count = Annotated[int, number("-n", int)]


@dataclass(frozen=True, kw_only=True)
class ScenarioOptions:
    """A scenario with its changes; a parameter of this class, as of those below, stands for these options of a command."""

    scenario: Scenario
    set: Changes = None

    @property
    def asked(self) -> dict[str, Any]:
        """Scenario and changes, for a function that takes both."""
        return {"scenario": self.scenario, "set": changes(self.set)}

    @property
    def changed(self) -> Any:
        """The scenario with its changes, for a function that takes none."""
        return changed(self.scenario, self.set)


@dataclass(frozen=True, kw_only=True)
class DefaultScenarioOptions(ScenarioOptions):
    """A scenario with its changes, by default the pulse of Vezzoli et al. 2014."""

    scenario: Scenario = "vezzoli_2014/fig6"


@dataclass(frozen=True, kw_only=True)
class LimitOptions(ScenarioOptions):
    """A scenario with its changes, and limits beside its own."""

    limits: Texts = None

    @property
    def asked(self) -> dict[str, Any]:
        """Scenario, changes and limits."""
        return super().asked | given(limits=self.limits)


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Where a result is written."""

    output: Output = None
    force: Force = False


@dataclass(frozen=True, kw_only=True)
class AnswerOptions(FileOptions):
    """How an answer is printed and written."""

    style: Style = None
    all: Details = False


def spread_out(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the options of each parameter that is a class of several, such as `AnswerOptions`, in its place."""
    own = inspect.signature(command).parameters
    kinds = {name: each.annotation for name, each in own.items()}
    classes = {name: kind for name, kind in kinds.items() if isinstance(kind, type) and is_dataclass(kind)}
    of = {name: inspect.signature(kind).parameters for name, kind in classes.items()}
    found = dict[str, inspect.Parameter]()
    for name, each in own.items():
        hints = get_type_hints(classes[name], include_extras=True) if name in classes else {}
        found |= {
            option: declared.replace(annotation=hints.get(option, declared.annotation))
            for option, declared in of.get(name, {name: each}).items()
        }

    @functools.wraps(command)
    def call(**typed: Any) -> None:
        filled = {
            name: kind(**{each: typed.pop(each) for each in of[name]}) for name, kind in classes.items()
        }
        command(**typed, **filled)

    call.__signature__ = inspect.Signature(list(found.values()))  # type: ignore[attr-defined]  # which typer reads
    call.__annotations__ = {name: each.annotation for name, each in found.items()}
    return call
