"""Design of a plate: thickness, material and drive within all limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError, Problem, gathered
from electrovib.core.paths import quantity_at
from electrovib.scenario import Source, read_scenario
from electrovib.study.check import LimitsSource, checked, declared_limits
from electrovib.study.perceive import perceive
from electrovib.study.plate.candidates import AS_IT_IS, PlateCandidate, Plates
from electrovib.study.plate.choice import RELAXED, best_of, gains_of
from electrovib.study.plate.material import layer_of, members_of
from electrovib.study.plate.objectives import read_objectives
from electrovib.study.plate.result import PlateDesign
from electrovib.study.sweep import parse_over

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.study.check import DeclaredLimit
    from electrovib.study.plate.objectives import Objective

POINTS: Final = 5
"""Values of a parameter in a round of refinement, between the neighbours of the best one."""
ROUNDS: Final = 3
"""Rounds of refinement by default."""
MOST_ROUNDS: Final = 20
MAXIMISED: Final = ("mean electrostatic_force",)
MINIMISED: Final = ("peak voltage",)
_EXAMPLE = "over = {'stack.insulator.thickness': [...]}, --over stack.insulator.thickness=1um:20um:10log"


def find_plate(
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
    """Compare every combination of materials and parameters with all limits, as `electrovib.design_plate` describes."""
    given = read_scenario(scenario, changes=set)
    problems: list[str | Problem] = []
    axes: dict[str, Any] = {}
    members: dict[str, Scenario] = {AS_IT_IS: given}
    declared: dict[str, DeclaredLimit] = {}
    chosen = ""
    with gathered(problems):
        axes = dict(over) if isinstance(over, Mapping) else dict(parse_over(given, over))
    with gathered(problems):
        if materials:
            chosen = layer_of(given, layer)
            members = members_of(given, chosen, materials)
        elif layer:
            raise InputError("layer: names the layer whose material is varied; add the materials, or omit it")
    with gathered(problems):
        declared = declared_limits(given, limits)
    objectives: tuple[Objective, ...] = ()
    with gathered(problems):
        objectives = read_objectives(given, tuple(axes), maximise, minimise)
    if not axes and len(members) < 2 and not problems:
        problems.append(f"over: name at least one parameter that is varied, for instance {_EXAMPLE}")
    if not 0 <= refine <= MOST_ROUNDS:
        problems.append(f"refine = {refine}: expected a whole number of rounds from 0 to {MOST_ROUNDS}")
    if problems:
        raise InputError(problems)
    plates = Plates(
        members=members, declared=declared, objectives=objectives, perceived=_is_calibrated(given)
    )
    found = plates.solve(axes, materials=tuple(members), progress=progress)
    values = {path: np.unique([each.at[path] for each in found]) for path in axes}
    _refined(plates, found, values, rounds=refine)
    best = best_of(found, objectives)
    chosen_plate = None if best is None else plates.scenario(best.material, best.at)
    return PlateDesign(
        scenario=given,
        layer=chosen,
        axes=values,
        units={path: quantity_at(given, path).unit for path in axes},
        objectives=objectives,
        candidates=tuple(found),
        check=None
        if chosen_plate is None
        else checked(chosen_plate, limits=limits, name="the best candidate"),
        notes=tuple(_notes(given, axes, chosen, chosen_plate)),
    )


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
    return ". ".join(
        filter(None, [f"The best plate: {found.answer}", found.to_measure, "This forbids no candidate."])
    )


def _notes(scenario: Scenario, axes: Mapping[str, Any], layer: str, best: Scenario | None) -> list[str]:
    """State what was not compared, and what was replaced."""
    notes: list[str] = []
    if best is not None and not _is_calibrated(scenario):
        notes.append(_felt(best))
    notes.append(
        "The best plate, and what a less strict limit admits, are those of these candidates; more rounds of refine add candidates"
        " between them."
    )
    notes.append(
        "A field above an unverified breakdown strength forbids a candidate here, and the row states the status; the field of"
        " field emission is cited from memory and forbids nothing."
    )
    if layer and scenario.stack.layers[layer].breakdown_field is not None:
        notes.append(
            f"stack.{layer}.breakdown_field belongs to the material of the scenario and was omitted for the others."
        )
    for path in axes:
        name = path.split(".")[1] if path.startswith("stack.") and path.endswith(".permittivity") else ""
        substance = scenario.stack.layers[name].material.substance if name in scenario.stack.layers else None
        if substance is not None:
            notes.append(
                f"{path} is varied while the breakdown strength remains that of {substance}; declare"
                f" stack.{name}.breakdown_field for another material."
            )
    return notes


def _refined(plates: Plates, found: list[PlateCandidate], axes: Mapping[str, Real], *, rounds: int) -> None:
    """Add candidates around the best one, and around the best one with the binding limit relaxed."""
    varied = {path: values for path, values in axes.items() if len(values) > 1}
    if not varied:
        return
    objectives = plates.objectives
    for _ in range(rounds):
        _add_around(plates, found, best_of(found, objectives), axes)
    best = best_of(found, objectives)
    gains = [] if best is None else gains_of(best, found, objectives)
    names = [gain.limits[0] for gain in gains[:1] if len(gain.limits) == 1]
    for name in names:
        for _ in range(rounds):
            relaxed = best_of(found, objectives, relaxed=[name], factor=RELAXED)
            _add_around(plates, found, relaxed, axes)


def _add_around(
    plates: Plates, found: list[PlateCandidate], centre: PlateCandidate | None, axes: Mapping[str, Real]
) -> None:
    """Solve the combinations of values between the neighbours of a candidate, and add those that are new."""
    if centre is None:
        return
    over = {
        path: _between(
            np.unique([each.at[path] for each in found if each.material == centre.material]),
            centre.at[path],
            geometric=_is_geometric(values),
        )
        for path, values in axes.items()
    }
    known = {tuple(each.at.values()) for each in found if each.material == centre.material}
    added = plates.solve(over, materials=[centre.material], refined=True)
    found += [each for each in added if tuple(each.at.values()) not in known]


def _between(values: Real, centre: float, *, geometric: bool) -> Real:
    """Return a value, its neighbours, and one value between each two of them; the value alone where there is no other."""
    place = int(np.argmin(np.abs(values - centre)))
    low, high = float(values[max(place - 1, 0)]), float(values[min(place + 1, len(values) - 1)])

    def middle(one: float, other: float) -> float:
        return float(np.sqrt(one * other)) if geometric else (one + other) / 2

    return np.unique([low, middle(low, centre), centre, middle(centre, high), high])


def _is_geometric(values: Real) -> bool:
    """Return whether values are above 0 and evenly spaced in their logarithm."""
    if len(values) < 3 or float(np.min(values)) <= 0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))
