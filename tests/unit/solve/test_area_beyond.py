"""The share of a rough contact whose film is above its strength: against closed forms, and that it loosens no limit."""

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from tests.contract.test_closed_gap import CLOSED, LARGEST, SCREEN, STRENGTH, THICKNESS, VOLTS, row

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.contact import FittedSurface, PerssonSurface
from electrovib.physics.contact.attraction import RoughAttraction
from electrovib.physics.roughness import GaussianGaps, PullingSpots
from electrovib.solve.diagnostics.closed_gap import area_beyond, pressed_gaps

PERMITTIVITY = 3.9
STIFF = {"modulus": 2e7, "rms_slope": 1.0, "rms_gap": 1e-5, "pressure_factor": 0.1, "decay_factor": 0.46}
PERSSON = {"contact.surface": {"model": "PerssonSurface", **STIFF}}
FITTED = {"contact.surface": {"model": "FittedSurface", "modulus": 1e8, "rms_height": 1e-5, "rms_slope": 0.5}}
BARE = {**SCREEN, "stack": {name: layer for name, layer in SCREEN["stack"].items() if name != "gap"}}


def reach(volts=VOLTS):
    """Gap up to which T + eps u has more than the strength across it, by plates in series."""
    return (volts / STRENGTH - THICKNESS) / PERMITTIVITY


def closed(changes, scenario=SCREEN):
    found = ev.check(scenario, set=changes)
    return found, row(found.rows, CLOSED)


def test_gaps_that_the_law_declares():
    """Phi((u - mean)/rms) for a Gaussian; of its power 4/3 the gap u is at (u/rms)^(3/4)."""
    force = {"force": {"model": "Persson2018RoughGap", "mean_gap": 3e-6, "rms_gap": 2e-6}}
    found, judged = closed(force, BARE)
    assert judged.area == pytest.approx(NormalDist(3e-6, 2e-6).cdf(reach()), rel=1e-6)
    assert "Persson2018RoughGap, whose gaps are declared" in judged.text
    assert f"gap closed (on {100 * judged.area:.3g} % of the area)" in found.headline
    force["force"]["power"] = 4 / 3
    _, judged = closed(force, BARE)
    assert judged.area == pytest.approx(NormalDist(1.5, 1).cdf((reach() / 2e-6) ** 0.75), rel=1e-6)


@pytest.mark.parametrize(
    ("surface", "words"), [(PERSSON, "PerssonSurface, not"), (FITTED, "FittedSurface, corr")]
)
def test_gaps_under_load_and_attraction_are_those_of_the_equilibrium(surface, words):
    """Of the states with contact spots, the one that a rising voltage reaches: that with the largest gap."""
    _, judged = closed(surface)
    still = {"stack.gap.material.conductivity": 0.0, **surface}
    states = ev.equilibrium(ev.load(SCREEN, changes=still), voltage=VOLTS, spots=PullingSpots()).stable
    model = ev.load(SCREEN, changes=surface).contact.surface
    gaps = model.gaps(states[-1].repulsion)
    assert judged.area == pytest.approx(float(gaps.share_up_to(reach())), rel=1e-4)
    assert words in judged.text
    assert 0 < judged.area < 0.5


def test_a_drive_below_0_v_and_a_filled_gap_are_those_of_the_equilibrium():
    """A pulse of the other sign attracts as much; a gap filled with permittivity 2 holds T + eps/2 u across its plates."""
    pulse = {"model": "Trapezium", "low": 0.0, "high": VOLTS, "rise": 1e-3, "hold": 5e-3, "fall": 1e-3}
    below = pulse | {"high": -VOLTS}
    areas = [closed(PERSSON | {"drive": each})[1].area for each in (pulse, below)]
    assert areas[1] == pytest.approx(areas[0], rel=1e-6)
    filled = PERSSON | {"stack.gap.material.permittivity": 2.0}
    _, judged = closed(filled)
    still = {"stack.gap.material.conductivity": 0.0, **filled}
    states = ev.equilibrium(ev.load(SCREEN, changes=still), voltage=VOLTS, spots=PullingSpots()).stable
    gaps = ev.load(SCREEN, changes=filled).contact.surface.gaps(states[-1].repulsion)
    assert judged.area == pytest.approx(float(gaps.share_up_to(2 * reach())), rel=1e-3)


def test_a_contact_that_falls_shut_or_a_gap_that_conducts_is_above_it_everywhere():
    soft = {"contact.surface": {"model": "PerssonSurface", **STIFF, "modulus": 1e5}}
    _, judged = closed(soft)
    assert judged.area == 1
    assert "where the contact falls shut" in judged.text
    _, judged = closed(PERSSON | {"stack.gap.material.conductivity": 1e-9})
    assert judged.area == 1
    assert "no gap keeps the voltage off the film" in judged.text


