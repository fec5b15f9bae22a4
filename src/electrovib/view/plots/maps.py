"""Maps of a rough contact, over one period of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import number_in
from electrovib.view.style import COLOURS, drawing
from electrovib.view.units import label_axis, pretty_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from electrovib.studies.rough_contact import RoughContact

MAP_SIZE: Final = (5.2, 4.4)
"""Width and height of the figure [inch]."""
_MAPS: Final = {
    "gap": ("gap", "m"),
    "pressure": ("pressure of the contact", "Pa"),
    "attraction": ("attraction", "Pa"),
}
_COARSE: Final = 512
"""Points along a side that are drawn; of a finer grid every nth."""


def contact_map(
    found: RoughContact, *, quantity: str = "gap", voltage: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the gap, the pressure of the contact or the attraction over one period of a rough contact.

    Parameters
    ----------
    found : RoughContact
        From `electrovib.rough_contact`.
    quantity : str
        ``"gap"``, ``"pressure"`` or ``"attraction"``.
    voltage : float, optional
        One of the voltages [V], the last time that the contact was there; by default the one that is largest in size.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Places in SI, with a bar of colours. In a map of the gap the places that touch have a colour of their own.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> found = ev.rough_contact("bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e7), voltage=20.0)
    >>> ev.plot.contact_map(found).get_xlabel()
    'along the plate [mm]'
    """
    if quantity not in tuple(_MAPS):
        raise InputError(f"quantity = {quantity!r}: expected one of {', '.join(_MAPS)}")
    at = found.at_largest_voltage if voltage is None else _place(found, number_in("V", "voltage", voltage))
    rest = found.rests[at]
    values = getattr(rest, quantity)
    every = -(-values.shape[0] // _COARSE)
    shown = np.ma.masked_where(rest.pressure > 0, values) if quantity == "gap" else values
    across, along = found.roughness.periods
    with drawing(ax, MAP_SIZE) as axes:
        axes.set_facecolor(COLOURS[1])
        image = axes.imshow(
            shown[::every, ::every], origin="lower", extent=(0.0, along, 0.0, across), cmap="Blues", vmin=0.0
        )
        axes.grid(visible=False)
        label_axis(axes.xaxis, "along the plate", "m")
        label_axis(axes.yaxis, "across the plate", "m")
        bar = axes.figure.colorbar(image, ax=axes)
        label_axis(bar.ax.yaxis, *_MAPS[quantity])
        colour = " (orange)" if quantity == "gap" else ""
        held = pretty_quantity(float(found.voltage[at]), "V")
        axes.set_title(f"{held}: {100 * rest.contact_share:.3g} % of the area touch{colour}")
        return axes


def _place(found: RoughContact, voltage: float) -> int:
    """Return the last place at which the contact was under a voltage."""
    places = np.flatnonzero(np.isclose(found.voltage, voltage, rtol=1e-9, atol=0.0))
    if not places.size:
        known = ", ".join(f"{each:g}" for each in dict.fromkeys(found.voltage.tolist()))
        raise InputError(f"voltage = {voltage:g} V: the contact was computed at {known} V")
    return int(places[-1])
