"""Design of a plate: combinations of thickness, material and drive within all limits, refined around the best ones."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError, Problem, gathered, refuse
from electrovib.core.paths import quantity_at
from electrovib.physics.limits import SWITCH_ON, WORDS, Limits, limited, unit_of_limit
from electrovib.physics.safety import FILM
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.studies.check import (
    CheckRow,
    DeclaredLimit,
    LimitsSource,
    checked,
    declared_limits,
    result,
    several_limits,
)
from electrovib.studies.check.amplifier import asked_rows
from electrovib.studies.check.function import asked_values
from electrovib.studies.compare.materials import layer_of_plate, named_materials, with_material
from electrovib.studies.design.plate.result import RELAXED, PlateDesign, best_of, gains_of
from electrovib.studies.perceive import perceive, verdict
from electrovib.studies.sweep import Case, parse_over, read_quantities, sweep_cases

FELT: Final = "detection level"
PERCEIVED: Final = "threshold over felt amplitude"
"""Quantity of the row of perception: 1 at the threshold."""
LIMITED: Final = {result.limited_quantity(name): name for name in WORDS}
"""Quantity to the name of its limit."""
QUANTITY, LARGEST, PARAMETER = "quantity", "largest value", "parameter"
_FELT_STATES: Final = {"detectable": result.PASS, "not detectable": result.FAIL}


@dataclass(frozen=True, kw_only=True)
class Objective:
    """What is maximised or minimised: ``"mean electrostatic_force"``, ``"peak voltage"`` or a dotted path.

    `sign` is -1 if the largest value is the best, 1 if the smallest is. `kind` is `QUANTITY` of a sweep,
    `LARGEST` value that a limit is compared with, or swept `PARAMETER`.
    """

    name: str
    unit: str
    sign: int
    kind: str

    @property
    def goal(self) -> str:
        """The word ``largest`` or ``smallest``."""
        return "largest" if self.sign < 0 else "smallest"

    def cost(self, candidate: PlateCandidate) -> float:
        """Return the value of a candidate, negative where the largest is the best; NaN where it is not known."""
        return self.sign * candidate.values[self.name]


@dataclass(frozen=True, kw_only=True)
class PlateCandidate:
    """One plate with its drive.

    - `material`: of the insulator; empty where the scenario keeps its own.
    - `at`: dotted path to value in SI; `values`: objective to its value, NaN where it is not known.
    - `rows`: comparison with every limit; one that `forbids` excludes the candidate.
    - `diagnostics`: those of the run that are warnings and belong to no row.
    - `refined`: whether it was added between the values that were asked for.
    """

    material: str
    at: Mapping[str, float]
    values: Mapping[str, float]
    rows: tuple[CheckRow, ...]
    diagnostics: tuple[Diagnostic, ...]
    refined: bool = False

    @functools.cached_property
    def forbidden_by(self) -> tuple[str, ...]:
        """Quantities whose limit is exceeded."""
        return tuple(row.quantity for row in self.rows if row.forbids)

    @property
    def is_allowed(self) -> bool:
        """Whether no limit is exceeded."""
        return not self.forbidden_by

    def is_allowed_with(self, relaxed: Collection[str], factor: float) -> bool:
        """Return whether no limit is exceeded when some are multiplied by a factor; an infinite one omits them."""
        return all(
            row.quantity in relaxed
            and (math.isinf(factor) or (row.margin is not None and row.margin * factor >= 1))
            for row in self.rows
            if row.forbids
        )

    @functools.cached_property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on breakdown strengths that are unverified or may not apply to this layer, one for each layer."""
        films = {row.remedy: row.text for row in self.rows if row.remedy and row.quantity.startswith(FILM)}
        return tuple(films.values())


