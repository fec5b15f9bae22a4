"""The drawing of the stack."""

import itertools

import pytest

from electrovib.scenario import load
from electrovib.view import plots
from electrovib.view.plots.layers import drawn_heights, written_name


def slabs(ax):
    return {patch.get_label(): patch for patch in ax.patches if patch.get_label()}


def words(ax):
    return [text.get_text() for text in ax.texts]


def with_stack(scenario, **layers):
    return load(
        {**scenario.to_dict(), "force": {"model": "MaxwellStressInGap"}, "sources": {}, "stack": layers}
    )


def test_every_layer_can_be_read_and_a_thicker_one_is_higher(scenario):
    thin = scenario.replace({"stack.gap.thickness": "10 nm", "stack.insulator.thickness": "1 um"})
    found = slabs(plots.stack(thin))
    assert list(found) == ["insulator", "gap", "stratum_corneum"]
    heights = {name: patch.get_height() for name, patch in found.items()}
    assert min(heights.values()) == heights["gap"] == 1
    assert heights["gap"] < heights["insulator"] < heights["stratum_corneum"] == 2.5
    low = 0.0
    for patch in found.values():
        assert patch.get_y() == pytest.approx(low, rel=1e-12, abs=1e-18)
        low += patch.get_height()


@pytest.mark.parametrize("height", [0.3, 2.0])
def test_a_micron_under_the_skin_has_room_for_its_label(scenario, height):
    """In a figure of its own, whatever the other layers are: at least the height of two lines of text."""
    coated = scenario.replace({"stack.insulator.thickness": "1 um", "stack.gap.thickness": height * 1e-6})
    ax = plots.stack(coated)
    ax.figure.draw_without_rendering()
    for name, patch in slabs(ax).items():
        assert patch.get_window_extent().height >= 24 * ax.figure.dpi / 72, name


def test_heights_grow_with_the_logarithm_and_boundaries_are_numbered_by_their_true_distance(scenario):
    found = drawn_heights({"a": 1e-6, "b": 1e-5, "c": 1e-4})
    assert found == pytest.approx({"a": 1.0, "b": 1.5, "c": 2.0}, rel=1e-12)
    assert drawn_heights({"a": 1e-9, "b": 1e-3}) == pytest.approx({"a": 1.0, "b": 2.5}, rel=1e-12)
    assert drawn_heights({"a": 3e-6, "b": 3e-6}) == {"a": 1.0, "b": 1.0}
    ax = plots.stack(scenario)
    assert [text.get_text() for text in ax.get_yticklabels()] == ["0", "90", "95", "295"]
    assert ax.get_title(loc="left") == "not to scale: heights grow with the logarithm of the thickness"
    assert ax.get_ylabel() == "distance from the plate [µm]"
    assert {
        "insulator, 90 µm",
        "ε = 3.35, does not conduct",
        "gap, 5 µm",
        "ε = 1, does not conduct; force evaluated here",
        "ε = 1560, σ = 1.79 µS/m",
        "return path: Grounded, resistance 2 kΩ",
    } <= set(words(ax))


def test_what_else_is_declared_is_stated(scenario):
    film = {"thickness": 1e-4, "material": {"model": "Constant", "permittivity": 3}}
    charged = {**film, "initial_charge": "-330 uC/m2", "breakdown_field": "300 MV/m"}
    skin = {"thickness": 1e-4, "material": {"model": "Debye", **DEBYE}}
    shown = " ".join(words(plots.stack(with_stack(scenario, insulator=charged, stratum_corneum=skin))))
    assert "charged with -330 µC/m²" in shown
    assert "breaks down at 300 MV/m" in shown
    # 4 + 1100 at a frequency far below the relaxation
    assert "ε′ = 1104 at 1 kHz (Debye)" in shown


def test_a_material_of_the_library_is_named_and_its_unverified_values_are_marked(scenario):
    shown = words(plots.stack(scenario.replace({"stack.insulator.material": "parylene C"})))
    assert "insulator, 90 µm, parylene C" in shown
    assert any(text.startswith("ε′ = 3.1 at 1 kHz") and "with unverified values" in text for text in shown)
    assert not any("unverified" in text for text in words(plots.stack(scenario)))
    usual = {"su8": "SU-8", "p_vdf_trfe_cfe": "P(VDF-TrFE-CFE)", "soda_lime_glass": "soda-lime glass"}
    usual |= {"silica": "silica", "of_my_own": "of my own"}
    assert {name: written_name(name) for name in usual} == usual


DEBYE = {"permittivity_high": 4, "strength": 1100, "relaxation_time": "32 ns", "conductivity": 0.2}


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
    ax.figure.draw_without_rendering()
    boxes = sorted((text.get_window_extent() for text in ax.texts), key=lambda box: box.y0)
    right = [box for box in boxes if box.x0 > ax.get_window_extent().x0 + 0.3 * ax.get_window_extent().width]
    assert len(right) == 2 * len(layers) + 1
    assert all(upper.y0 >= lower.y1 - 2 for lower, upper in itertools.pairwise(right))
