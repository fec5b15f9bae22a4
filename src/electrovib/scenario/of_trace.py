"""The scenario that a Trace carries, and the models of a user that it needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError, Problem
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import missing_models, origins
from electrovib.core.parsing import read_json
from electrovib.scenario.experiment import Scenario
from electrovib.scenario.files import read_part
from electrovib.scenario.toml import SCHEMA

if TYPE_CHECKING:
    import xarray


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
    """
    if "scenario" not in trace.attrs:
        raise InputError("this Trace carries no scenario: it is a measurement, or was made by something else")
    content = without_schema(dict(structured(trace, "scenario", Mapping)))
    if missing := list(missing_models(Scenario, content)):
        raise InputError(_needs(family.__name__, name, path, trace) for path, family, name in missing)
    return read_part(Scenario, content)


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