def test_it_loosens_no_limit(tmp_path):
    """However small the share, all rows have the values, limits and states that they have without a roughness."""
    plain, rough = (ev.check(SCREEN, set=changes) for changes in ({}, PERSSON))
    assert row(rough.rows, CLOSED).area < 0.01
    for before, after in zip(plain.rows, rough.rows, strict=True):
        names = ("quantity", "value", "limit", "state", "remedy", "margin", "forbids", "is_refused")
        assert all(getattr(before, name) == getattr(after, name) for name in names)
    with pytest.raises(InputError, match=r"gap closed.*% of the contact area by PerssonSurface, not corr"):
        ev.export_waveform(ev.load(SCREEN, changes=PERSSON), tmp_path / "drive.csv", rate=50e3, edge="line")
    assert not (tmp_path / "drive.csv").exists()
    found = ev.find_value(
        ev.load(SCREEN, changes=PERSSON),
        want={"mean electrostatic_force": 2.0},
        free="drive.amplitude = 10 V:1 kV",
    )
    assert found.obtainable.value == pytest.approx(LARGEST, rel=1e-6)
    assert "% of the contact area by PerssonSurface" in " ".join(found.document.sentences)


def test_it_is_stated_only_where_the_closed_gap_is_above_the_strength_and_a_roughness_is_declared():
    assert closed({})[1].area is None
    assert closed(PERSSON | {"drive.amplitude": LARGEST})[1].area is None
    assert closed(PERSSON | {"load.normal_force": 0.0})[1].area is None
    assert "area" not in closed({})[0].headline
    found, judged = closed(PERSSON)
    assert found.to_dict()["limits"][found.rows.index(judged)]["area"] == judged.area


@pytest.mark.parametrize("model", [PerssonSurface(**STIFF), FittedSurface(**FittedSurface.example)])
def test_the_share_of_narrow_gaps_is_the_sum_of_the_density(model):
    gaps = model.gaps(1e4)
    width = float(gaps.rms)
    edges = np.linspace(0.0, width ** (1 / 2), 4001) ** 2  # the density grows towards gap 0
    places = (edges[1:] + edges[:-1]) / 2
    between = float(np.sum(gaps.density(places) * np.diff(edges)))
    share = float(gaps.share_up_to(width))
    # midpoint rule beside gap 0
    assert share == pytest.approx(float(gaps.contact_fraction) + between, rel=1e-4)
    assert share == pytest.approx(NormalDist().cdf(1 - float(gaps.mean) / width), rel=1e-9)
    assert math.isclose(float(gaps.contact_fraction), float(model.real_share(np.asarray(1e4))), rel_tol=1e-9)


def test_a_check_does_not_end_at_a_surface_that_no_distribution_describes():
    """So soft, and so wide its decay, that more than half of it touches at every gap, or the least gap is 0 by rounding."""
    wide = {"modulus": 1e2, "rms_slope": 1e-6, "rms_gap": 1e-2, "pressure_factor": 1e3, "decay_factor": 10.0}
    _, judged = closed({"contact.surface": {"model": "PerssonSurface", **wide}})
    assert judged.area == 1
    assert "where the contact falls shut" in judged.text
    thin = RoughAttraction(voltage=0.0, electrical_thickness=5e-10, surface=None, spots=PullingSpots())
    far = PerssonSurface(
        modulus=2.9e3, rms_slope=0.32, rms_gap=5.9e-3, pressure_factor=1.06e-4, decay_factor=2.7
    )
    assert pressed_gaps(far, replace(thin, surface=far), 4.7e-5) == (None, True)


def test_a_gap_far_from_the_spots_keeps_the_voltage_off_the_film():
    """Of few spots the gaps of the power 4/3 reach further than their mean and nine rms: the share is that of the law."""
    gaps = GaussianGaps(mean=9.0e-6, rms=1e-6, power=4 / 3)
    scenario = ev.load(
        BARE,
        changes={
            "force": {"model": "Persson2018RoughGap", "mean_gap": 9e-6, "rms_gap": 1e-6, "power": 4 / 3}
        },
    )
    found = area_beyond(
        scenario, lambda gap: 1e-5 / gap, strength=1e-5 / 1.85e-5, voltage=1.0, electrical_thickness=1e-6
    )
    assert found is not None
    assert found[0] == pytest.approx(float(gaps.share_up_to(1.85e-5)), rel=1e-6)
    assert found[0] < 0.6
    assert "no gap" not in found[1]
