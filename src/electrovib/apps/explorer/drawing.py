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
_TRUE, _ENLARGED = (4.0, 34.0), (78.0, 60.0)
"""Left edge and width of the layers to scale, and of those that are enlarged."""
_TEXT: Final = 148.0
_TOTAL: Final = 346.0


def drawing(shown: Computed) -> str:
    """Draw the layers between plate and finger as SVG.

    Left, the layers to scale. Right, with heights that grow with the logarithm of the thickness, joined by
    lines to the left; beside each layer its thickness and the largest field and voltage of the run.
    """
    thicknesses = {name: layer.thickness for name, layer in shown.scenario.stack.layers.items()}
    heights = drawn_heights(thicknesses)
    unit, total = _HEIGHT / sum(heights.values()), sum(thicknesses.values())
    colours = layer_colours(list(thicknesses))
    bottom = _STRIP + _HEIGHT
    parts = [*_strip(0.0, "finger", "#cdb9a8", "#222222"), *_strip(bottom, "plate", "#5d5d5d", "#ffffff")]
    true_low = low = bottom
    for name, thickness in thicknesses.items():
        true_high, high = true_low - _HEIGHT * thickness / total, low - unit * heights[name]
        parts += _layer(colours[name], (true_low, true_high), (low, high))
        parts += _words(name, thickness, shown, (low + high) / 2)
        true_low, low = true_high, high
    foot = _HEIGHT + 2 * _STRIP
    parts += [
        _text(_TRUE[0], foot + 11, 9, "to scale"),
        _text(_ENLARGED[0], foot + 11, 9, "enlarged where thin"),
    ]
    described = ", ".join(
        f"{name.replace('_', ' ')} {pretty_quantity(each, 'm')}" for name, each in thicknesses.items()
    )
    label = escape(f"Layers from the plate to the finger: {described}", quote=True)
    return (
        f'<svg role="img" aria-label="{label}" viewBox="0 0 {_TOTAL:g} {foot + 14:g}" width="100%" fill="currentColor"'
        f' font-family="sans-serif">{"".join(parts)}</svg>'
    )


def _strip(top: float, words: str, colour: str, ink: str) -> list[str]:
    boxes = [_box(column, top, _STRIP, colour) for column in (_TRUE, _ENLARGED)]
    middle = _ENLARGED[0] + _ENLARGED[1] / 2
    return [*boxes, _text(middle, top + _STRIP - 6, 9, words, f' text-anchor="middle" fill="{ink}"')]


def _layer(colour: str, true: tuple[float, float], drawn: tuple[float, float]) -> list[str]:
    look = ' fill-opacity="0.75" stroke="#ffffff" stroke-width="0.4"'
    boxes = [
        _box(column, high, max(low - high, 0.3), colour, look)
        for column, (low, high) in ((_TRUE, true), (_ENLARGED, drawn))
    ]
    joint = (
        f'<line x1="{sum(_TRUE):g}" y1="{true[1]:.3f}" x2="{_ENLARGED[0]:g}" y2="{drawn[1]:.3f}"'
        ' stroke="currentColor" stroke-width="0.5" stroke-dasharray="2 2"/>'
    )
    return [*boxes, joint]


def _words(name: str, thickness: float, shown: Computed, middle: float) -> list[str]:
    first = f"{name.replace('_', ' ')}, {pretty_quantity(thickness, 'm', digits=4)}"
    lines = [_text(_TEXT, middle - 2, 11, first, ' font-weight="bold"')]
    field = shown.found.largest_fields.get(name)
    if field is not None:
        strength = pretty_quantity(field, "V/m", digits=3)
        voltage = pretty_quantity(field * thickness, "V", digits=3)
        lines.append(_text(_TEXT, middle + 11, 10, f"at most {strength}, {voltage} across it"))
    return lines


def _box(column: tuple[float, float], top: float, height: float, colour: str, look: str = "") -> str:
    left, width = column
    size = f'x="{left:g}" y="{top:.3f}" width="{width:g}" height="{height:.3f}"'
    return f'<rect {size} fill="{colour}"{look}/>'


def _text(left: float, low: float, size: int, words: str, look: str = "") -> str:
    return f'<text x="{left:g}" y="{low:.1f}" font-size="{size}"{look}>{escape(words)}</text>'
