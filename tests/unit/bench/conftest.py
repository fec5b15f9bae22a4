"""The simulated bench of the tests: one plan, with an enable line or with an operator, and a twin that can be looked at."""

import functools

import pytest

from electrovib.bench import run
from electrovib.bench.twin.simulated import SimulatedBench

SCENARIO = "vezzoli_2014/fig6"
ORIGINAL = run.plan_bench


@pytest.fixture(scope="session")
def plan():
    """Return a function that plans the burst with an enable line or without one."""

    @functools.cache
    def planned(with_enable=True):
        content = ORIGINAL(SCENARIO).settings.to_dict()
        enable = {"on": "OUTP ON", "off": "OUTP OFF", "state": "OUTP?"}
        content["amplifier"]["enable"] = enable if with_enable else None
        return ORIGINAL(SCENARIO, bench=content)

    return planned


@pytest.fixture
def twin_in_place(monkeypatch, plan):
    """Return a function that lets the next run take a twin, changed by a function; it returns the list of such twins."""

    def put(*, with_enable=True, spoil=None, wrap=None):
        twins = []

        class Seen(SimulatedBench):
            def __init__(self, *arguments, **named):
                super().__init__(*arguments, **named)
                twins.append(self)
                if spoil:
                    spoil(self)

            @property
            def connections(self):
                inner = super().connections
                return {name: wrap(each) for name, each in inner.items()} if wrap else inner

        monkeypatch.setattr(run, "SimulatedBench", Seen)
        monkeypatch.setattr(run, "plan_bench", lambda *_, **__: plan(with_enable))
        return twins

    return put


@pytest.fixture
def at_zero(plan):
    """Return a function that tells whether the plate of a twin is at 0 V after one burst."""

    def is_at_zero(twin):
        twin.clock.sleep(plan().duration)
        return twin.plate_voltage() == 0

    return is_at_zero
