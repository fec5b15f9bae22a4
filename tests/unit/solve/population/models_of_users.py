"""Own copies of every shipped material, law and friction, and laws of users; `test_together` runs this file by itself."""

import __future__

import inspect
import sys
from types import ModuleType

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.paths import value_at
from electrovib.physics.contact import PerssonSurface
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.solve.one_by_one import value_of
from electrovib.solve.population import Population
from electrovib.solve.simulate import simulate

OWN = ModuleType("own_models_of_a_user")
sys.modules[OWN.__name__] = OWN


def own_copy(kind):
    """Declare the same class once more, under another name, in a module of a user."""
    source = inspect.getsource(kind).replace(f"class {kind.__name__}(", f"class Own{kind.__name__}(", 1)
    OWN.__dict__.update({**vars(sys.modules[kind.__module__]), "__name__": OWN.__name__})
    flags = __future__.annotations.compiler_flag
    exec(compile(source, OWN.__name__, "exec", flags, dont_inherit=True), OWN.__dict__)
    copy = getattr(OWN, f"Own{kind.__name__}")
    copy.model_rebuild(force=True, _types_namespace=OWN.__dict__)
    return copy


SHIPPED = {
    (family, name): kind
    for family in (Material, ForceLaw, Friction)
    for name, kind in find_members(family).items()
    if kind.__module__.startswith("electrovib.")
}
COPIES = {key: own_copy(kind) for key, kind in SHIPPED.items()}
ON = {"Persson2018RoughGap": "persson_2018/coating", "Vezzoli2014PerFrequency": "vezzoli_2014/fig7"}
WHERE = {Material: "stack.stratum_corneum.material", ForceLaw: "force", Friction: "friction"}
SIGNALS = {Material: "electrostatic_force", ForceLaw: "electrostatic_force", Friction: "lateral_force"}


def both(family, name):
    """A scenario with the shipped model, and with its copy."""
    kind, where = SHIPPED[family, name], WHERE[family]
    if name == "BridgedAir":
        where = "stack.gap.material"
    usual = (
        "vezzoli_2014/fig6"
        if family is ForceLaw and name != "MaxwellStressInGap"
        else "vezzoli_2014/fig6_gap"
    )
    base = ev.load(ON.get(name, usual)).replace({"motion.speed": 0.05, "frequency.samples": 5})
    if name == "AdhesiveShear":
        base = base.replace({"contact.surface": {"model": "PerssonSurface", **PerssonSurface.example}})
    table = dict(kind.example)
    if family is ForceLaw and name in ON:
        table = {key: value for key, value in base.force.to_dict().items() if key != "model"}
    if "steady" in table or "steady" in kind.model_fields:
        table["steady"] = {"model": "Coulomb", "coefficient": 0.5}
    one = base.replace({where: {"model": name, **table}})
    return one, base.replace({where: {"model": f"Own{name}", **table}}), where


def free_paths(scenario, where):
    """Every number of the model, and one of the layers."""
    own = [path for path, value, _ in scenario.parameters() if path.startswith(f"{where}.")]
    own = [path for path in own if isinstance(value_at(scenario, path), float) and value_at(scenario, path)]
    if where.endswith("material") and value_of(scenario, where).debye() is None:  # each path takes a second
        own = [own[0], own[-1]]
    return [*own, "stack.insulator.thickness"]


def answered(draw, scenario, path, signal):
    """How fingers are computed, and what they answer."""
    frequency = not scenario.force.causal
    names = ["mean_force"] if frequency else [signal]
    time = None if frequency else np.linspace(0.0, 0.05, 6)
    many = Population(scenario, [path], names, time)
    return many.method, many.signals(draw(scenario, [path], 2, spread=0.05))[names[0]]


@pytest.mark.parametrize(("family", "name"), SHIPPED, ids=[name for _, name in SHIPPED])
def test_an_own_copy_takes_the_same_way_with_the_same_numbers(fingers, family, name):
    one, two, where = both(family, name)
    for path in free_paths(one, where):
        ways, rows = zip(
            *(answered(fingers.draw, each, path, SIGNALS[family]) for each in (one, two)), strict=True
        )
        assert ways[1].replace(f"Own{name}", name) == ways[0], path
        np.testing.assert_array_equal(rows[1], rows[0], err_msg=path)
    if one.force.causal:
        traces = [simulate(each, time=np.linspace(0.0, 0.05, 6)) for each in (one, two)]
        assert traces[1].attrs["solver"] == traces[0].attrs["solver"]
        np.testing.assert_array_equal(
            traces[1].electrostatic_force.values, traces[0].electrostatic_force.values
        )


@pytest.mark.parametrize("name", ["Constant", "Debye", "Prony"])
def test_sums_of_relaxations_are_computed_in_arrays(fingers, name):
    _, two, where = both(Material, name)
    for path in free_paths(two, where):
        assert answered(fingers.draw, two, path, "electrostatic_force")[0].startswith("together"), path


@pytest.mark.parametrize("name", ["HavriliakNegami", "OwnHavriliakNegami"])
def test_what_a_model_refuses_together_is_refused_in_arrays(name):
    where, table = WHERE[Material], dict(SHIPPED[Material, "HavriliakNegami"].example)
    scenario = ev.load("vezzoli_2014/fig6").replace({where: {"model": name, **table}})
    many = Population(scenario, [f"{where}.skewness"], ["mean_force"])
    assert many.method.startswith("together")
    many.signals({f"{where}.skewness": [0.5, 0.7, 1.2]})
    with pytest.raises(InputError, match=r"broadness \* skewness is 1.6.*finger 2 of the call"):
        many.signals({f"{where}.skewness": [0.5, 0.7, 2.0]})


class MixesFingers(ForceLaw):
    """A law whose formula takes the largest of all fields, which in arrays is that of another finger."""

    evaluation_surface = "gap"

    def pressure(self, E):
        return 1e-12 * E**2 / (1 + 1e-14 * np.max(np.abs(E)) ** 2)


class ThresholdLaw(ForceLaw):
    """A law that is quadratic up to a field that is not reached before."""

    evaluation_surface = "gap"

    def pressure(self, E):
        return np.where(np.abs(E) < 3e8, 4e-12 * E**2, 0.0)


def test_a_law_that_would_mix_fingers_or_is_quadratic_up_to_a_limit_is_found_out(fingers):
    member, free = ev.load("vezzoli_2014/fig6_gap"), ["stack.gap.thickness"]
    mixing = member.replace({"force": {"model": "MixesFingers"}})
    found, method = fingers.difference(mixing, free, ["electrostatic_force"])
    assert "differs from that of one finger" in method
    assert found == {"electrostatic_force": 0}
    limited = member.replace({"force": {"model": "ThresholdLaw"}})
    assert max(fingers.difference(limited, free)[0].values()) < 1e-12
