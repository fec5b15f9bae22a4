"""Every insulating layer of every preset is compared with a breakdown strength, or the reason why not is known."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.physics.safety import film_diagnostic

NOT_JUDGED = {
    "rauf_2025-field_50": "a number of a field calculation, of no material",
    "shultz_2015-leaky": "a coating that conducts as a choice; no strength is known for such a layer",
}
"""Preset to why nothing is known of the strength of its insulator."""


def plate_layers(scenario):
    return [name for name, role in scenario.stack.roles.items() if role == "plate"]


@pytest.fixture
def judged(scenario):
    """Layer to its diagnostic at a field of 1 V/m, far below every strength."""
    layers = scenario.stack.layers
    return {name: film_diagnostic(name, layers[name], field=1.0) for name in plate_layers(scenario)}


def test_each_insulator_has_a_strength_or_a_reason(scenario, judged, request):
    known = any(name in request.node.name for name in NOT_JUDGED)
    for name, diagnostic in judged.items():
        assert (diagnostic.limit is None) == known, diagnostic.text
        assert ("no breakdown strength is known" in diagnostic.text) == known
        if diagnostic.limit is not None:
            assert 1e7 < diagnostic.limit < 1e10
            assert "measured at" in diagnostic.text
            assert diagnostic.state == ("unknown" if _doubtful(diagnostic.text) else "ok")
        assert scenario.stack.layers[name].breakdown_field is None  # no copied constant


def _doubtful(text):
    return any(word in text for word in ("unverified", "does not show"))


def test_the_coatings_of_touch_screens_are_silica_and_the_films_are_polymers(scenario):
    for name in plate_layers(scenario):
        layer = scenario.stack.layers[name]
        permittivity = float(layer.material.bound_permittivity(np.array(1e3)).real)
        leaky = layer.material.conductivity > 0
        assert (layer.material.substance == "silica") == (permittivity == 3.9 and not leaky)
        if layer.material.substance is None and not leaky and permittivity < 4.5:
            text = film_diagnostic(name, layer, field=1.0).text
            assert "lowest breakdown strength of polymer films in the materials library" in text


def test_the_reasons_are_of_presets_that_exist(discovered):
    assert set(NOT_JUDGED) <= set(discovered["scenario"])
