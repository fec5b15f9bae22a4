"""The stack as physical states: charge between the layers, polarisation in them, and series elements.

The bound displacement of a layer is that of the first layer plus the free charge between them, D_k = D_1 + Q_k, and
its field follows without the slow polarisation, E_k = (D_1 + Q_k - P_k)/(eps0 high_k). The sum of E_k times thickness
is the voltage, which gives D_1. Modes require fixed thicknesses and ohmic conduction; these states do not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.interface import INTERFACE, beside_interface, interface_place, roles_of
from electrovib.solve.stack.layer_states import StackStates
from electrovib.solve.stack.section import slabs_of
from electrovib.solve.stack.slab import Slab, merged_terms

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.stack import Layer


def stack_states(
    layers: Mapping[str, Layer],
    debye: Mapping[str, DebyeSum],
    *,
    area: float,
    element: SeriesElement,
    second: float = 0.0,
    moving: str | None = None,
) -> StackStates:
    """Return the physical states of a stack with source and return path.

    The capacitor of the body is one more element, with its current as a density over the contact area. A
    stack without a gap has one of zero thickness at its interface, `INTERFACE`: its field is that of a
    vanishing gap.
    """
    _refuse(layers, second, moving)
    roles, names = roles_of(layers), list(layers)
    slabs = slabs_of(dict(layers), dict(debye))
    place = interface_place(roles.values())
    if beside_interface(roles, "gap") is None:
        names.insert(place, INTERFACE)
        slabs.insert(place, Slab(0.0, DebyeSum(1.0, (), ()), 0.0))
    terms = [merged_terms(slab.debye) for slab in slabs]
    owners = np.concatenate([np.full(len(rates), k) for k, (rates, _) in enumerate(terms)])
    columns = np.array([[s.thickness, eps0 * s.debye.high, s.conductivity, 1 + second] for s in slabs])
    charges = [slab.charge for slab in slabs][:-1]
    if element.elastance > 0:
        columns = np.vstack([columns, [area * element.elastance * eps0, eps0, element.rate * eps0, 1.0]])
        charges.append(element.charge / area)
    thicknesses, permittivities, conductivities, repeats = columns.T
    return StackStates(
        names=tuple(names),
        thicknesses=thicknesses,
        permittivities=permittivities,
        conductivities=conductivities,
        repeats=repeats,
        leaks=tuple(
            (names.index(name), layer.leak) for name, layer in layers.items() if layer.leak is not None
        ),
        owners=owners.astype(np.intp),
        strengths=eps0 * np.concatenate([strengths for _, strengths in terms]),
        rates=np.concatenate([rates for rates, _ in terms]),
        charges=np.array(charges, dtype=float),
        area=area,
        resistance=element.resistance,
        interface=place,
        moving=None if moving is None else names.index(moving),
    )


def _refuse(layers: Mapping[str, Layer], second: float, moving: str | None) -> None:
    if moving is not None and moving not in layers:
        raise InputError(
            f"motion.distance: it is the thickness of the layer '{moving}', but the stack has only"
            f" {', '.join(layers)}; add a table stack.{moving}"
        )
    for name, layer in layers.items():
        if second and layer.leak is not None:
            raise InputError(
                f"stack.{name}.leak: with a second electrode there would be two such layers, which no solver supports; use"
                " Grounded or Floating"
            )
        if second and layer.initial_charge:
            raise InputError(
                f"stack.{name}.initial_charge: supported with one contact only; use Grounded or Floating"
            )
