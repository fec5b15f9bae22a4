"""Every option of the commands, declared once: its name, what is written after it, and what it means."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, TypeAlias

import typer


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


Text: TypeAlias = str | None
Texts: TypeAlias = list[str] | None


def option(help: str, *names: str, metavar: str | None = None, **more: Any) -> Any:  # noqa: A002 - the word of typer
    """Return an option whose default, which its help states, is not shown by typer."""
    return typer.Option(*names, help=help, metavar=metavar, show_default=False, **more)


def many(metavar: str, help: str, *names: str, **more: Any) -> Any:  # noqa: A002 - the word of typer
    """Return an option that can be given several times."""
    return option(f"{help}; repeatable.", *names, metavar=metavar, **more)


def output(help: str, metavar: str | None = None) -> Any:  # noqa: A002 - the word of typer
    """Return the option that names the file or the folder to write."""
    return option(help, "--output", "-o", metavar=metavar)


def _use(context: typer.Context, files: Texts) -> Texts:
    if files and not context.resilient_parsing:
        from electrovib.core.own_models import use_models

        for file in files:
            use_models(file)
    return files


Scenario: TypeAlias = Annotated[
    str,
    typer.Argument(
        help="A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace.",
        autocompletion=scenario_names,
    ),
]

# what several commands share
Models: TypeAlias = Annotated[
    Texts,
    many(
        "FILE.py",
        "Python file with models of your own, which can then be named in a scenario",
        "--models",
        callback=_use,
        is_eager=True,
    ),
]
Changes: TypeAlias = Annotated[
    Texts,
    many(
        "PATH=VALUE",
        "Change a parameter, or add an optional part: --set stack.gap='{ thickness = \"5 um\" }'",
        "--set",
    ),
]
Everything: TypeAlias = Annotated[
    bool, option("Print also the explanations, assumptions and sources.", "--all")
]
Force: TypeAlias = Annotated[
    bool, option("Replace a file that electrovib did not write, or that was changed.", "--force")
]
Over: TypeAlias = Annotated[Texts, many("PATH=FROM:TO:N[log]", "Vary a parameter")]
Limits: TypeAlias = Annotated[
    Texts, many("FILE.toml", "Further limits beside those of the scenario; the strictest counts")
]
Layer: TypeAlias = Annotated[str, option("Layer of the material, where there are several.", metavar="NAME")]
Material: TypeAlias = Annotated[
    Text, option("Materials of the insulator; 'all' of the library.", metavar="A,B,...")
]
Page: TypeAlias = Annotated[Text, option("Write a self-contained HTML report.", "--report", metavar="FILE")]
Space: TypeAlias = Annotated[
    Text,
    option(
        "Parameters that differ between fingers or are uncertain: a name such as fingers, or a TOML file with distributions.",
        "--space",
        metavar="SPACE",
        autocompletion=space_names,
    ),
]

# of a waveform that is written
Instrument: TypeAlias = Annotated[
    str, option("Instrument whose codes are written.", "--as", metavar="hp_33120a")
]
Rate: TypeAlias = Annotated[
    str, option("Samples per second, such as '192 kHz'; chosen if absent.", metavar="FREQUENCY")
]
Ramp: TypeAlias = Annotated[str, option("Ramps from and to 0 V, of this duration.", metavar="TIME")]
LargestError: TypeAlias = Annotated[
    float,
    typer.Option(metavar="SHARE", help="Error over the largest voltage above which nothing is written."),
]
FullScale: TypeAlias = Annotated[str, option("Voltage of the drive at full scale.", metavar="VOLTAGE")]
Gain: TypeAlias = Annotated[
    float, typer.Option(metavar="NUMBER", help="Voltage of the drive over that of the instrument.")
]
Edge: TypeAlias = Annotated[
    str,
    option(
        "How samples follow each other where a waveform is played: held, with an edge that takes this time, or joined by"
        " straight lines (line).",
        metavar="TIME|line",
    ),
]
AmplifierPresent: TypeAlias = Annotated[
    bool,
    option(
        "The amplifier of the scenario stands before the plate: its bandwidth and limits count.",
        "--amplifier-present",
    ),
]

# of a file of an instrument
Column: TypeAlias = Annotated[
    Texts,
    many(
        "SIGNAL=COLUMN",
        'Column of a signal, with a unit where the file states none: drive_voltage="Ch1 [V]"',
    ),
]
Recipe: TypeAlias = Annotated[
    Text,
    option(
        "Recipe by which a file is read, as 'electrovib import -o lab.toml' writes it; --set and --column add to it.",
        metavar="FILE.toml",
    ),
]


def names_of(texts: Texts) -> list[str]:
    """Split names at commas."""
    return [name.strip() for text in texts or [] for name in text.split(",") if name.strip()]


def pair_of(text: str, name: str, form: str) -> tuple[str, str]:
    """Split ``NAME=VALUE`` at the last equals sign."""
    from electrovib.core.errors import InputError

    first, sign, second = text.rpartition("=")
    if not (sign and first.strip() and second.strip()):
        raise InputError(f"{name} {text}: expected {form}")
    return first.strip(), second.strip()


def only(context: typer.Context, accepted: str, of: str, always: str = "models force") -> None:
    """Refuse every option that was given and is not among the names `accepted`, because `of` does not take it."""
    from electrovib.core.errors import InputError

    names = {*always.split(), *accepted.split()}
    given = [each for each in context.command.params if _is_given(context, str(each.name))]
    if surplus := [each.opts[0] for each in given if each.name not in names]:
        raise InputError(f"{name}: does not belong to {of}; omit it" for name in surplus)


def given(context: typer.Context, names: str) -> dict[str, Any]:
    """Return the values that were given, by the names of the parameters; those of a public function have the same names."""
    return {name: context.params[name] for name in names.split() if _is_given(context, name)}


def _is_given(context: typer.Context, name: str) -> bool:
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
