"""Errors live where two features meet: every part of a scenario with every other, against the plain equations.

A scenario either answers as `product.plain` does, every signal within what its solver states, or it is refused
with a sentence that names a dotted path.
"""

import functools
import re

import numpy as np
import pytest
from product.answers import answer, scale
from product.axes import LIMITED, cases, name_of, output_times, refusals, refused_cases, scenario_of

from electrovib.core.errors import InputError
from electrovib.solve.simulate import simulate

FLOOR, SWITCHED = 1e-5, 3e-5
"""Of the size of a signal: what the plain equations themselves miss, 4e-6 at most where the solver is exact; behind a
largest current, which they let go of with a plate that follows within 1 ns, 1.1e-5."""
STATED = 3
"""Times the stated error, which a march gives for one field and not for its worst signal."""
FEW, SHORT, LONG = 20, 260, 90
"""How many of the short ones always, of the short ones and of the long ones with the slow tests."""
PATH = re.compile(r"(stack|circuit|contact|motion|time|drive|force|load)(\.\w+|: | = )")


def differences(case):
    """Signals that are not as the plain equations have them: name to difference over size."""
    scenario, times = scenario_of(case), output_times(case)
    if case["film"] == "renews":
        times = times[[2, -4]]
    trace, expected = simulate(scenario, time=times), answer(scenario, times)
    bound = SWITCHED if case["amplifier"] in LIMITED else FLOOR
    bound += STATED * sum(trace.attrs.get(name, 0.0) for name in ("step_error", "quadrature_error"))
    assert bound < 0.05, "a solver that states so large an error has not answered"
    found = {}
    for name, row in expected.items():
        signal, _, layer = name.partition(" ")
        values = trace[signal].sel(layer=layer).values if layer else trace[signal].values
        error = float(np.max(np.abs(values - row))) / scale(scenario, name, row)
        if not error <= bound:
            found[name] = error
    return found


@pytest.mark.parametrize("case", cases(count=FEW, long=False), ids=name_of)
def test_what_is_accepted_is_answered(case):
    assert not differences(case)


@pytest.mark.slow
@pytest.mark.parametrize("place", range(SHORT - FEW + LONG))
def test_what_is_accepted_is_answered_throughout(place):
    case = further()[place]
    assert not differences(case), name_of(case)


@functools.cache
def further():
    """Choose the other cases when the first of them is asked for: choosing takes seconds."""
    return cases(count=SHORT, long=False)[FEW:] + cases(count=LONG, long=True)


@pytest.mark.parametrize("case", refused_cases(count=40), ids=name_of)
def test_what_does_not_go_together_is_refused_with_a_sentence(case):
    with pytest.raises(InputError) as refused:
        simulate(scenario_of(case), time=output_times(case))
    said = str(refused.value)
    assert any(word in said for word in refusals(case)), said
    assert PATH.search(said), said
    assert len(said.split()) > 8, said
