"""Scenarios from TOML, papers, tables and Traces, with the models of a user that they need; and those of papers from others."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.core.discovery import offered_by, paper_names, papers
from electrovib.core.errors import (
    LONGEST_QUOTED,
    InputError,
    Problem,
    closest_file,
    nearest,
    refuse,
    shortened,
)
from electrovib.core.file_kinds import other_kind
from electrovib.core.files import kind_of
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import missing_models, origins
from electrovib.core.parsing import read_json, read_toml_file
from electrovib.core.signals import is_trace
from electrovib.core.tables import Changed
from electrovib.data.traces import is_trace_file, open_if_trace
from electrovib.scenario.experiment import Scenario
from electrovib.scenario.files import read_part, sources_of_offers
from electrovib.scenario.sources import is_default, near_presets, wrong_sources
from electrovib.scenario.toml import SCHEMA

if TYPE_CHECKING:
    import xarray


DEFAULT: Final = "vezzoli_2014/fig6"
Source: TypeAlias = "str | Path | Mapping[str, Any] | Scenario | xarray.Dataset"
"""Anything that a scenario can be read from."""


def read_scenario(
    source: Source, *, changes: Mapping[str, Any] | None = None, before_sweep: bool = False
) -> Scenario:
    """Read a scenario from a name, a file, tables, a Scenario or a Trace.

    Parameters
    ----------
    source : str, Path, mapping, Scenario or xarray.Dataset
        A paper's scenario such as ``"vezzoli_2014/fig6"``, a TOML file, nested tables, a Scenario, or a Trace: its
        file (``.nc``, ``.mat``) or itself, which carries the scenario it was computed from.
    changes : mapping of str to value, optional
        Dotted path to value, put into the scenario; names of files in it are relative to the working folder.
    before_sweep : bool
        Return the scenario from which a sweep began; otherwise a sweep, which is many scenarios, is refused.

    Returns
    -------
    scenario : Scenario
        Validated.

    Raises
    ------
    InputError
        Every mistake of the file at once; also if the source has no scenario, or many.

    Examples
    --------
    >>> ev.load("vezzoli_2014/fig6", changes={"drive.high": "500 V"}).drive.high
    500.0
    """
    if is_trace_file(source) or is_trace(source):
        scenario = _of_trace(source, before_sweep=before_sweep)
    elif isinstance(source, Scenario):
        scenario = source
    elif isinstance(source, Mapping):
        return _read({"schema": SCHEMA} | {str(key): item for key, item in source.items()}, changes, Path())
    elif not isinstance(source, (str, os.PathLike)):
        raise InputError(
            f"scenario = {shortened(repr(source), LONGEST_QUOTED)}: expected a paper's scenario such as '{DEFAULT}', a"
            " .toml file, nested tables, a Scenario or a Trace"
        )
    else:
        path = Path(source)
        if not paper_of_preset(source):
            return _read(_tables(path), changes, path.parent)
        scenario = paper_scenario(str(source))
    return scenario.replace(changes) if changes else scenario


load = read_scenario
"""The name under which users know `read_scenario`."""


def _of_trace(source: Any, *, before_sweep: bool) -> Scenario:
    """Return the scenario of a run; a sweep, whose scenario lacks the swept values, is refused."""
    trace = open_if_trace(source)
    axes = {} if before_sweep else sweep_of(trace)[0]
    if not axes:
        return scenario_of(trace)
    swept = " and ".join(axes)
    name, where = ("this Trace", "") if trace is source else (f"{source}:", f" {source}")
    raise InputError(
        f"{name} holds a sweep over {swept}, that is many scenarios; write the one it began from with"
        f" 'electrovib init{where}', and set {swept} there"
    )


def _read(content: dict[str, Any], changes: Mapping[str, Any] | None, folder: Path) -> Scenario:
    """Build a scenario; changes may correct mistakes in the tables."""
    content = without_schema(content)
    given: Mapping[str, Any] | None = changes
    try:
        scenario = read_part(Scenario, content, folder=folder)
    except InputError as error:
        if not changes:
            wrong = wrong_sources(Scenario, content)
            others = [each for each in error.problems if each.path not in {one.path for one in wrong}]
            raise InputError([*others, *wrong]) from None
        content = Changed().within(_beside(changes, folder), content, Scenario, fresh=True)
        scenario, given = read_part(Scenario, content, folder=folder), None
    if not scenario.sources.keys() <= {path for path, _, _ in scenario.parameters()} and (
        wrong := wrong_sources(Scenario, scenario.to_dict())
    ):
        raise InputError(wrong)
    return scenario.replace(given) if given else scenario


def _beside(changes: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Make names of files that the caller gives relative to the folder of the scenario."""
    found = dict(changes)
    for path, value in changes.items():
        if path.rpartition(".")[2] == "file" and isinstance(value, str):
            found[path] = os.path.relpath(value, folder)
    return found


