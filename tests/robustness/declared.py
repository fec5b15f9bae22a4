"""Random scenarios made of the declarations alone: any model of a family, any value in its range."""

from __future__ import annotations

import math
import types
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin

import numpy as np

from electrovib.core.discovery import find_members
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.scenario import Scenario

if TYPE_CHECKING:
    from collections.abc import Mapping

USUAL = 0.75
"""Share of the values that lie within a decade of the example; the others lie anywhere in the declared range."""
DEEPEST = 3
"""A drive within a drive within a drive."""
MENDED = (  # noqa: SIM905
    "Perception NonPacinian Tabulated HavriliakNegami Creep Corners Motion FrequencyGrid PulseTrain Square Trapezium"
    " TremblingDistance TouchAndLift"
).split()
"""Models whose parameters are related."""


def scenario_table(seed: int) -> dict[str, Any]:
    """Give the table of a random scenario; not every one is valid, as not every one that a user writes is."""
    return _Chance(np.random.default_rng(seed)).scenario()


class _Chance:
    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng

    def happens(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def scenario(self) -> dict[str, Any]:
        table = self.table(Scenario, {})
        table["stack"] = self.stack()
        if self.happens(0.7):
            table["force"] = {"model": "MaxwellStressInGap"}
        if self.happens(0.9):
            table.setdefault("motion", {}).setdefault("speed", float(10 ** self.rng.uniform(-3, -0.5)))
        if self.happens(0.5):
            table.get("motion", {}).pop("distance", None)
        if self.happens(0.8):
            table.pop("moisture", None)
        if self.happens(0.8):
            table.get("finger", {}).pop("growth", None)
        if self.happens(0.7):
            table["circuit"].pop("amplifier", None)
        if self.happens(0.7):
            table.get("time", {}).pop("initial_state", None)
        table["contact"] = self.usual_contact(table["contact"])
        if self.happens(0.5) and _prescribes_current(table["drive"]):
            table["drive"] = {"model": "Sine", "amplitude": 100.0, "frequency": 125.0}
        if self.happens(0.7):
            _leave_digitiser(table.get("rig", {}))
        table.pop("title", None)
        table.pop("sources", None)
        return table

    def usual_contact(self, table: dict[str, Any]) -> dict[str, Any]:
        """Most surfaces do not close the gap."""
        if self.happens(0.8):
            table.pop("closing", None)
        if self.happens(0.5):
            return {"model": "FixedArea", "area": 1e-4} | {
                name: table[name] for name in ("surface", "closing", "length") if name in table
            }
        return table

    def stack(self) -> dict[str, Any]:
        from electrovib.physics.stack import Layer

        names = [("insulator", "plate")] * self.happens(0.9)
        names += [("coating", "plate")] * self.happens(0.2)
        names += [("gap", "gap")] * self.happens(0.5)
        names += [("sweat", "finger")] * self.happens(0.1)
        names += [("stratum_corneum", "finger")] * self.happens(0.8)
        found = {}
        for name, role in names:
            layer = self.table(Layer, {"thickness": 10 ** self.rng.uniform(-6.5, -3.5)})
            layer["role"] = role
            if name == "gap" and self.happens(0.8):
                layer = {"thickness": layer["thickness"], "role": role}
            if self.happens(0.85):
                layer.pop("leak", None)
            if self.happens(0.9):
                layer.pop("initial_charge", None)
            found[name] = layer
        if found:
            found[[*found][-1]].pop("initial_charge", None)
        return found

    def table(self, model: type[Model], example: Any, depth: int = 0) -> dict[str, Any]:
        """Fill in a model: what has a default is left at it more often than not."""
        if model.is_family:
            members = sorted(find_members(model).items())
            if depth >= DEEPEST:
                members = [(name, member) for name, member in members if not _nests(member, model)]
            name, model = members[self.rng.integers(len(members))]
            return {"model": name} | self.table(model, {}, depth + 1)
        example = dict(model.example) | dict(example)
        found: dict[str, Any] = {}
        for name, declared in model.model_fields.items():
            required = declared.is_required() or name in model.example
            if not required and self.happens(0.65):
                continue
            value = self.value(model, name, declared.annotation, example.get(name), depth)
            if value is not None:
                found[name] = value
        if model.__name__ in MENDED and self.happens(0.95):
            self.mend(model.__name__, found)
        return found

    def mend(self, name: str, table: dict[str, Any]) -> None:  # noqa: C901, PLR0912
        """Keep the relations between parameters of one model, as a user most often does."""
        match name:
            case "Perception":
                table.pop("threshold", None)
                table.pop("threshold_uncertainty", None)
            case "NonPacinian":
                table.pop("low", None)
                table.pop("high", None)
            case "Tabulated":
                table.update(self.example("Tabulated", Material))
            case "HavriliakNegami":
                table["skewness"] = min(table["skewness"], 0.999 / table["broadness"])
            case "Creep" if "relaxations" in table:
                table["relaxations"] = [dict(each) for each in self.example("Creep", Friction)["relaxations"]]
            case "Corners":
                span = float(10 ** self.rng.uniform(-3, 2))
                table["points"] = [{"time": 0.1 * span, "share": 0.0}, {"time": span, "share": 1.0}]
            case "Motion" if "time_profile" in table or table.get("renews_film"):
                table.setdefault("speed", float(10 ** self.rng.uniform(-3, -0.5)))
            case "FrequencyGrid":
                if table.get("low", 1.0) >= table.get("high", 1e6):
                    table["low"], table["high"] = 1.0, 1e6
                table.pop("samples", None)
            case "PulseTrain":
                table["width"] = min(max(table["width"], 1e-9), 0.5 / table["frequency"])
                table.pop("edge", None)
            case "Square" if "edge" in table:
                table["edge"] = min(table["edge"], 0.2 / table["frequency"])
            case "Trapezium" if "repeat" in table:
                table["repeat"] = 1.5 * sum(table.get(key, 0.0) for key in ("delay", "rise", "hold", "fall"))
            case "TremblingDistance":
                table["amplitude"] = min(table["amplitude"], 0.9 * table["mean"])
            case "TouchAndLift":
                table["near"] = min(table["near"], 0.5 * table["far"])

    def example(self, name: str, family: type[Model]) -> Mapping[str, Any]:
        return find_members(family)[name].example

    def value(self, model: type[Model], name: str, annotation: Any, example: Any, depth: int) -> Any:  # noqa: PLR0911
        quantity = quantity_of(model, name)
        if quantity is not None:
            return self.number(quantity.low, quantity.high, example)
        kinds = [kind for kind in _kinds(annotation) if kind is not type(None)]
        kind = kinds[0]
        if name in ("samples", "seed", "bits", "cycles"):
            return round(10 ** self.rng.uniform(0.3, 1.5 if name == "bits" else 4.5))
        if get_origin(kind) is tuple:
            inner = get_args(kind)[0]
            return [self.table(inner, {}, depth + 1) for _ in range(self.rng.integers(1, 4))]
        if not isinstance(kind, type):  # one of some words
            return example
        if issubclass(kind, Samples):
            return self.samples(model, name)
        if issubclass(kind, Model):
            return self.table(kind, example if isinstance(example, dict) else {}, depth + 1)
        return self.happens(0.3) if kind is bool else example

    def number(self, low: float, high: float, example: Any) -> float:
        if isinstance(example, (int, float)) and example and self.happens(USUAL):
            return float(np.clip(example * 10 ** self.rng.normal(0, 0.4), low, high))
        if self.happens(0.02):
            return float(self.rng.choice([low, high]))
        if low < 0 < high:
            size = math.log10(min(-low, high))
            return float(self.rng.choice([-1, 1]) * 10 ** self.rng.uniform(size - 6, size))
        bottom = math.log10(low) if low > 0 else math.log10(high) - 8
        return float(np.clip(10 ** self.rng.uniform(bottom, math.log10(high)), low, high))

    def samples(self, model: type[Model], name: str) -> list[float]:
        """Measured columns belong together: those of the example, scaled."""
        example = np.asarray(model.example[name], dtype=float)
        return (example * float(10 ** self.rng.normal(0, 0.3))).tolist()


def _leave_digitiser(rig: dict[str, Any]) -> None:
    """Noise is that of one reading."""
    rig.pop("digitiser", None)
    for sensor in ("normal", "lateral"):
        rig.get(sensor, {}).pop("noise", None)


def _prescribes_current(drive: dict[str, Any]) -> bool:
    return "Current" in drive["model"]


def _kinds(annotation: Any) -> tuple[Any, ...]:
    return get_args(annotation) if get_origin(annotation) in (Union, types.UnionType) else (annotation,)


def _nests(member: type[Model], family: type[Model]) -> bool:
    """Tell whether a model holds another one of its own family."""
    for declared in member.model_fields.values():
        for kind in _kinds(declared.annotation):
            inner = get_args(kind)[0] if get_origin(kind) is tuple else kind
            if inner is family:
                return True
    return False
