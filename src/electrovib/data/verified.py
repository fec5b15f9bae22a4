"""Whether the files of a Trace are as they were written: each carries a checksum of its content, in its mark."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import DataFileError
from electrovib.data.marks import WRITTEN_BY, is_marked, is_ours

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import xarray

    from electrovib.data.marks import Form

VERIFIED: Final = "checksum"
"""Name of the diagnostic of a Trace that could not be verified."""


def verified(trace: xarray.Dataset, files: Mapping[Path, Form]) -> xarray.Dataset:
    """Return a Trace that was read; one whose files were changed is refused, and one without a checksum says so."""
    for path in (path for path, form in files.items() if not is_ours(path, form)):
        if is_marked(path, files[path]):
            raise DataFileError(
                "is damaged, or was edited: its content is not that of its checksum. Make it again; a file that was edited on"
                f" purpose is read, not verified, without its line '# {WRITTEN_BY}: ...' (.csv) or its attribute {WRITTEN_BY}",
                path=path,
            )
        why = f"not verified: {path.name} states no checksum, so that damage of its numbers would not be noticed"
        told = [
            *json.loads(trace.attrs.get("validity", "[]")),
            Diagnostic(VERIFIED, "warning", why).to_dict(),
        ]
        trace.attrs["validity"] = json.dumps(told)
    return trace
