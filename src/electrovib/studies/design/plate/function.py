"""Design of a plate: every combination of thickness, material and drive within all limits, refined around the best ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError, Problem, gathered
from electrovib.core.paths import quantity_at
from electrovib.physics.limits import unit_of_limit
from electrovib.scenario import Source, read_scenario
from electrovib.studies.check import LimitsSource, checked, declared_limits
from electrovib.studies.compare.materials import layer_of_plate, named_materials, with_material
from electrovib.studies.design.limits import several_limits
from electrovib.studies.design.plate.candidates import (
    LARGEST,
    LIMITED,
    PARAMETER,
    QUANTITY,
    Objective,
    PlateCandidate,
    Plates,
)
from electrovib.studies.design.plate.result import RELAXED, PlateDesign, best_of, gains_of
from electrovib.studies.perceive import perceive
from electrovib.studies.sweep import parse_over, read_quantities

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.studies.check import DeclaredLimit

AS_IT_IS: Final = ""
"""Name of the material where the scenario keeps its own."""
ROUNDS: Final = 3
"""Rounds of refinement by default."""
MOST_ROUNDS: Final = 20
MAXIMISED: Final = ("mean electrostatic_force",)
MINIMISED: Final = ("peak voltage",)
_EXAMPLE = "over = {'stack.insulator.thickness': [...]}, --over stack.insulator.thickness=1um:20um:10log"


def design_plate(
    scenario: Source,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real] = (),
    *,
    materials: Sequence[str] = (),
    layer: str = "",
    maximise: Sequence[str] = MAXIMISED,
    minimise: Sequence[str] = MINIMISED,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    refine: int = ROUNDS,
    progress: Callable[[int, int], None] | None = None,
) -> PlateDesign:
    """Find the plate and the drive that give the most force within breakdown, current and perception, and the Pareto set.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    over : sequence of str, or mapping of str to sequence of float
        Parameters that are varied: ``"stack.insulator.thickness=1um:20um:10log"``, or dotted path to values in SI or with
        units; thickness, permittivity (``stack.insulator.material.permittivity``), amplitude, frequency. Every
        combination is a candidate.
    materials : sequence of str
        Materials of the insulator, each combined with all values: ``["silica", "parylene C"]``; that of the scenario if
        empty.
    layer : str
        Layer whose material is varied; the only one of the plate if empty.
    maximise, minimise : sequence of str
        Objectives: quantities as for `electrovib.sweep`, the largest values that `electrovib.check` compares with limits
        (``"peak voltage"``, ``"peak current"``, ``"charge"``, ``"stored energy"``, ``"peak body current"``), or varied
        paths. The first one decides which candidate is the best.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario, as for `electrovib.check`; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    refine : int
        Rounds in which candidates are added around the best one, and around the best one with the binding limit relaxed by
        10 %; each halves the distance of the values there. 0 keeps to the given values.
    progress : callable, optional
        Function of the number of candidates that are solved and of all.

    Returns
    -------
    PlateDesign
        Candidates with every margin, the Pareto set, and ``answer``: the best plate, what binds there, and what a less
        strict limit would gain. `electrovib.save` writes it: ``.csv`` with every candidate and every limit, ``.json``,
        ``.html`` with figure and tables, ``.png`` or ``.svg``, the figure.

    Raises
    ------
    InputError
        Every mistake at once.
    BudgetError
        If all candidates would take more time or memory than `electrovib.budget` allows.

    Notes
    -----
    A candidate is forbidden by a declared limit that it exceeds, by a field above the strength of its film (also an
    unverified one, which the row states), by Paschen's law in the gap, and where the scenario calibrates a detection
    threshold, by a change of friction below it. The best candidate is compared with all limits again by `electrovib.check`.
    """
    given = read_scenario(scenario, changes=set)
    problems: list[str | Problem] = []
    axes: dict[str, Any] = {}
    members: dict[str, Scenario] = {AS_IT_IS: given}
    declared: dict[str, DeclaredLimit] = {}
    objectives: tuple[Objective, ...] = ()
    chosen = ""
    with gathered(problems):
        axes = dict(over) if isinstance(over, Mapping) else dict(parse_over(given, over))
    with gathered(problems):
        if materials:
            chosen = layer_of_plate(given, layer)
            named = named_materials(materials)
            members = {shown: with_material(given, chosen, name) for shown, name in named.items()}
        elif layer:
            raise InputError("layer: names the layer whose material is varied; add the materials, or omit it")
    with gathered(problems):
        declared = declared_limits(given, limits)
    with gathered(problems):
        objectives = _objectives(given, tuple(axes), maximise, minimise)
    if not axes and len(members) < 2 and not problems:
        problems.append(f"over: name at least one parameter that is varied, for instance {_EXAMPLE}")
    if not 0 <= refine <= MOST_ROUNDS:
        problems.append(f"refine = {refine}: expected a whole number of rounds from 0 to {MOST_ROUNDS}")
    if problems:
        raise InputError(problems)
    is_calibrated = _is_calibrated(given)
    plates = Plates(members=members, declared=declared, objectives=objectives, perceived=is_calibrated)
    found = plates.solve(axes, materials=tuple(members), progress=progress)
    values = {path: np.unique([each.at[path] for each in found]) for path in axes}
    _refine(plates, found, values, rounds=refine)
    best = best_of(found, objectives)
    plate = None if best is None else plates.scenario(best.material, best.at)
    return PlateDesign(
        base=given,
        layer=chosen,
        axes=values,
        units={path: quantity_at(given, path).unit for path in axes},
        objectives=objectives,
        candidates=tuple(found),
        check=None if plate is None else checked(plate, limits=limits, name="the best candidate"),
        notes=(*([] if plate is None or is_calibrated else [_felt(plate)]), *_notes(given, axes, chosen)),
        limits=several_limits(limits, given),
    )


def _objectives(
    scenario: Scenario, paths: Sequence[str], maximise: Sequence[str], minimise: Sequence[str]
) -> tuple[Objective, ...]:
    """Read the names of objectives, those to be maximised first: quantities, those of `LIMITED`, or swept paths."""
    found: dict[str, Objective] = {}
    problems: list[str | Problem] = []
    for option, sign, names in (("maximise", -1, maximise), ("minimise", 1, minimise)):
        for text in [names] if isinstance(names, str) else names:
            try:
                objective = _objective(scenario, paths, " ".join(text.split()), sign)
            except InputError as error:
                problems += [f"{option}: {problem}" for problem in error.problems]
                continue
            if objective.name in found:
                problems.append(f"{option}: '{objective.name}' is an objective already; name it once")
            found[objective.name] = objective
    if problems:
        raise InputError(problems)
    if not found:
        raise InputError("name at least one objective, for instance maximise = 'mean electrostatic_force'")
    return tuple(found.values())


def _objective(scenario: Scenario, paths: Sequence[str], name: str, sign: int) -> Objective:
    if name in LIMITED:
        return Objective(name=name, unit=unit_of_limit(LIMITED[name]), sign=sign, kind=LARGEST)
    if name in paths:
        return Objective(name=name, unit=quantity_at(scenario, name).unit, sign=sign, kind=PARAMETER)
    if "." in name:
        raise InputError(
            f"'{name}' is not varied; the parameters that are varied are {', '.join(paths) or 'none'}"
        )
    ((named, (unit, _)),) = read_quantities(scenario, [name]).units.items()
    return Objective(name=named, unit=unit, sign=sign, kind=QUANTITY)


def _is_calibrated(scenario: Scenario) -> bool:
    """Return whether a level above the detection threshold can be computed."""
    person = scenario.perception
    return (
        person is not None
        and person.threshold is not None
        and (person.compliance is not None or scenario.finger is not None)
    )


def _felt(best: Scenario) -> str:
    """State whether the best plate is felt, from published thresholds, which forbid no candidate."""
    try:
        found = perceive(best)
    except ElectrovibError as error:
        return f"It is not judged whether the best plate is felt: {error}"
    told = (f"The best plate: {found.answer}", found.to_measure, "This forbids no candidate.")
    return ". ".join(filter(None, told))


def _notes(scenario: Scenario, axes: Mapping[str, Any], layer: str) -> list[str]:
    """State what was not compared, and what was replaced."""
    notes = [
        "The best plate, and what a less strict limit admits, are those of these candidates; more rounds of refine add candidates"
        " between them.",
        "A field above an unverified breakdown strength forbids a candidate here, and the row states the status; the field of"
        " field emission is cited from memory and forbids nothing.",
    ]
    layers = scenario.stack.layers
    if layer and layers[layer].breakdown_field is not None:
        notes.append(
            f"stack.{layer}.breakdown_field belongs to the material of the scenario and was omitted for the others."
        )
    for path in axes:
        name = path.split(".")[1] if path.startswith("stack.") and path.endswith(".permittivity") else ""
        substance = layers[name].material.substance if name in layers else None
        if substance is not None:
            notes.append(
                f"{path} is varied while the breakdown strength remains that of {substance}; declare"
                f" stack.{name}.breakdown_field for another material."
            )
    return notes


def _refine(plates: Plates, found: list[PlateCandidate], axes: Mapping[str, Real], *, rounds: int) -> None:
    """Add candidates around the best one, and around the best one with the binding limit relaxed."""
    if all(len(values) < 2 for values in axes.values()):
        return
    objectives = plates.objectives
    for _ in range(rounds):
        _add_around(plates, found, best_of(found, objectives), axes)
    best = best_of(found, objectives)
    gains = [] if best is None else gains_of(best, found, objectives)
    if gains and len(gains[0].limits) == 1:
        for _ in range(rounds):
            relaxed = best_of(found, objectives, relaxed=gains[0].limits, factor=RELAXED)
            _add_around(plates, found, relaxed, axes)


def _add_around(
    plates: Plates, found: list[PlateCandidate], centre: PlateCandidate | None, axes: Mapping[str, Real]
) -> None:
    """Solve the combinations of values between the neighbours of a candidate, and add those that are new."""
    if centre is None:
        return
    alike = [each for each in found if each.material == centre.material]
    over = {
        path: _between(np.unique([each.at[path] for each in alike]), centre.at[path], like=values)
        for path, values in axes.items()
    }
    known = {tuple(each.at.values()) for each in alike}
    added = plates.solve(over, materials=[centre.material], refined=True)
    found += [each for each in added if tuple(each.at.values()) not in known]


def _between(values: Real, centre: float, *, like: Real) -> Real:
    """Return a value, its neighbours, and one value between each two of them, spaced like the values asked for."""
    place = int(np.argmin(np.abs(values - centre)))
    low, high = float(values[max(place - 1, 0)]), float(values[min(place + 1, len(values) - 1)])
    steps = np.diff(np.log(like)) if len(like) > 2 and like[0] > 0 else np.array([0.0, 1.0])
    if np.ptp(steps) <= 1e-6 * abs(steps[0]):  # evenly in their logarithm
        return np.unique([low, np.sqrt(low * centre), centre, np.sqrt(centre * high), high])
    return np.unique([low, (low + centre) / 2, centre, (centre + high) / 2, high])
