"""What candidates predict of a measurement over what was not printed, and what is predicted without physics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.discovery import find_members, offers
from electrovib.core.errors import ElectrovibError, InputError, computed_or_refused, in_short
from electrovib.core.model import Model
from electrovib.core.own_models import family_of
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.quantity import Quantity
from electrovib.core.tables import derived_at
from electrovib.scenario import Scenario
from electrovib.scenario.space.reading import read_space
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.population.columns import check_values, with_columns
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.prepare import prepare
from electrovib.studies.evidence.measurement import Measurement, divisor
from electrovib.studies.evidence.standing import DECADE, LEVEL

DRAWS: Final = 64
"""Draws of what was not printed, by default."""
WIDTHS: Final = (1.0, 0.5, 2.0)
"""Widths of the ranges of what was not printed, over the stated one, with which predictions are made."""
NUMBERS: Final = 25.0
"""Numbers that are held for one draw at one point, about, while a law is computed."""
SAME: Final = 1e-12
"""Relative difference up to which a number computed among others is that of the same set-up alone."""
SKIN: Final = "material"
"""Last part of a path whose candidates are the skins that papers offer; other paths have the members of their family."""


@dataclass(frozen=True)
class ModelPrediction:
    """Values that a candidate gives at the points of a measurement (draws, points), in the unit of the measurement.

    `narrow`, `wide`: the same where every range of what was not printed has half and twice its width; None where the
    candidate gives no number there.
    """

    model: str
    values: Real
    narrow: Real | None = None
    wide: Real | None = None


def candidates(measured: Measurement) -> dict[str, Any]:
    """Return the models that a measurement judges, by name, each as the content of its place in the scenario."""
    if measured.judges.rpartition(".")[2] == SKIN:
        return {name: skin.material for name, skin in offers(("skins",)).items() if skin.reproduces_force}
    own = judged_model(measured)
    found: dict[str, Any] = {}
    for name in find_members(family_of(type(own))):
        found[name] = own if name == type(own).__name__ else {"model": name}
    return found


def judged_model(measured: Measurement) -> Model:
    """Return the model of the set-up in the place that is judged."""
    own: Any = measured.scenario
    try:
        for part in measured.judges.split("."):
            own = own[int(part)] if isinstance(own, tuple) else getattr(own, part)
    except (AttributeError, LookupError, ValueError):
        own = None
    if not isinstance(own, Model):
        raise InputError(
            f"judges = '{measured.judges}': the set-up has no model there, as at force, contact or friction"
        )
    return own


def predict(
    measured: Measurement, *, n: int = DRAWS, seed: int = 0
) -> tuple[list[ModelPrediction], dict[str, str]]:
    """Compute what every candidate predicts, and give the reason for each that cannot."""

    def compute(name: str, content: Any) -> ModelPrediction:
        return prediction(measured, name, content, n=n, seed=seed)

    found, refused = computed_or_refused(candidates(measured), compute, reason=in_short)
    return list(found.values()), refused


def prediction(measured: Measurement, name: str, content: Any, *, n: int, seed: int) -> ModelPrediction:
    """Compute the measured quantity for every draw and point (n, points), with ranges as stated and of other widths."""
    if name in measured.made:
        raise InputError("it was made from these numbers")
    scenario, tables = set_up(measured, name, content)
    draws = read_space(scenario, {"space": tables}).draw(seed, 0, n) if tables else {}
    together = {
        path: np.tile(column, len(WIDTHS))  # lists of values stay
        if "values" in tables[path]
        else np.concatenate([_of_width(column, each, quantity_at(scenario, path)) for each in WIDTHS])
        for path, column in draws.items()
    }
    try:
        found = values_of(measured, scenario, together, len(WIDTHS) * n)
    except ElectrovibError:
        found = values_of(measured, scenario, draws, n)
    stated, *others = np.split(found, len(found) // n)
    if not np.all(np.isfinite(stated)):
        quantity = measured.title if callable(measured.quantity) else measured.quantity
        raise InputError(f"{quantity}: {name} gives no number for some of the draws")
    return ModelPrediction(name, stated, *(each if np.all(np.isfinite(each)) else None for each in others))


def _of_width(column: Real, factor: float, quantity: Quantity) -> Real:
    """Move draws away from their median, in the logarithm where all are positive, within the range of the parameter."""
    middle = np.median(column)
    if np.min(column) > 0:
        return np.clip(middle * (column / middle) ** factor, quantity.low, quantity.high)
    return np.clip(middle + factor * (column - middle), quantity.low, quantity.high)


def values_of(measured: Measurement, scenario: Scenario, draws: Mapping[str, Real], n: int) -> Real:
    """Compute the measured quantity for every draw and point (n, points)."""
    points = len(measured.values)
    columns = {path: np.repeat(column, points) for path, column in draws.items()}
    if measured.over:
        columns[measured.over] = np.tile(np.array(measured.at), n)
    elif not columns:
        columns = _as_it_is(scenario)
    found = _computed(measured, scenario, columns) * measured.scale
    return np.broadcast_to(found, (n * points,)).reshape(n, points)


def _as_it_is(scenario: Scenario) -> dict[str, Real]:
    """Return one row with the value of a parameter that the set-up has."""
    path = next(path for path, value, _ in scenario.parameters() if value is not None)
    return {path: np.full(1, float(value_at(scenario, path)))}


def _computed(measured: Measurement, scenario: Scenario, columns: Mapping[str, Real]) -> Real:
    """Compute the measured quantity for each row of values of parameters, without its scale."""
    if not measured.per_changes:
        return _of_rows(measured, [measured.quantity, measured.per], scenario, columns)
    other = scenario.replace(dict(measured.per_changes))
    own = {path: column for path, column in columns.items() if not _is_changed(measured, path)}
    under = _of_rows(measured, [divisor(measured)], other, own or _as_it_is(other))
    return _of_rows(measured, [measured.quantity], scenario, columns) / under


def _is_changed(measured: Measurement, path: str) -> bool:
    """Whether the second quantity is computed with a value of its own for a parameter."""
    return any(f"{path}.".startswith(f"{each}.") for each in measured.per_changes)


def _of_rows(
    measured: Measurement, quantities: Sequence[Any], scenario: Scenario, columns: Mapping[str, Real]
) -> Real:
    """Compute a quantity, or the quotient of two, for each row of values of parameters."""
    if callable(measured.quantity):
        made = ParametricScenario(scenario, list(columns))
        table = np.stack(list(columns.values()), axis=1)
        together = _in_columns(measured, made, columns, table.tolist())
        if together is not None:
            return together
        rows, places = np.unique(table, axis=0, return_inverse=True)  # a few listed values repeat
        found = np.array([_of_function(measured, made.scenario(row)) for row in rows.tolist()])
        return np.asarray(found[places.reshape(-1)])
    names = [name for name in quantities if name]

    def numbers(scenario: Scenario, columns: Mapping[str, Real]) -> Real:
        many = prepare(scenario, free=list(columns), quantity=names)
        if measured.over in columns and len(columns) > 1 and many.method != TOGETHER:
            return one_point_after_the_other()  # of which each may run on arrays
        several = many(columns)
        return np.asarray(several[names[0]] / (several[names[1]] if len(names) > 1 else 1.0))

    def one_point_after_the_other() -> Real:
        found = np.empty(len(columns[measured.over]))
        for value in dict.fromkeys(measured.at):
            rows = columns[measured.over] == value
            some = {path: column[rows] for path, column in columns.items() if path != measured.over}
            found[rows] = numbers(scenario.replace({measured.over: value}), some)
        return found

    return numbers(scenario, columns)


def _in_columns(
    measured: Measurement, made: ParametricScenario, columns: Mapping[str, Real], rows: list[list[float]]
) -> Real | None:
    """Call the function of a measurement once for all rows; None where it, a model or a parameter takes no columns."""
    scenario, function = made.base, measured.quantity
    alone = [path for path, value in made.begin.items() if not isinstance(value, float)]
    alone += [path for path in columns if derived_at(scenario, path) is not None]
    if alone or scenario.moisture is not None or not getattr(function, "takes_columns", False):
        return None
    try:
        check_values(scenario, made.declared, columns)
        many = with_columns(scenario, {path: column[:, None] for path, column in columns.items()})
        found = np.broadcast_to(np.asarray(function(many), dtype=float), len(rows))  # type: ignore[operator]
        ends = [_of_function(measured, made.scenario(rows[place])) for place in (0, -1)]
    except (TypeError, ValueError, ElectrovibError):  # a row alone says what is wrong with it
        return None
    return found if np.allclose(found[[0, -1]], ends, rtol=SAME, atol=0) else None


def _of_function(measured: Measurement, scenario: Scenario) -> float:
    """Call the function of a measurement; a number that it cannot compute is a reason, any other error names it."""
    called = f"{getattr(measured.quantity, '__name__', 'quantity')}() of '{measured.title}'"
    try:
        return float(measured.quantity(scenario))  # type: ignore[operator]  # the caller has asked
    except (ValueError, ArithmeticError) as error:
        raise InputError(f"{called} failed with {type(error).__name__}: {error}") from error
    except ElectrovibError:
        raise
    except Exception as error:
        error.add_note(f"in {called}")
        raise


def set_up(measured: Measurement, name: str, content: Any) -> tuple[Scenario, dict[str, Any]]:
    """Return the set-up with one of the models, and the distributions of what is not printed of it."""
    own = measured.of_model.get(name, {})
    left_out = tuple(path for path, table in own.items() if table is None)
    tables = {**measured.unknown, **{path: table for path, table in own.items() if table is not None}}
    start = f"{measured.judges}."
    begin = {path.removeprefix(start): _middle(own[path]) for path in own if path.startswith(start)}
    changes: dict[str, Any] = {
        measured.judges: {**content, **begin} if isinstance(content, dict) else content
    }
    if left_out:
        layers = measured.scenario.stack.layers.items()
        changes["stack"] = {layer: each for layer, each in layers if f"stack.{layer}" not in left_out}
    kept = {path: each for path, each in tables.items() if not path.startswith(left_out or " ")}
    return measured.scenario.replace(changes), kept


def _middle(table: Mapping[str, Any]) -> Any:
    """Return a value inside the range of a distribution."""
    given = table.get("values", [table.get("low")])[0]
    return table.get("median", table.get("mean", given))


CONSTANT, SQUARE, RANGE = "a constant", "a constant times V^2", "log-uniform"
NULLS: Final = {
    CONSTANT: "geometric mean and deviation of what other groups measured of this quantity, each group counting once; of a"
    " force, over its area, whatever the voltage; log-uniform where there is no other group; of one quantity under two conditions"
    " that both are alike",
    SQUARE: "the same of a force over its area and the square of the largest voltage; of other quantities as the constant",
    RANGE: "log-uniform over all that was ever measured of this quantity, at least a decade",
}
"""Null models, with what they predict."""
_STRESS: Final = "force over area"


@dataclass(frozen=True)
class _Known:
    """A measurement: logarithms of its values over `unit`, and of the squares of its voltages, where it has any.

    Of a quotient of one quantity under two conditions (`quotient`) the squares are those of one over the other.
    """

    quantity: object
    group: str
    logs: Real
    unit: float
    squares: Real | None
    quotient: bool = False


def null_predictions(
    measured: Mapping[str, Measurement], known: Mapping[str, Measurement], *, n: int
) -> Iterator[tuple[str, ModelPrediction]]:
    """Predict each measurement by every null model, from it and the known ones; no constant is taken from the own group."""
    found = {id(each): _known(each) for each in (*known.values(), *measured.values())}
    for name, each in measured.items():
        for null, logs in _logs(found[id(each)], list(found.values()), n).items():
            values = found[id(each)].unit * np.exp(np.broadcast_to(logs, (n, len(each.values))))
            yield name, ModelPrediction(null, values, values, values)


def _logs(own: _Known, known: Sequence[_Known], n: int) -> dict[str, Real]:
    """Return evenly spaced quantiles of the logarithm at each point, (n, points) or (n, 1), by null model."""
    alike = [each for each in known if each.quantity == own.quantity]
    others = [each for each in alike if each.group != own.group]
    within = _over_range(np.concatenate([each.logs for each in alike]), n)
    constant = _around([(each.group, each.logs) for each in others], n) if others else within
    squared = [(each.group, each.logs - each.squares) for each in others if each.squares is not None]
    square = constant if own.squares is None or not squared else _around(squared, n) + own.squares
    if own.quotient:  # what is constant, or constant over the square of the voltage, leaves nothing open
        constant = np.zeros((n, 1))
        square = constant if own.squares is None else constant + own.squares
    return {CONSTANT: constant, SQUARE: square, RANGE: within}


def _known(measured: Measurement) -> _Known:
    logs = np.log(np.array(measured.values))
    if measured.per_changes:
        squares, under = _squares(measured, {}), _squares(measured, measured.per_changes)
        squares = None if squares is None or under is None else squares - under
        alike = (measured.quantity, divisor(measured), *measured.per_changes)
        return _Known(alike, measured.group, logs, 1.0, squares, quotient=True)
    if measured.unit not in {"N", "Pa"}:
        return _Known((measured.quantity, measured.per), measured.group, logs, 1.0, None)
    path, area = measured.scenario.circuit.return_path, 1.0
    if measured.unit == "N":
        area = measured.scenario.contact_area + getattr(path, "area", 0.0)
    return _Known(_STRESS, measured.group, logs - np.log(area), area, _squares(measured, {}))


def _squares(measured: Measurement, under: Mapping[str, Any]) -> Real | None:
    """Return the logarithm of the square of the largest voltage at each point; None for a current or an unknown voltage."""
    if any(f"drive.{height}" in measured.unknown for height in ("amplitude", "level", "high")):
        return None
    changes = [{measured.over: value, **under} for value in measured.at] if measured.over else [under]
    try:
        largest = [measured.scenario.replace(each).drive.largest() for each in changes]
    except ElectrovibError:
        return None
    return 2 * np.log(largest) if min(largest) > 0 else None


def _around(found: Sequence[tuple[str, Real]], n: int) -> Real:
    """Return quantiles (n, 1) of a normal distribution with mean and deviation of all, in which every group counts once."""
    from scipy.special import ndtri

    groups = [group for group, _ in found]
    shares = [np.full(len(each), 1 / (len(each) * groups.count(group))) for group, each in found]
    weights, logs = np.concatenate(shares), np.concatenate([each for _, each in found])
    middle = np.average(logs, weights=weights)
    deviation = np.sqrt(np.average((logs - middle) ** 2, weights=weights))
    least = DECADE / (2 * ndtri((1 + LEVEL) / 2))  # a decade between the ends of the interval
    quantiles: Real = middle + max(deviation, least) * ndtri((np.arange(n)[:, None] + 0.5) / n)
    return quantiles


def _over_range(logs: Real, n: int) -> Real:
    """Return quantiles (n, 1) of a uniform distribution over all, at least over a decade."""
    middle, length = (logs.min() + logs.max()) / 2, max(logs.max() - logs.min(), DECADE)
    quantiles: Real = middle + length * ((np.arange(n)[:, None] + 0.5) / n - 0.5)
    return quantiles
