"""Write a Trace in the format of the suffix of the file name, the bands of a study as CSV, or any answer as page and files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.answer import Answer
from electrovib.core.errors import InputError, suggestion
from electrovib.core.signals import is_study_result, is_trace
from electrovib.data.atomic import check_writable, output_path
from electrovib.data.marks import Form
from electrovib.data.trace_csv import csv_files, csv_forms, save_csv
from electrovib.data.traces import save_mat, save_nc

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import xarray

FORMATS: Final[dict[str, Callable[..., list[Path]]]] = {".nc": save_nc, ".csv": save_csv, ".mat": save_mat}
"""Suffix to writer."""
_PICTURES: Final = (".png", ".svg", ".pdf", ".html", ".jpg")
_FORMS: Final = {".nc": Form.NETCDF, ".mat": Form.MATLAB}


def save(trace: xarray.Dataset | Answer, path: str | Path, *, force: bool = False) -> list[Path]:
    """Write a Trace, or the result of a comparison, a check, a fit, a sensitivity analysis or a design.

    Parameters
    ----------
    trace : xarray.Dataset or Answer
        Any Trace; the units of its signals are written anew. Or the result of a study, whose bands are written as CSV. Or
        any other result that has a `document`.
    path : str or Path
        The output: of a Trace ``.nc`` (everything, netCDF), ``.csv`` (one dimension a file) or ``.mat`` (MATLAB); of
        another result ``.html``, the suffix of one of its files such as ``.csv``, or a folder for the page and all files.
    force : bool
        Whether a file that was not written by electrovib may be replaced.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written or would replace one that electrovib did not write in this
        form, or the format cannot hold this Trace.
    """
    path = output_path(path)
    if isinstance(trace, Answer):
        from electrovib.view.documents import save_answer

        return save_answer(trace, path, force=force)
    if is_study_result(trace):
        from electrovib.studies.population.result import save_bands

        return save_bands(trace, path, force=force)
    if not is_trace(trace):
        kind = type(trace).__name__
        why = f"only a Trace or a result with a document is saved, not a {kind}; a scenario is written by its to_toml()"
        raise InputError(why, path=path)
    return _writer(path)(trace, path, force=force)


def check_output(
    path: str | Path, sizes: Mapping[str, int], *, inputs: Iterable[Path] = (), force: bool = False
) -> None:
    """Check before a long computation that `save` can write the output; only the names of `sizes` count."""
    path = output_path(path)
    _writer(path)
    suffix = path.suffix.lower()
    forms = csv_forms(csv_files(sizes, path)) if suffix == ".csv" else {path: _FORMS[suffix]}
    check_writable(forms, inputs=inputs, force=force)


def _writer(path: Path) -> Callable[..., list[Path]]:
    writer = FORMATS.get(path.suffix.lower())
    if writer is None:
        near = suggestion(path.suffix.lower(), FORMATS) if path.suffix else ""
        if path.suffix.lower() in _PICTURES:
            near = " Figures are in the report, --report report.html; ev.plot draws one in Python."
        why = f"a Trace is saved as {', '.join(FORMATS)}, not as '{path.suffix}'.{near}"
        raise InputError(why, path=path)
    return writer
