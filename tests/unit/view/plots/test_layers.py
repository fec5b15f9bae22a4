"""The stack to scale."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.view import plots
from electrovib.view.plots.layers import _spread


def slabs(ax):
    return {patch.get_label(): patch for patch in ax.patches if patch.get_label()}


def words(ax):
    return [text.get_text() for text in ax.texts]


def with_stack(scenario, **layers):
    return load(
        {**scenario.to_dict(), "force": {"model": "MaxwellStressInGap"}, "sources": {}, "stack": layers}
    )


def test_layers_are_to_scale_and_in_order(trace, scenario):
    found = slabs(plots.stack(trace))
    assert list(found) == ["insulator", "gap", "stratum_corneum"]
    low = 0.0
    for name, layer in scenario.stack.layers.items():
        assert found[name].get_y() == pytest.approx(low, rel=1e-12, abs=1e-18)
        assert found[name].get_height() == layer.thickness
        low += layer.thickness


def test_labels_tell_the_values(scenario):
    shown = words(plots.stack(scenario))
    assert "insulator  90 µm" in shown
    assert "ε = 3.35, does not conduct" in shown
    assert "gap  5 µm" in shown
    assert "ε = 1, does not conduct  ·  force evaluated here" in shown
    assert "ε = 1560, σ = 1.79 µS/m" in shown
    assert "current returns by Grounded: resistance 2 kΩ" in shown
    assert plots.stack(scenario).get_ylabel() == "distance from the plate [µm]"


def test_what_else_is_declared_is_told(scenario):
    film = {"thickness": 1e-4, "material": {"model": "Constant", "permittivity": 3}}
    charged = {**film, "initial_charge": "-330 uC/m2", "breakdown_field": "300 MV/m"}
    skin = {"thickness": 1e-4, "material": {"model": "Debye", **DEBYE}}
    shown = " ".join(words(plots.stack(with_stack(scenario, insulator=charged, stratum_corneum=skin))))
    assert "charged with -330 µC/m²" in shown
    assert "breaks down at 300 MV/m" in shown
    # 4 + 1100 at a frequency far below the relaxation
    assert "ε′ = 1104 at 1 kHz (Debye)" in shown


DEBYE = {"permittivity_high": 4, "strength": 1100, "relaxation_time": "32 ns", "conductivity": 0.2}


def test_a_layer_thinner_than_a_line_is_seen_and_says_so(scenario):
    thin = scenario.replace({"stack.gap.thickness": "10 nm"})
    ax = plots.stack(thin)
    assert "gap  10 nm  (thinner than the line that shows it)" in words(ax)
    at = 90e-6 + 5e-9
    flat = [
        line
        for line in ax.lines
        if np.allclose(line.get_ydata(), at, rtol=1e-12, atol=0) and len(line.get_xdata()) == 2
    ]
    assert flat
    assert not any("thinner" in text for text in words(plots.stack(scenario)))


def test_many_thin_layers_have_labels_that_do_not_touch(scenario):
    coating = {"thickness": 1e-7, "material": {"model": "Constant", "permittivity": 3}}
    layers = {
        "insulator": coating,
        "gap": coating,
        "sweat": coating | {"role": "finger"},
        "wax": coating | {"role": "finger"},
        "stratum_corneum": {**coating, "thickness": 1e-3},
    }
    ax = plots.stack(with_stack(scenario, **layers))
    ax.figure.canvas.draw()
    boxes = sorted((text.get_window_extent() for text in ax.texts), key=lambda box: box.y0)
    right = [box for box in boxes if box.x0 > ax.get_window_extent().x0 + 0.3 * ax.get_window_extent().width]
    assert len(right) == 2 * len(layers) + 1
    assert all(upper.y0 >= lower.y1 - 2 for lower, upper in itertools.pairwise(right))


def test_heights_of_labels_keep_order_and_distance():
    placed = _spread([0.1, 0.11, 0.12, 9.0], 1.0, 0.0, 10.0)
    assert placed == sorted(placed)
    assert min(np.diff(placed)) >= 1 - 1e-12
    assert placed[-1] == 9.0
    assert placed[0] >= 0.5


def test_a_measurement_has_no_stack(measured):
    with pytest.raises(InputError, match="no scenario"):
        plots.stack(measured)