def _tables(path: Path) -> dict[str, Any]:
    near = "" if kind_of(path) else _near_file(str(path)).strip()
    advice = near or f"Give a .toml file or a paper, for instance {DEFAULT}"
    if not (found := read_toml_file(path, kind="a scenario", advice=advice)):
        raise InputError(
            f"the file is empty. 'electrovib init {DEFAULT}' prints one to start from", path=path
        )
    return found


def _near_file(name: str) -> str:
    """Ask for the scenario or Trace in the folder of a file that is not there whose name is most like it."""
    path = Path(name)
    try:
        beside = [str(file) for file in path.parent.iterdir() if file.suffix.lower() in {".toml", ".nc"}]
    except OSError:
        return ""
    return closest_file(str(path), beside) if path.suffix else ""


def paper_of_preset(source: object) -> str:
    """Return the paper, ``author_year``, of a ready-made scenario; empty for a scenario of the user."""
    path = Path(source) if isinstance(source, (str, Path)) else None
    if path is None or path.suffix == ".toml" or is_trace_file(path) or kind_of(path):
        return ""
    return str(source).partition("/")[0]


def paper_scenario(name: str) -> Scenario:
    """Find a paper's scenario by ``author_year/name``."""
    if name == "-":
        why = "a scenario is not read from the standard input; save it as a .toml file and give its name"
        raise InputError(why)
    if why := other_kind(Path(name), "a scenario"):
        raise InputError(f"'{name}' {why}")
    if kind_of(f"{name}.toml") == "file":
        raise InputError(
            f"'{name}' is neither a file nor a paper's scenario, but '{name}.toml' is a file; give that name"
        )
    author_year, _, wanted = name.partition("/")
    if author_year not in paper_names() and author_year not in papers():
        near = _near_file(name) or near_presets(name)
        raise InputError(f"'{name}' is neither a file nor a paper's scenario.{near}")
    found: Mapping[str, Scenario] = offered_by(author_year, "scenarios")
    if wanted in found:
        return found[wanted]
    if not found:
        raise InputError(f"'{author_year}' has no scenario.{near_presets(name)}")
    if not wanted:
        raise InputError(
            f"'{name}' is a paper; name one of its scenarios: {', '.join(f'{author_year}/{each}' for each in found)}."
        )
    raise InputError(f"'{name}': {author_year} has no scenario '{wanted}'.{near_presets(name)}")


def scenario_of(trace: xarray.Dataset) -> Scenario:
    """Return the scenario that a Trace carries.

    Parameters
    ----------
    trace : xarray.Dataset
        Result of `electrovib.simulate`, or a file of one that `electrovib.open_trace` has opened.

    Returns
    -------
    scenario : Scenario
        The scenario that was simulated.

    Raises
    ------
    InputError
        If it carries none, as a measurement, or if a model that it needs is missing.

    Examples
    --------
    >>> ev.scenario_of(ev.simulate("vezzoli_2014/fig6")).drive.high
    1000.0
    """
    if "scenario" not in trace.attrs:
        raise InputError("this Trace carries no scenario: it is a measurement, or was made by something else")
    content = without_schema(dict(structured(trace, "scenario", Mapping)))
    try:
        return read_part(Scenario, content)
    except InputError:
        needs = [
            _needs(kind.__name__, name, path, trace) for path, kind, name in missing_models(Scenario, content)
        ]
        refuse(needs)
        raise


def _needs(family: str, name: str, path: str, trace: xarray.Dataset) -> Problem:
    """State which model a Trace needs, where it was defined, and what to do."""
    defined = [each for each in models_of(trace) if (each["model"], each["family"]) == (name, family)]
    file = defined[0]["file"] if defined else ""
    where = f"; it was defined in {file} (SHA-256 {defined[0]['sha256'][:12]}...)" if file else ""
    return Problem(
        f"this Trace needs the {family} model '{name}', which is not part of electrovib{where}. Name its file before the"
        f" command, 'electrovib --models {file or 'FILE.py'} ...', or import it in Python. The numbers can be read without it:"
        " electrovib.open_trace",
        path=path,
    )


def models_of(trace: xarray.Dataset) -> list[dict[str, str]]:
    """Return the models of a Trace that are not part of electrovib."""
    found = structured(trace, OWN_MODELS, list) if OWN_MODELS in trace.attrs else []
    names = ("model", "family", "file", "sha256")
    if not all(
        isinstance(each, dict) and all(isinstance(each.get(name), str) for name in names) for each in found
    ):
        raise _damaged_attribute(OWN_MODELS, "it lists no models")
    return found


