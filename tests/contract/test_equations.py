"""The printed equation is the code: both are evaluated at random points, and a changed equation is refused."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest
import sympy

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.quantity import quantity_of

AGREEMENT = 1e-12
"""Relative: rounding of a dozen operations and of a complex power."""
REFUSAL = 1e-6
"""A change of the equation has to show at least this much."""
POINTS = 100
DECADES = {"frequency": (-1, 9), "gap": (-9, -4), "pressure": (0, 7)}
"""Powers of ten between which an argument that cannot be negative is tried."""


def arguments_of(kind, method):
    return [name for name in inspect.signature(getattr(kind, method)).parameters if name != "self"]


def fields_of(kind):
    return [name for name in kind.model_fields if quantity_of(kind, name) is not None]


def compiled(kind, method, text):
    """Turn an equation into a function of the method's arguments and the model's fields."""
    names = [*arguments_of(kind, method), *fields_of(kind)]
    known = {name: sympy.Symbol(name) for name in names}
    known |= {"eps0": sympy.Float(VACUUM_PERMITTIVITY, 17), "pi": sympy.pi, "I": sympy.I}
    expression = sympy.sympify(text, locals=known)
    unknown = expression.free_symbols - set(known.values())
    assert not unknown, f"{kind.__name__}.{method}: the equation uses {unknown}"
    return sympy.lambdify([known[name] for name in names], expression, ["scipy", "numpy"])


def values_for(name, random):
    """Frequencies over the band of the contracts, gaps and pressures of skin; anything else of either sign, over 18 decades.

    So wide, because a parameter that only matters at high fields has to be seen.
    """
    if name in DECADES:
        return 10 ** random.uniform(*DECADES[name], POINTS)
    return random.choice([-1, 1], POINTS) * 10 ** random.uniform(-9, 9, POINTS)


def disagreement(kind, method, text, near_example, *, seed=0):
    """Largest relative difference between equation and method, over fields and arguments."""
    random = np.random.default_rng(seed)
    equation, worst = compiled(kind, method, text), 0.0
    for _ in range(5):
        model = near_example(kind, random)
        given = {name: values_for(name, random) for name in arguments_of(kind, method)}
        fields = {name: getattr(model, name) for name in fields_of(kind)}
        printed = equation(*given.values(), *fields.values())
        coded = getattr(model, method)(**given)
        worst = max(worst, float(np.max(np.abs(coded - printed) / np.abs(printed))))
        first = {name: column[0] for name, column in given.items()}
        alone = getattr(model, method)(**first)
        assert np.ndim(alone) == 0
        worst = max(worst, float(np.abs(alone - np.ravel(printed)[0]) / np.abs(np.ravel(printed)[0])))
    return worst


def test_equations_hold(final_class, near_example):
    for method, text in final_class.equation.items():
        assert disagreement(final_class, method, text, near_example) < AGREEMENT


def test_changed_equations_are_refused(final_class, near_example):
    for method, text in final_class.equation.items():
        changed = f"({text})*(1 + 1e-5)"
        assert disagreement(final_class, method, changed, near_example) > REFUSAL
        # an equation without its imaginary unit, a parameter or an argument is another one
        for name in [*arguments_of(final_class, method), *fields_of(final_class), "I"]:
            symbols = {
                str(symbol) for symbol in sympy.sympify(text, locals={"E": sympy.Symbol("E")}).free_symbols
            }
            if name in symbols or (name == "I" and "I" in text):
                twisted = re.sub(rf"\b{name}\b", f"(1.001*{name})", text)
                assert disagreement(final_class, method, twisted, near_example) > REFUSAL, name


def test_equations_with_strange_symbols_are_refused(discovered):
    material = discovered["material_class"]["Debye"]
    with pytest.raises(AssertionError, match="uses"):
        compiled(material, "bound_permittivity", "permittivity_high + strenth")


def test_an_equation_is_checked_for_every_law_and_every_plain_material(discovered):
    for name, law in discovered["law_class"].items():
        assert "pressure" in law.equation, name
    printed = {
        name for name, kind in discovered["material_class"].items() if "bound_permittivity" in kind.equation
    }
    sums_and_tables = {
        name
        for name, kind in discovered["material_class"].items()
        if any(field.annotation not in (float, str, int) for field in kind.model_fields.values())
    }
    assert printed | sums_and_tables == set(discovered["material_class"])
    assert {"Constant", "Debye", "HavriliakNegami", "ConstantPhase"} <= printed
