"""The lists of what is public, written from the code; what a release has does not vanish in the next one without a warning."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import commands
import functions
import typer.main
from packaging.version import Version

import electrovib as ev
from electrovib.apps import exit_codes
from electrovib.apps.cli import app
from electrovib.apps.cli.gone import GONE
from electrovib.core.deprecation import FORMER, FORMER_PARAMETERS, GONE_PARAMETERS, Former
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.model import Model, hidden_names
from electrovib.core.signals import SIGNALS
from electrovib.data.registry import FORMATS
from electrovib.recordings.interval import Interval
from electrovib.scenario.space.reading import KINDS
from electrovib.scenario.space.shipped import shipped_names
from electrovib.solve.quantities.names import TAKEN
from electrovib.studies.catalogue.items import everything

SHARED: Final = (Diagnostic, Interval)
"""What the attributes of many results hold."""
ROOT: Final = Path(__file__).parents[2]
PAGE: Final = ROOT / "docs" / "api.md"
DEPRECATED: Final = "Deprecated"
GOES: Final = "goes in "
SINGLE: Final = "Parts of a scenario, of a set-up or of a recording"
MARK: Final = "<!-- written by docs/_ext/api.py -->\n"


class Entry(NamedTuple):
    """One line of the page: a name with its parameters as they are given, or with what belongs to it."""

    name: str
    parts: tuple[str, ...] = ()
    is_called: bool = False

    def __str__(self) -> str:
        parts = ", ".join(self.parts)
        return f"{self.name}({parts})" if self.is_called else f"{self.name}: {parts}" if parts else self.name


Sections = dict[str, list[Entry]]


def public() -> Sections:
    """Collect the public names, by section of the page."""
    for module in pkgutil.walk_packages(ev.__path__, "electrovib."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    called = [(name, thing) for name, _, thing in functions.public()]
    kinds = [(name, thing) for name, thing in called if inspect.isclass(thing)]
    kinds += [(each.__name__, each) for each in SHARED]
    return {
        "Functions": [of_call(name, thing) for name, thing in called],
        "Attributes of classes and results": [of_class(*each) for each in sorted({*results(called), *kinds})],
        "Imported by models of others": imported(),
        **of_families(),
        "Signals of a Trace": [Entry(f"{name} [{known.unit}]") for name, known in SIGNALS.items()],
        "Statistics of a signal over time": [Entry(name) for name in TAKEN],
        "Commands": [
            of_command(name, each)
            for name, each in [("electrovib", root()), *commands.every(root(), "electrovib")]
        ],
        "Exit codes": [Entry(f"{code} {name}") for name, code in vars(exit_codes).items() if name.isupper()],
        "Names that inputs take": of_names(),
        DEPRECATED: [of_former(name, each) for name, each in former()],
    }


def root() -> Any:
    """Return the command line."""
    return typer.main.get_command(app)


def of_call(name: str, thing: Any) -> Entry:
    """Describe what is called by its parameters."""
    parts, by_name = [], False
    if inspect.isclass(thing) and issubclass(thing, Model):
        thing.model_rebuild()  # its signature is known once it is built, which is deferred
    for each in inspect.signature(thing).parameters.values():
        if each.kind is each.KEYWORD_ONLY and not by_name:
            parts.append("*")
            by_name = True
        stars = {each.VAR_KEYWORD: "**", each.VAR_POSITIONAL: "*"}.get(each.kind, "")
        parts.append(f"{stars}{each.name}" + "=" * (each.default is not each.empty))
    return Entry(name, tuple(parts), is_called=True)


def results(called: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, type]]:
    """Find the classes of the package that functions return; no name of a class is there twice."""
    known = {
        thing.__name__: thing
        for name, module in list(sys.modules.items())
        if name.startswith("electrovib.")
        for thing in vars(module).values()
        if inspect.isclass(thing) and thing.__module__ == name
    }
    for _, function in called:
        for name in re.findall(r"[A-Z]\w+", str(getattr(function, "__annotations__", {}).get("return"))):
            if name in known:
                yield name, known[name]


def of_class(name: str, kind: type) -> Entry:
    """Describe a class by the attributes and methods of its objects."""
    own = [base for base in kind.__mro__ if base.__module__.startswith("electrovib.")]
    found = {each for base in own for each in (*vars(base), *getattr(base, "__annotations__", ()))}
    hidden = hidden_names(Model) if issubclass(kind, Model) else frozenset()
    return Entry(
        name, tuple(sorted(each for each in found - hidden if not (each.startswith("_") or each.isupper())))
    )


def imported() -> list[Entry]:
    """List what the guides import from modules of the package."""
    found = defaultdict(set)
    for page in (ROOT / "docs" / "how_to").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for module, names in re.findall(r"^from (electrovib\.\S+) import (.*)$", text, re.MULTILINE):
            found[module].update(names.split(", "))
    return [Entry(module, tuple(sorted(names))) for module, names in sorted(found.items())]


def families(of: type[Model] = Model) -> Iterator[type[Model]]:
    """Find every class of models of the package."""
    for each in of.__subclasses__():
        if each.__module__.startswith("electrovib."):
            yield each
        yield from families(each)


def of_families() -> Sections:
    """List the models of each family, and those that are the only one of their kind."""
    found = defaultdict(list)
    for each in sorted(families(), key=lambda kind: kind.__name__):
        if not each.is_family:
            *_, first = (base for base in each.__mro__ if issubclass(base, Model) and base is not Model)
            found[first.__name__ if first.is_family else SINGLE].append(of_model(each))
    drawn = sorted(KINDS.items())
    return dict(sorted({**found, "Distribution": [of_call(name, each) for name, each in drawn]}.items()))


def of_model(kind: type[Model]) -> Entry:
    """Describe a model by its parameters, derived ones included."""
    own = [name + "=" * (not field.is_required()) for name, field in kind.model_fields.items()]
    parts = [*own, *(f"{name}=" for name in kind.derived)]
    return Entry(kind.__name__, ("*", *parts) if parts else (), is_called=True)


def of_command(name: str, command: Any) -> Entry:
    """Describe a command by its arguments and options."""
    found: list[str] = []
    for each in command.params:
        is_argument = each.param_type_name == "argument"
        found += [each.name.upper()] if is_argument else [*each.opts, *each.secondary_opts]
    return Entry(name, tuple(one for one in found if "completion" not in one))


def of_names() -> list[Entry]:
    """List what is taken by its name: shipped and published things, and readers of files."""
    found = defaultdict(list)
    for item in everything(own=True):
        if not isinstance(item.thing, type):
            found[item.kind].append(item.name)
    found |= {"population": list(shipped_names()), "reader": [each.name for each in FORMATS]}
    return [Entry(kind, tuple(sorted(names))) for kind, names in sorted(found.items())]


def former() -> Iterator[tuple[str, Former]]:
    """Find all former names: those of functions, and parameters, options and members after what has them."""
    yield from FORMER.items()
    for parameters in (FORMER_PARAMETERS, GONE_PARAMETERS):
        for owner, names in parameters.items():
            yield from ((f"{owner}.{name}", each) for name, each in names.items())
    for command, options in GONE.items():
        yield from ((f"electrovib {command}.{name}", each) for name, each in options.items())
    for kind in families():
        yield from ((f"{kind.__name__}.{name}", each) for name, each in vars(kind).get("former", {}).items())


def of_former(name: str, each: Former) -> Entry:
    """Describe a former name."""
    return Entry(name, (*f"now {each.now}".split(", "), f"since {each.since}", f"{GOES}{each.goes}"))


def version() -> str:
    """Return the version that is being made."""
    (found,) = re.findall(
        r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE
    )
    return str(found)


def as_markdown() -> str:
    """Write the lists."""
    parts = [
        "\n".join([f"\n## {title}\n", *(f"- `{each}`" for each in entries)])
        for title, entries in public().items()
        if entries
    ]
    return "\n".join([f"Version {version()} has these names.", *parts, ""])


def read(text: str) -> Sections:
    """Read the lists of a page."""
    found: Sections = {}
    for section in text.split("\n## ")[1:]:
        lines = re.findall(r"^- `([^`(:]+)(?:(\()([^`]*)\)|: ([^`]+))?`$", section, re.MULTILINE)
        entries = [
            Entry(name, tuple(filter(None, (inner or parts).split(", "))), bool(call))
            for name, call, inner, parts in lines
        ]
        if entries:
            found[section.partition("\n")[0]] = entries
    return found


def lost(before: Sections, now: Sections, *, at: str) -> list[str]:
    """Say what a user of an earlier release would miss, or would have to give, in the version `at`."""
    said = []
    known = {each.name for each in now.get(DEPRECATED, ())}
    for section, entries in before.items():
        there = {each.name: each for each in now.get(section, ())}
        for entry in entries:
            if entry.name in there:
                said += changed(entry, there[entry.name], known)
            elif not known & {entry.name, f"{section}.{entry.name}"} and not is_due(section, entry, at):
                said.append(f"{entry.name} is gone")
    return said


def is_due(section: str, entry: Entry, at: str) -> bool:
    """Return whether a former name goes in the version `at`, or went before."""
    return section == DEPRECATED and Version(at) >= Version(entry.parts[-1].removeprefix(GOES))


def changed(before: Entry, now: Entry, known: set[str]) -> list[str]:
    """Say which parts are gone, and what a call would have to be given that it was not."""
    bare = {each.rstrip("="): each for each in now.parts}
    said = [
        f"{before.name}: {each} is gone"
        for each in (part.rstrip("=") for part in before.parts)
        if each not in bare and each != "*" and f"{before.name}.{each}" not in known
    ]
    if not (before.is_called and now.is_called):
        return said
    needed = [each for each in now.parts if each[-1] != "=" and each[0] != "*" and each not in before.parts]
    said += [f"{before.name}: {each} has to be given" for each in needed]
    old, new = (positional(each) for each in (before, now))
    return said if new[: len(old)] == old or said else [f"{before.name}: another order of {', '.join(old)}"]


def positional(entry: Entry) -> list[str]:
    """Return the parameters that can be given without their names, in their order."""
    parts = entry.parts[: entry.parts.index("*")] if "*" in entry.parts else entry.parts
    return [each.rstrip("=") for each in parts if each[0] != "*"]


if __name__ == "__main__":
    promise, _, before = PAGE.read_text(encoding="utf-8").partition(MARK)
    lists = as_markdown()
    if missing := lost(read(before), read(lists), at=version()):
        sys.exit("\n".join([*missing, f"If that is meant, take it out of {PAGE.name} by hand first."]))
    PAGE.write_text(f"{promise}{MARK}\n{lists}", encoding="utf-8")