@dataclass(frozen=True, kw_only=True)
class Plates:
    """What the candidates have in common; `perceived` states whether a detection threshold is calibrated."""

    members: Mapping[str, Scenario]
    declared: Mapping[str, DeclaredLimit]
    objectives: tuple[Objective, ...]
    perceived: bool

    def solve(
        self,
        over: Mapping[str, Sequence[float] | Real],
        *,
        materials: Sequence[str],
        refined: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> list[PlateCandidate]:
        """Solve every combination of materials and values, the last path running fastest."""
        found: list[PlateCandidate] = []
        names = [each.name for each in self.objectives if each.kind == QUANTITY]
        names += [FELT] if self.perceived and FELT not in names else []
        names = names or ["mean electrostatic_force"]  # a run is needed for the limits
        for place, material in enumerate(materials):

            def counted(done: int, of: int, before: int = place) -> None:
                if progress is not None:
                    progress(before * of + done, len(materials) * of)

            judged = self.members[material].model_copy(update={"limits": self._judged_limits()})
            cases = sweep_cases(judged, over, quantity=names, progress=counted).cases
            found += [self._candidate(material, case, refined=refined) for case in cases]
        return found

    def scenario(self, material: str, at: Mapping[str, float]) -> Scenario:
        """Return the scenario of a candidate, with its own limits."""
        return self.members[material].replace(dict(at))

    def _judged_limits(self) -> Limits:
        """Return limits with which a run judges every quantity that a row shows, the largest possible where none is declared.

        Root mean squares and the rate of change, which take a run of their own, need a limit or an objective.
        """
        asked = {LIMITED[each.name] for each in self.objectives if each.kind == LARGEST}
        values = {}
        for name in WORDS:
            if name in self.declared:
                values[name] = self.declared[name].value
            elif name in asked or name not in result.ONLY_DECLARED:
                values[name] = limited(name).high
        return Limits(**values)

    def _candidate(self, material: str, case: Case, *, refined: bool) -> PlateCandidate:
        rows = self._rows(material, case)
        by_quantity = {row.quantity: row.value for row in rows}
        known = dict(case.at) | dict(case.values) | by_quantity
        values = {each.name: known[each.name] for each in self.objectives}
        judged = set(by_quantity) | {name.replace("_", " ") for name in WORDS}
        return PlateCandidate(
            material=material,
            at=dict(case.at),
            values={name: math.nan if value is None else value for name, value in values.items()},
            rows=rows,
            diagnostics=tuple(
                each
                for each in case.diagnostics
                if each.state == "warning" and each.name.removesuffix(SWITCH_ON) not in judged
            ),
            refined=refined,
        )

    def _rows(self, material: str, case: Case) -> tuple[CheckRow, ...]:
        """Compare a case with declared limits, breakdown and perception."""
        declared, largest, diagnostics = self.declared, _largest(case.diagnostics), case.diagnostics
        names = [
            name for name in WORDS if name in largest or name in declared or name not in result.ONLY_DECLARED
        ]
        elsewhere, candidate = {}, self.members[material]
        not_judged = declared.keys() - largest.keys()  # limits that a run does not judge
        may_be_limited = candidate.circuit.supply.is_limited or any(
            at.startswith("circuit.") for at in case.at
        )
        if not_judged or may_be_limited:
            candidate = self.scenario(material, case.at)
        if not_judged:
            limits = Limits(**{name: each.value for name, each in declared.items()})
            elsewhere = {row.quantity: row for row in checked(candidate, limits=[limits]).rows}
        rows = [
            elsewhere[result.limited_quantity(name)]
            if name in declared and name not in largest
            else result.limit_row(name, largest.get(name), declared.get(name))
            for name in names
        ]
        rows += [result.breakdown_row(each) for each in diagnostics if each.name.startswith(result.BREAKDOWN)]
        if candidate.circuit.supply.is_limited:
            rows += asked_rows(candidate, asked_values(candidate))
        if self.perceived:
            person = self.members[material].perception
            assert person is not None
            rows.append(_felt_row(case.values[FELT], person.threshold_uncertainty))
        return tuple(rows)


def _largest(diagnostics: Sequence[Diagnostic]) -> dict[str, float | None]:
    """Return the largest value of each limited quantity that was judged; infinite without a bound, None if unknown."""
    by_title = {name.replace("_", " "): name for name in WORDS}
    found: dict[str, float | None] = {}
    for each in diagnostics:
        name = by_title.get(each.name.removesuffix(SWITCH_ON))
        if name is None:
            continue
        value = math.inf if each.value is None and each.state == "warning" else each.value
        held = found.get(name)
        if name not in found or held is None or (value is not None and value > held):
            found[name] = value
    return found


def _felt_row(level: float, uncertainty: float | None) -> CheckRow:
    """Return the row of perception: a change of friction below the detection threshold forbids the candidate."""
    is_known = not math.isnan(level)
    found = verdict(sensation=level if is_known else None, uncertainty=uncertainty)
    return CheckRow(
        quantity=PERCEIVED,
        value=float(10 ** (-level / 20)) if is_known else None,
        limit=1.0,
        unit="1",
        source="perception.threshold of the scenario",
        state=_FELT_STATES.get(found, result.UNKNOWN),
        text=f"the change of friction is {level:.3g} dB above the detection threshold: {found}",
    )


AS_IT_IS: Final = ""
"""Name of the material where the scenario keeps its own."""
ROUNDS: Final = 3
"""Rounds of refinement by default."""
MOST_ROUNDS: Final = 20
MAXIMISED: Final = ("mean electrostatic_force",)
MINIMISED: Final = ("peak voltage",)
_EXAMPLE = "over = {'stack.insulator.thickness': [...]}, --over stack.insulator.thickness=1um:20um:10log"


def plan_plate(
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
        Candidates with every margin, the Pareto set, and ``sentences``: the best plate, what binds there, and what a less
        strict limit would gain. `electrovib.save` writes it: ``.csv`` with every candidate and every limit, ``.json``,
        ``.html`` with figure and tables, ``.png`` or ``.svg``, the figure.

    Raises
    ------
    InputError
        Every mistake at once.
    """
    given = read_scenario(scenario, changes=set)
    problems: list[str | Problem] = []
    axes: dict[str, Any] = {}
    members: dict[str, Scenario] = {AS_IT_IS: given}
    chosen = ""
    with gathered(problems):
        axes = dict(parse_over(given, over))
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
    refuse(problems)
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
        limits=several_limits(limits),
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
    refuse(problems)
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
    sentences = (f"The best plate: {found.headline}", found.to_measure, "This forbids no candidate.")
    return ". ".join(filter(None, sentences))


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
