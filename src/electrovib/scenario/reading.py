"""Scenarios from TOML, papers, tables and Traces."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.core.changes import stored_path
from electrovib.core.discovery import name_of_today, paper
from electrovib.core.errors import LONGEST_QUOTED, InputError, nearest, shortened
from electrovib.core.files import note_input
from electrovib.core.parsing import read_json, read_toml
from electrovib.core.tables import put
from electrovib.core.trace import is_trace
from electrovib.data.traces import is_trace_file, open_if_trace
from electrovib.scenario.experiment import SCHEMA, Scenario
from electrovib.scenario.files import current_tables, read_part

if TYPE_CHECKING:
    import xarray

DROPPED: Final = ("ridge_share",)
"""Parameters of a contact that older Traces carry and that changed no result but a signal of their own."""
DEFAULT: Final = "vezzoli_2014/fig6"
Source: TypeAlias = "str | Path | Mapping[str, Any] | Scenario | xarray.Dataset"
"""What a scenario can be read from."""


def read_scenario(
    source: Source, *, changes: Mapping[str, Any] | None = None, before_sweep: bool = False
) -> Scenario:
    """Read a scenario from whatever has one.

    Parameters
    ----------
    source : str, Path, mapping, Scenario or xarray.Dataset
        A paper's scenario such as ``"vezzoli_2014/fig6"``, a TOML file, nested tables, a Scenario, or a Trace: its
        file (``.nc``, ``.csv``, ``.mat``) or itself, which carries the scenario it was computed from.
    changes : mapping of str to value, optional
        Dotted path to value, put into the scenario; a file named here is looked for from the working folder.
    before_sweep : bool
        Of a sweep give the scenario from which it began; else a sweep is refused, which is many scenarios.

    Returns
    -------
    Scenario
        The one.

    Raises
    ------
    InputError
        Every mistake of the file at once; if the source has no scenario, or many.
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
        note_input(path)
        if not paper_of_preset(source):
            return _read(_tables(path), changes, path.parent)
        scenario = paper_scenario(str(source))
    return scenario.replace(changes) if changes else scenario


load = read_scenario
"""The name under which users know `read_scenario`."""


def _of_trace(source: Any, *, before_sweep: bool) -> Scenario:
    """Give back the scenario of a run; that of a sweep would leave out what it goes over."""
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
    """Build a scenario; changes may mend what is wrong in the tables."""
    content = current_tables(Scenario, _without_schema(content))
    try:
        scenario = _with_current_sources(read_part(Scenario, content, folder=folder))
    except InputError:
        if not changes:
            raise
        put(content, _beside(changes, folder), strict=False)
        return read_part(Scenario, content, folder=folder)
    return scenario.replace(changes) if changes else scenario


def _beside(changes: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Write files that the caller names as seen from the scenario's folder."""
    found = dict(changes)
    for path, value in changes.items():
        if path.rpartition(".")[2] == "file" and isinstance(value, str):
            found[path] = os.path.relpath(value, folder)
    return found


def scenario_of(trace: xarray.Dataset) -> Scenario:
    """Give back the scenario a Trace carries.

    Raises
    ------
    InputError
        If it carries none, as a measurement does.
    """
    if "scenario" not in trace.attrs:
        raise InputError("this Trace carries no scenario: it is a measurement, or was made by something else")
    content = _without_schema(dict(structured(trace, "scenario", Mapping)))
    if isinstance(contact := content.get("contact"), dict):
        for parameter in DROPPED:
            contact.pop(parameter, None)
    return _with_current_sources(read_part(Scenario, content))


def _with_current_sources(scenario: Scenario) -> Scenario:
    """Return a scenario whose sources are given by the names that parameters have today."""
    sources = {stored_path(scenario, path): source for path, source in scenario.sources.items()}
    return scenario if sources == scenario.sources else scenario.model_copy(update={"sources": sources})


def sweep_of(trace: xarray.Dataset) -> tuple[dict[str, list[Any]], list[str]]:
    """Give back the values that a swept Trace runs over, by dotted path, and its quantities; both empty for a run.

    Raises
    ------
    InputError
        If what it carries is damaged.
    """
    axes = structured(trace, "over", Mapping) if "over" in trace.attrs else {}
    names = structured(trace, "quantities", list) if "quantities" in trace.attrs else []
    if not all(isinstance(values, list) and values for values in axes.values()):
        raise _damaged_attribute("over", "it lists no values")
    if not all(isinstance(name, str) for name in names):
        raise _damaged_attribute("quantities", "it lists no names")
    if axes and "scenario" in trace.attrs:
        scenario = scenario_of(trace)
        axes = {stored_path(scenario, path): values for path, values in axes.items()}
    return dict(axes), names


def structured(trace: xarray.Dataset, name: str, kind: type[Any]) -> Any:
    """Read an attribute of a Trace that is written as JSON.

    Raises
    ------
    InputError
        If it is damaged or holds something of another kind.
    """
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


def _tables(path: Path) -> dict[str, Any]:
    try:
        if path.exists() and not path.is_file():
            what = "a folder" if path.is_dir() else "not an ordinary file"
            raise InputError(f"is {what}; give a .toml file or a paper, for instance {DEFAULT}", path=path)
        text = path.read_bytes().decode("utf-8-sig")  # editors of Windows begin with a byte-order mark
    except OSError as error:
        raise InputError(
            f"{error.strerror or error}. Give a .toml file or a paper, for instance {DEFAULT}", path=path
        ) from None
    except UnicodeDecodeError:
        raise InputError("not a text in UTF-8; a scenario is TOML, saved as UTF-8", path=path) from None
    if not text.strip():
        raise InputError(
            f"the file is empty. 'electrovib init {DEFAULT}' prints one to start from", path=path
        )
    try:
        return read_toml(text)
    except ValueError as error:
        raise InputError(f"not valid TOML: {error}", path=path) from None


def _without_schema(content: dict[str, Any]) -> dict[str, Any]:
    schema = content.pop("schema", None)
    if schema != SCHEMA:
        raise InputError(
            f"schema = {repr(schema)[:60]}: this version reads 'schema = {SCHEMA}'; write it as the first line"
        )
    return content


def paper_of_preset(source: object) -> str:
    """Name the paper, ``author_year``, whose ready-made scenario a source asks for; empty for a scenario of one's own."""
    path = Path(source) if isinstance(source, (str, Path)) else None
    if path is None or path.suffix == ".toml" or is_trace_file(path) or path.exists():
        return ""
    return str(source).partition("/")[0]


def paper_scenario(name: str) -> Scenario:
    """Find a paper's scenario by ``author_year/name``.

    Raises
    ------
    InputError
        With the nearest name.
    """
    author_year, _, wanted = name.partition("/")
    module = paper(author_year)
    wanted = name_of_today(module, wanted)
    found: Mapping[str, Scenario] = module.scenarios() if hasattr(module, "scenarios") else {}
    if not found:
        raise InputError(f"'{author_year}' has no scenario")
    if wanted not in found:
        raise InputError(f"'{name}': {author_year} has no scenario '{wanted}'.{nearest(wanted, found)}")
    return found[wanted]
