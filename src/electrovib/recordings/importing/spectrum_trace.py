"""A measured spectrum as a Trace."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.data.spectrum import spectrum_of
from electrovib.recordings.importing.notices import about_parts
from electrovib.recordings.importing.phase_offset import phase_offset

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.data.recorded import Recorded


def spectrum_trace(
    recorded: Recorded, columns: Mapping[str, str], origin: Mapping[str, str], *, spectrum: int = 0
) -> xarray.Dataset:
    """Return a measured impedance over frequency, or a permittivity over ``frequency`` and one ``layer``, as a Trace."""
    try:
        found = spectrum_of(recorded, columns=columns, spectrum=spectrum)
    except InputError as error:
        if columns:
            raise
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise InputError(
            f"columns: name a column for each signal, such as lateral_force_measured = '{recorded.channels[-1].name}'; the file"
            f" has {listed}. It is not recognised as a spectrum either: {error.problems[0].reason}",
            path=origin["file"],
        ) from None
    diagnostics = about_parts(recorded, found)
    if found.lossless:
        diagnostics.append(
            Diagnostic(
                "loss",
                "unknown",
                "the table states a permittivity without loss; the loss was assumed to be 0",
            )
        )
    if found.impedance is not None and (offset := phase_offset(found.frequency, found.impedance)):
        text = f"{offset.sentence()}: the instrument is badly calibrated"
        diagnostics.append(Diagnostic("calibration of the instrument", "warning", text))
    history = f"{origin['file']} read by reader '{origin['reader']}'\nspectrum: {found.read_as}; sorted by frequency"
    attributes = {
        **origin,
        "history": history,
        "validity": json.dumps([each.to_dict() for each in diagnostics]),
    }
    if found.impedance is not None:
        return make_trace(
            {"impedance": (("frequency",), found.impedance)}, {"frequency": found.frequency}, attributes
        )
    assert found.permittivity is not None
    return make_trace(
        {"permittivity": (("layer", "frequency"), found.permittivity[None])},
        {"frequency": found.frequency, "layer": ["sample"]},
        attributes,
    )
