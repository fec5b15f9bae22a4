"""The stack of layers as a drawing: to scale, and with every layer thick enough to be read."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Final

from electrovib.view.plots.layers import drawn_heights
from electrovib.view.style import layer_colours
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed

_HEIGHT: Final = 190.0
"""Height of all layers together, in points of the drawing."""
_STRIP: Final = 18.0
_TRUE_LEFT, _TRUE_WIDTH = 4.0, 34.0
_LEFT, _WIDTH = 78.0, 60.0
_TEXT: Final = 148.0
_TOTAL: Final = 346.0


def drawing(shown: Computed) -> str:
    """Draw the layers between plate and finger as SVG.

    Left, the layers to scale. Right, with heights that grow with the logarithm of the thickness, joined by
    lines to the left; beside each layer its thickness and the largest field and voltage of the run.
    """
    layers = shown.scenario.stack.layers
    thicknesses = {name: layer.thickness for name, layer in layers.items()}
    heights = drawn_heights(thicknesses)
    unit, total = _HEIGHT / sum(heights.values()), sum(thicknesses.values())
    colours = layer_colours(list(layers))
    bottom = _STRIP + _HEIGHT
    parts = [
        _strip(0.0, "finger", "#cdb9a8", "#222222"),
        _strip(bottom, "plate electrode", "#5d5d5d", "#ffffff"),
    ]
    true_low = low = bottom
    for name, thickness in thicknesses.items():
        true_high, high = true_low - _HEIGHT * thickness / total, low - unit * heights[name]
        parts += _layer(colours[name], (true_low, true_high), (low, high))
        parts += _words(name, thickness, shown, (low + high) / 2)
        true_low, low = true_high, high
    described = ", ".join(
        f"{name.replace('_', ' ')} {pretty_quantity(t, 'm')}" for name, t in thicknesses.items()
    )
    view = f"0 0 {_TOTAL:g} {_HEIGHT + 2 * _STRIP + 14:g}"
    caption = (
        f'<text x="{_TRUE_LEFT}" y="{_HEIGHT + 2 * _STRIP + 11:g}" font-size="9">to scale</text>'
        f'<text x="{_LEFT}" y="{_HEIGHT + 2 * _STRIP + 11:g}" font-size="9">enlarged where thin</text>'
    )
    label = escape(f"Layers from the plate to the finger: {described}", quote=True)
    return (
        f'<svg role="img" aria-label="{label}" viewBox="{view}" width="100%" fill="currentColor"'
        f' font-family="sans-serif">{"".join(parts)}{caption}</svg>'
    )


def _strip(top: float, words: str, colour: str, ink: str) -> str:
    return "".join(
        f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{_STRIP:g}" fill="{colour}"/>'
        for left, width in ((_TRUE_LEFT, _TRUE_WIDTH), (_LEFT, _WIDTH))
    ) + (
        f'<text x="{_LEFT + _WIDTH / 2:g}" y="{top + _STRIP - 6:g}" font-size="9" text-anchor="middle"'
        f' fill="{ink}">{words.split(maxsplit=1)[0]}</text>'
    )


def _layer(colour: str, true: tuple[float, float], drawn: tuple[float, float]) -> list[str]:
    boxes = [
        f'<rect x="{left:g}" y="{high:.3f}" width="{width:g}" height="{max(low - high, 0.3):.3f}" fill="{colour}"'
        ' fill-opacity="0.75" stroke="#ffffff" stroke-width="0.4"/>'
        for left, width, (low, high) in ((_TRUE_LEFT, _TRUE_WIDTH, true), (_LEFT, _WIDTH, drawn))
    ]
    joint = (
        f'<line x1="{_TRUE_LEFT + _TRUE_WIDTH:g}" y1="{true[1]:.3f}" x2="{_LEFT:g}" y2="{drawn[1]:.3f}"'
        ' stroke="currentColor" stroke-width="0.5" stroke-dasharray="2 2"/>'
    )
    return [*boxes, joint]


def _words(name: str, thickness: float, shown: Computed, middle: float) -> list[str]:
    first = f"{name.replace('_', ' ')}, {pretty_quantity(thickness, 'm', digits=4)}"
    lines = [
        f'<text x="{_TEXT:g}" y="{middle - 2:.1f}" font-size="11" font-weight="bold">{escape(first)}</text>'
    ]
    field = shown.found.largest_fields.get(name)
    if field is not None:
        strength, voltage = (
            pretty_quantity(each, unit, digits=3) for each, unit in ((field, "V/m"), (field * thickness, "V"))
        )
        values = f"at most {strength}, {voltage} across it"
        lines.append(f'<text x="{_TEXT:g}" y="{middle + 11:.1f}" font-size="10">{escape(values)}</text>')
    return lines
