"""The corrected law of rough contact beside contacts solved, on surfaces to which it was not fitted."""

import numpy as np
import pytest

from electrovib.physics.contact import FittedSurface, RoughAttraction
from electrovib.physics.half_space import Elastic
from electrovib.physics.roughness import PullingSpots, local_pull, mean_pull
from electrovib.physics.topography import SelfAffine
from electrovib.solve.diagnostics.closed_gap import pressed_gaps
from electrovib.solve.rough_contact import Loaded, follow_voltages

DRAWS = 16
NEW = {
    "stiff": (
        SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=62.5e-6),
        *(1e7, 0.256e-6, (10.0, 20.0, 30.0, 40.0)),
    ),
    "soft": (
        SelfAffine(rms=5e-6, hurst=0.6, longest=2e-3, roll_off=1e-3, shortest=1.25e-4),
        *(4e6, 1e-6, (40.0, 80.0, 100.0)),
    ),
}
"""Spectrum, Young's modulus [Pa], electrical thickness [m], small beside the heights so that spots attract most, voltages [V]."""


@pytest.mark.slow
@pytest.mark.parametrize("name", NEW)
def test_an_attraction_as_large_as_the_load_is_within_the_stated_error(name):
    """At the solver's pressure and from the load alone; the mean of many draws, whose own error is 4 %."""
    rough, modulus, thickness, voltages = NEW[name]
    body, load, found = Elastic(modulus=modulus), 5e3, []
    for seed in range(DRAWS):
        heights = rough.heights(rough.shape(), rough.periods, seed=seed)
        loaded = Loaded(heights=heights, periods=rough.periods, compliance=body.compliance, pressure=load)
        rests = follow_voltages(loaded, voltages, electrical_thickness=thickness)
        found.append([(rest.mean_attraction, rest.contact_share) for rest in rests])
    surface = FittedSurface(
        modulus=modulus / 0.75, rms_height=rough.rms, rms_slope=rough.rms_slope(rough.periods)
    )
    means = np.mean(found, axis=0)
    assert means[-1, 0] > 0.5 * load
    for voltage, (attraction, share) in zip(voltages, means, strict=True):
        given = {"electrical_thickness": thickness, "spots": PullingSpots()}
        closed = share * float(local_pull(voltage, electrical_thickness=thickness))
        borne = load + attraction - surface.held * closed
        alone, _ = pressed_gaps(surface, RoughAttraction(voltage=voltage, surface=surface, **given), load)
        for gaps, error in ((surface.gaps(borne), 0.15), (alone, 0.3)):
            law = float(mean_pull(voltage, gaps=gaps, **given).total)
            assert law == pytest.approx(attraction, rel=error)
        assert float(surface.real_share(np.asarray(borne))) == pytest.approx(
            share, rel=0.25
        )  # the grid has 5 % more
        assert surface.diagnostics(share)[0].state == "ok"