def changed_models(trace: xarray.Dataset, scenario: Scenario) -> list[str]:
    """List the files of own models that have changed since a Trace was computed."""
    before = {(each["family"], each["model"]): each["sha256"] for each in models_of(trace)}
    return [
        f"the model '{now['model']}' is not the one of this Trace: {now['file'] or 'its file'} has changed since, so the"
        " numbers may differ"
        for now in origins(scenario)
        if before.get((now["family"], now["model"]), now["sha256"]) != now["sha256"]
    ]


def sweep_of(trace: xarray.Dataset) -> tuple[dict[str, list[Any]], list[str]]:
    """Return the swept values of a Trace by dotted path, and its quantities; both are empty for a run."""
    axes = structured(trace, "over", Mapping) if "over" in trace.attrs else {}
    names = structured(trace, "quantities", list) if "quantities" in trace.attrs else []
    if not all(isinstance(values, list) and values for values in axes.values()):
        raise _damaged_attribute("over", "it lists no values")
    if not all(isinstance(name, str) for name in names):
        raise _damaged_attribute("quantities", "it lists no names")
    return dict(axes), names


def structured(trace: xarray.Dataset, name: str, kind: type[Any]) -> Any:
    """Read an attribute of a Trace that is written as JSON."""
    try:
        found = read_json(trace.attrs[name])
    except ValueError as error:
        raise _damaged_attribute(name, str(error)) from None
    if not isinstance(found, kind):
        raise _damaged_attribute(name, f"it holds a {type(found).__name__}")
    return found


def _damaged_attribute(name: str, why: str) -> InputError:
    return InputError(
        f"the attribute '{name}' of this Trace is damaged: {why[:120]}. Its numbers can still be used; to compute"
        " again, start from the scenario file"
    )


def without_schema(content: dict[str, Any]) -> dict[str, Any]:
    """Take the version of the schema out of the tables of a scenario."""
    schema = content.pop("schema", None)
    if schema != SCHEMA:
        raise InputError(
            f"schema = {repr(schema)[:60]}: this version reads 'schema = {SCHEMA}'; write it as the first line"
        )
    return content


NONE: Final[Mapping[str, str]] = {}
_PLAIN_SOURCES: Final = dict.fromkeys(
    ("friction.coefficient", "contact.area", "load.normal_force", "circuit.return_path.resistance"),
    "a choice",
)


@functools.cache
def plain() -> Scenario:
    """Return the default base of a preset: 0.5 N on 1 cm2, Coulomb friction with a coefficient of 0.5, 1 kohm."""
    return Scenario.model_validate({**Scenario.example, "sources": _PLAIN_SOURCES})


def preset(
    base: Scenario | str | None = None,
    *,
    title: str,
    changes: Mapping[str, Any],
    sources: Mapping[str, str] = NONE,
    unchanged: str = "",
) -> Scenario:
    """Make a ready-made scenario, with the source of each value, from another one; `plain` if `base` is absent.

    `sources` maps the path of a value, or of a table, to where it is from: the source of a table holds for those of its values
    that have none of their own. `unchanged` is the source of the unchanged values of the base; each keeps its own if absent.
    """
    start = plain() if base is None else read_scenario(base)
    known = {path.removesuffix(".model"): "" for path in changes} | dict(sources)
    known |= {path: sources[table] for path in known if (table := _nearest_table(path, sources)) is not None}
    put = Changed(start)
    content = put.within(changes, start)
    refuse(put.problems)
    beside = {path.rpartition(".")[0]: known[path] for path in changes if path in known}
    known |= {path: beside.get(path.rpartition(".")[0], "") for path in put.stored if path not in changes}
    offered = sources_of_offers(put)
    built = read_part(Scenario, content | {"title": title, "sources": {}})
    kept = {path: unchanged or source for path, source in start.sources.items()}
    paths = [path for path, _, _ in built.parameters()]
    if wrong := [
        path for path in sources if not any(f"{each}.".startswith(f"{path}.") for each in (*paths, *changes))
    ]:
        raise InputError(
            Problem(f"no parameter has this path.{nearest(path, paths)}", path=f"sources.{path}")
            for path in wrong
        )
    found = {}
    for path, value, _ in built.parameters():
        table = _nearest_table(path, known)
        if table is None:
            found[path] = kept.get(path, "")
        elif table == path or not is_default(built, path, value):
            found[path] = known[table] or offered.get(path, "")
    return built.model_copy(update={"sources": {path: source for path, source in found.items() if source}})


def _nearest_table(path: str, known: Mapping[str, str]) -> str | None:
    """Find the path itself, or the innermost table around it, among the entries."""
    parts = path.split(".")
    tables = (".".join(parts[:length]) for length in range(len(parts), -1, -1))
    return next((table for table in tables if table in known), None)
