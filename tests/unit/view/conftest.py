"""Traces to draw: one run, another law, a sweep, a measurement."""

import sys

import numpy as np
import pytest

from electrovib.core.signals import make_trace
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.studies.sweep import sweep

CONTENT = {
    "title": "Glass & <film>",
    "drive": {"model": "Trapezium", "high": "1 kV", "rise": "36 ms", "hold": "0.1 s", "fall": "36 ms"},
    "force": {"model": "MaxwellStressInGap"},
    "friction": {"model": "Coulomb", "coefficient": 0.5},
    "contact": {"model": "FixedArea", "area": "1 cm2"},
    "load": {"normal_force": "0.5 N"},
    "circuit": {"return_path": {"model": "Grounded", "resistance": "2 kohm"}},
    "time": {"samples": 301},
    "frequency": {"samples": 25},
    "sources": {"stack.insulator": "data sheet of the film", "drive.high": "printed"},
    "stack": {
        "insulator": {"thickness": "90 um", "material": {"model": "Constant", "permittivity": 3.35}},
        "gap": {"thickness": "5 um"},
        "stratum_corneum": {
            "thickness": "200 um",
            "material": {"model": "Constant", "permittivity": 1560, "conductivity": "1.79 uS/m"},
        },
    },
}


@pytest.fixture(autouse=True)
def _without_pyplot(monkeypatch):
    """Figures belong to pyplot once anything has imported it; here they shall not."""
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)


@pytest.fixture(scope="session")
def scenario():
    return load(CONTENT)


@pytest.fixture(scope="session")
def trace(scenario):
    return simulate(scenario)


@pytest.fixture(scope="session")
def other(scenario):
    changes = {"force": {"model": "EffectiveMedium"}, "stack.gap.thickness": "1 um"}
    return simulate(scenario.replace(changes))


@pytest.fixture(scope="session")
def swept(scenario):
    return sweep(scenario, {"stack.gap.thickness": np.geomspace(1e-7, 1e-4, 15)}, records=True)


@pytest.fixture(scope="session")
def measured():
    time = np.linspace(0.0, 2.0, 501)
    force = 0.3 + 0.1 * np.sin(2 * np.pi * time)
    force[100:120] = np.nan
    signals = {"lateral_force": (("time",), force), "drive_voltage": (("time",), 100 * np.sin(7 * time))}
    return make_trace(signals, {"time": time}, {"title": "tribometer", "operator": "N. N."})
