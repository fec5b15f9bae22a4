"""Runs a contract once for each thing discovered: nothing here is listed by name.

A test that takes `final_class`, `family`, `material_class`, `drive_class`, `law_class`, `paper`, `skin`,
`check` or `scenario` runs for each of them.
"""

import functools
import importlib
import pkgutil
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import strategies as st
from pydantic_core import PydanticUndefined

from electrovib.core.discovery import find_members, paper_of, papers
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack


@functools.cache
def model_classes():
    """Every class of the package and of contributed papers, without those that other tests define."""
    find_members(Drive)  # imports all physics and papers
    for room in ("electrovib.scenario", "electrovib.solve", "electrovib.bench"):
        folder = importlib.import_module(room)
        for info in pkgutil.walk_packages(folder.__path__, f"{room}."):
            importlib.import_module(info.name)
    found, waiting = [], [Model]
    while waiting:
        for kind in waiting.pop().__subclasses__():
            waiting.append(kind)
            if kind.__module__.startswith("electrovib.") or paper_of(kind):
                found.append(kind)
    return sorted(found, key=lambda kind: (kind.__module__, kind.__name__))


def readable(kind):
    return f"{kind.__module__.removeprefix('electrovib.')}.{kind.__name__}"


def of_family(family):
    return {name: kind for name, kind in find_members(family).items() if kind in model_classes()}


def offered(what):
    """Return the skins or the scenarios of all papers by "paper-name"."""
    found = {}
    for author_year, module in papers().items():
        for name, thing in getattr(module, what, dict)().items():
            found[f"{author_year}-{name}"] = thing
    return found


@dataclass(frozen=True)
class Asked:
    """A check, and what it is asked of."""

    check: object
    model: object

    def value(self):
        return self.check.value(self.model)


def checks():
    found = {}
    for author_year, module in papers().items():
        for check in getattr(module, "CHECKS", ()):
            found[f"{author_year}-{check.name}"] = Asked(check, None)
    for kind in model_classes():
        for check in kind.checks:
            found[f"{kind.__name__}-{check.name}"] = Asked(check, build(kind))
    return found


@functools.cache
def discovered():
    return {
        "final_class": {readable(kind): kind for kind in model_classes() if not kind.is_family},
        "family": {readable(kind): kind for kind in model_classes() if kind.is_family},
        "material_class": of_family(Material),
        "drive_class": of_family(Drive),
        "law_class": of_family(ForceLaw),
        "paper": dict(papers()),
        "skin": offered("skins"),
        "scenario": offered("scenarios"),
        "asked": checks(),
    }


def pytest_generate_tests(metafunc):
    for name, found in discovered().items():
        if name in metafunc.fixturenames:
            metafunc.parametrize(name, found.values(), ids=[key.replace(" ", "_") for key in found])


@pytest.fixture(scope="session", name="discovered")
def _discovered():
    """Give everything found, for tests that no list is empty."""
    return discovered()


def build(kind):
    return kind.model_validate(dict(kind.example))


@pytest.fixture(scope="session", name="build")
def _build():
    """Build a final class from its own example."""
    return build


def takes_samples(kind):
    return any(field.annotation is Samples for field in kind.model_fields.values())


def number_in(quantity, *, decades=12.0):
    """Draw evenly in the logarithm from a parameter's range, at most so many decades below its top."""
    low, high = quantity.low, quantity.high
    if low > 0:
        low = max(low, high * 10.0**-decades)
        return st.floats(np.log(low), np.log(high)).map(lambda log: float(np.clip(np.exp(log), low, high)))
    size = st.floats(np.log(high) - decades * np.log(10), np.log(high)).map(
        lambda log: float(min(np.exp(log), high))
    )
    if low == 0:
        return st.just(0.0) | size
    return st.just(0.0) | size | size.map(lambda value: max(-value, low))


@st.composite
def models(draw, kind):
    """Draw a final class from the declared ranges of its parameters; measured samples from its example.

    Families inside take their example's member. None if the class refuses the combination.
    """
    if takes_samples(kind):
        return build(kind)
    content = {}
    for name, field in kind.model_fields.items():
        quantity = quantity_of(kind, name)
        if quantity is not None:
            content[name] = draw(number_in(quantity))
        elif name in kind.example:
            content[name] = kind.example[name]
        inner = [part for part in getattr(field.annotation, "__args__", ()) if isinstance(part, type)]
        if inner and issubclass(inner[0], Model) and not inner[0].is_family:
            one = models(inner[0])
            content[name] = draw(st.none() | one if type(None) in inner else st.lists(one, max_size=3))
        elif field.default is PydanticUndefined and name not in content:
            content[name] = field.default_factory() if field.default_factory else None
    try:
        return kind.model_validate(content)
    except ValueError:
        return None


@pytest.fixture(scope="session", name="drawn")
def _drawn():
    """Give a strategy for instances of a final class."""
    return lambda kind: models(kind).filter(lambda model: model is not None)


@pytest.fixture(scope="session")
def near_example():
    """Build a final class near its example, or near that with more parameters: each within a factor of 3, with seeded chance."""

    def near(kind, random, more=None):
        content = dict(kind.example) | (more or {})
        if takes_samples(kind) or kind is Stack:
            return kind.model_validate(content)
        for name, field in kind.model_fields.items():
            quantity = quantity_of(kind, name)
            given = content.get(name, field.default)
            if quantity is None or not isinstance(given, (int, float)):
                continue
            around = given or min(1e-3, quantity.high)
            content[name] = float(np.clip(around * 3 ** random.uniform(-1, 1), quantity.low, quantity.high))
        try:
            return kind.model_validate(content)
        except ValueError:  # the combination is refused: stay at the example
            return kind.model_validate(dict(kind.example) | (more or {}))

    return near
