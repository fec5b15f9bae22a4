"""Write a Trace, the result of a study or any answer as its numbers, a page, a figure or a table, by the suffix of the name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.answer import Answer
from electrovib.core.errors import InputError, suggestion
from electrovib.core.signals import is_study_result, is_trace
from electrovib.data.atomic import check_writable, output_path
from electrovib.data.marks import Form
from electrovib.data.traces import nc_content, save_mat, save_nc
from electrovib.exports.table import rows_of_table, save_csv

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import xarray

FORMATS: Final[dict[str, Callable[..., list[Path]]]] = {".nc": save_nc, ".csv": save_csv, ".mat": save_mat}
"""Suffix to writer of a Trace."""
_FORMS: Final = {".nc": Form.NETCDF, ".csv": Form.TABLE, ".mat": Form.MATLAB}
_IN_FOLDER: Final = {"trace.nc": Form.NETCDF}


def save(
    trace: xarray.Dataset | Answer, path: str | Path, *, style: str = "", force: bool = False
) -> list[Path]:
    """Write a Trace or any other result as numbers, a page, a figure or tables.

    Parameters
    ----------
    trace : xarray.Dataset or Answer
        Any Trace; the units of its signals are written anew. Or any other result that has a `document`.
    path : str or Path
        The output: of a Trace ``.nc`` (netCDF) or ``.mat`` (MATLAB), which hold everything, or ``.csv``, a table of plain
        values over time (over frequency if it has no time; of a sweep a row for each case), which is not opened as a Trace
        again. Of another result the suffix of one of its files such as ``.csv``. Of each ``.html``, its first figure as
        ``.pdf``, ``.svg`` or ``.png``, its tables as ``.tex``; without a suffix a folder with the page, all figures and files.
    style : str, optional
        Of a figure: ``"journal"`` for 85 mm in width and text of 8 pt; by default that of a page.
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

    Examples
    --------
    >>> [path.name for path in ev.save(ev.check("bau_2010/sine"), "check.json")]
    ['check.json']
    """
    from electrovib.view.files import in_style, save_answer, save_document

    path = output_path(path)
    with in_style(style, [path]):
        if is_study_result(trace) and not isinstance(trace, Answer):
            from electrovib.studies.population.answer import StudyResult

            trace = StudyResult.of(trace)
        if isinstance(trace, Answer):
            return save_answer(trace, path, force=force)
        if not is_trace(trace):
            kind = type(trace).__name__
            why = f"only a Trace or a result with a document is saved, not a {kind}; a scenario is written by its to_toml()"
            raise InputError(why, path=path)
        if not _is_document(path):
            return _writer(path)(trace, path, force=force)
        from electrovib.view.report import document_of

        document = document_of({path.stem: trace})
        return save_document(document, path, _IN_FOLDER, lambda _: nc_content(trace, path), force=force)


def check_output(
    path: str | Path,
    sizes: Mapping[str, int],
    *,
    inputs: Iterable[Path] = (),
    force: bool = False,
    shown: bool = True,
) -> None:
    """Check before a long computation that `save` can write a Trace; only the names of `sizes` count.

    Pages, figures and tables, in which a Trace is `shown`, can be refused.
    """
    path = output_path(path)
    if shown and _is_document(path):
        from electrovib.view.files import check_document

        return check_document(path, _IN_FOLDER, inputs=inputs, force=force)
    _writer(path, shown=shown)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        rows_of_table(sizes, path)
    check_writable({path: _FORMS[suffix]}, inputs=inputs, force=force)
    return None


def _is_document(path: Path) -> bool:
    from electrovib.view.files import SUFFIXES, is_file

    return path.suffix.lower() in SUFFIXES or not is_file(path)


def _writer(path: Path, *, shown: bool = True) -> Callable[..., list[Path]]:
    from electrovib.view.files import SUFFIXES

    writer = FORMATS.get(path.suffix.lower())
    if writer is None:
        near = suggestion(path.suffix.lower(), FORMATS) if path.suffix else ""
        why = f"a Trace is saved as {', '.join([*FORMATS, *(SUFFIXES if shown else ())])}, not as '{path.suffix}'.{near}"
        raise InputError(why, path=path)
    return writer
