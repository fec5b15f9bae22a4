"""Files of netCDF (of version 4, which is HDF5, and of the classic one) and HDF5: variables, and arrays in groups.

What looks into a file of HDF5 is called in a guarded process, unless the file is known to be whole.
"""

from __future__ import annotations

import functools
import math
import re
import warnings
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.data.array_columns import chosen_columns, table_of_arrays
from electrovib.data.guarded import Reader, check_file, packed, read_by_library, read_guarded
from electrovib.data.recorded import CanRead, FileFormat, NotRead
from electrovib.data.unit_words import name_and_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

    from electrovib.data.recorded import DataColumn, Recorded

_CLASSIC: Final = b"CDF"
_OF_THE_FORMAT: Final = {
    "CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS", "_Netcdf4Dimid", "_Netcdf4Coordinates",
    "_nc3_strict", "_NCProperties",
}  # fmt: skip
"""Attributes that the format itself needs."""
_NO_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable"
_UNITS: Final = ("units", "unit", "Units", "Unit")
_TIMES: Final = {"seconds": "s", "milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns"}
_PACKING: Final = ("scale_factor", "add_offset", "_FillValue", "missing_value")
_RANGE: Final = ("valid_range", "valid_min", "valid_max")
_FILTERS: Final = {
    307: "bzip2", 32000: "lzf", 32001: "blosc", 32004: "lz4", 32008: "bitshuffle", 32013: "zfp", 32015: "zstd", 32017: "sz",
    32018: "fcidecomp", 32024: "sz3", 32026: "blosc2",
}  # fmt: skip
"""Filters by the numbers under which they are registered with the HDF Group."""
_FACTOR: Final = re.compile(
    r"(?i)gain|scale|scaling|slope|conversion|y_?inc(rement)?|y_?mult|lsb|volts_?per_?\w+"
)
"""Attributes by which programs other than those of netCDF say what the stored numbers are to be multiplied by."""
_ELSEWHERE: Final = "is a link to another place, which is not followed; copy its numbers into this file"
_OUTSIDE: Final = "outside the valid range that the file states"
_NOT_APPLIED: Final = (
    "it is not applied to '{name}', whose unit is left open; state the unit, and the factor as scale"
)
_BLOCK: Final = 1 << 20
_MOST_OBJECTS: Final = 2000
_DEEPEST: Final = 12
_TOO_MANY: Final = f"is beyond the first {_MOST_OBJECTS} objects, or {_DEEPEST} groups deep"


_READER: Final = Reader(f"{__name__}:variables", ("h5py",), "a netCDF file")


def contents(path: Path, *, is_whole: bool = False, **arguments: Any) -> dict[Any, Any]:
    """Return what `variables` yields; of HDF5 from a guarded process, unless the file `is_whole`."""
    check_file(path)
    with path.open("rb") as file:
        is_classic = file.read(len(_CLASSIC)) == _CLASSIC
    if is_classic or is_whole:
        return read_by_library(lambda: dict(variables(path, **arguments)), path, _READER.format_name)
    return read_guarded(_READER, path, **arguments)


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read variables by name; their attribute ``units`` has priority over a unit in the name."""
    del missing
    names = [each for each in columns if isinstance(each, str)]
    content = contents(path, wanted=names if len(names) == len(columns) else None)
    return chosen_columns((each[:3] for each in _arrays(content)), columns)


def read_hdf5(path: Path, *, part: str = "") -> Recorded:
    """Read the arrays of a netCDF or HDF5 file that have the length with most numbers, or that of the array `part`."""
    arrays = list(_arrays(contents(path)))
    clocks = {name: dimension for name, *_, dimension, _ in arrays}
    found = table_of_arrays([each[:3] for each in arrays], part=part, clocks=clocks)
    return replace(found, not_read=(*found.not_read, *(note for *_, notes in arrays for note in notes)))


def _arrays(content: dict[Any, Any]) -> Iterator[tuple[str, str, NDArray[Any] | str, str, list[NotRead]]]:
    """Iterate over name, unit and values of each variable, its first dimension, and what of it is not read.

    Whole numbers with a factor that netCDF does not know are left as they are stored, without a unit.
    """
    for name in [each[1] for each in content if each[0] == "about"]:
        about = content["about", name]
        group, _, last = name.rpartition("/")
        own, stated = name_and_unit(last)
        label = f"{group}/{own}" if group else own
        unit = str(next((about["attributes"][key] for key in _UNITS if key in about["attributes"]), stated))
        raw = content.pop(("values", name), None)
        values, beyond = decoded(about, raw)
        factor = "" if raw is None or raw.dtype.kind not in "iu" else _factor(about)
        notes = [NotRead(name=f"{beyond} values of {label}", why=_OUTSIDE)] if beyond else []
        notes += [NotRead(name=factor, why=_NOT_APPLIED.format(name=label))] if factor else []
        yield label, "" if factor else _TIMES.get(unit, unit), values, "".join(about["dims"][:1]), notes


def _factor(about: Mapping[str, Any]) -> str:
    """Return the attribute that states a factor of a variable which is not applied, with its value; empty if there is none."""
    for name, value in {**about["group"], **about["attributes"]}.items():
        if _FACTOR.fullmatch(name) and isinstance(value, (int, float)) and value not in (0, 1):
            return f"attribute {name} = {value:.6g}"
    return ""


def decoded(about: Mapping[str, Any], raw: NDArray[Any] | None) -> tuple[NDArray[Any] | str, int]:
    """Unpack a variable as xarray does, or say why not; numbers outside the valid range are missing, and counted."""
    if raw is None:
        return str(about["refusal"]), 0
    packing = {name: np.array(numbers, dtype) for name, (dtype, numbers) in about["packing"].items()}
    ends = {name: packing.pop(name) for name in _RANGE if name in packing}
    attributes: dict[str, Any] = {
        name: each.ravel()[0] if each.size == 1 else each for name, each in packing.items()
    }
    if raw.dtype.kind == "f" and np.isnan(attributes.get("_FillValue", 0.0)).all():
        del attributes["_FillValue"]  # NaN is missing already
    text = about["attributes"]
    attributes |= {name: text[name] for name in ("_Unsigned", "calendar") if name in text}
    if " since " in str(text.get("units", "")):
        attributes["units"] = text["units"]
    try:
        values = _by_xarray(raw, attributes) if attributes else raw
    except (ValueError, TypeError, OverflowError, LookupError, ArithmeticError, ImportError) as error:
        said = str(error).partition("\n")[0][:120]
        return f"cannot be decoded as its attributes state ({said})", 0
    if not ends or values.dtype.kind not in "fiu":
        return values, 0
    beyond = _beyond(raw, values, ends, is_unsigned=text.get("_Unsigned") == "true")
    return np.where(beyond, np.nan, values), int(beyond.sum())


def _by_xarray(raw: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[Any]:
    """Decode blocks that fit into the cache of the processor, which is faster than all at once."""
    import xarray

    flat, found = raw.reshape(-1), None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of attributes that contradict each other
        for start in range(0, flat.size, _BLOCK):
            block = xarray.Dataset({"block": ("row", flat[start : start + _BLOCK], attributes)})
            values = xarray.decode_cf(block, decode_timedelta=False)["block"].values
            if found is None:
                found = np.empty(flat.shape, float if values.dtype.kind in "fiu" else values.dtype)
            found[start : start + _BLOCK] = values
    return raw if found is None else found.reshape(raw.shape)


def _beyond(
    raw: NDArray[Any], values: NDArray[Any], ends: Mapping[str, NDArray[Any]], *, is_unsigned: bool
) -> NDArray[np.bool_]:
    """Return which numbers are outside the valid range, stated of the packed ones, or of the unpacked ones by floats."""
    low, high = ends.get("valid_range", [ends.get("valid_min"), ends.get("valid_max")])
    outside = np.zeros(values.shape, bool)
    for stated, is_outside in ((low, np.less), (high, np.greater)):
        end, of = np.asarray(stated), values
        if end.dtype.kind in "iu" and raw.dtype.kind in "iu":
            wide = raw.dtype.str.replace("i", "u") if is_unsigned else raw.dtype
            end, of = end.astype(raw.dtype).view(wide), raw.view(wide)
        if stated is not None:
            outside |= is_outside(of, end) & ~np.isnan(values)
    return outside


@dataclass(frozen=True, kw_only=True)
class NetcdfVariable:
    """A variable that is not yet read.

    The type is ``object`` for texts. `stated` are its attributes, `dimensions` returns the names of the
    dimensions, and `read` the numbers, or the texts as nested lists. `group` are the attributes of its
    group, `refusal` is the reason why the variable must not be read, `filters` say how it is compressed.
    """

    shape: tuple[int, ...] = ()
    dtype: np.dtype[Any] = np.dtype(object)  # noqa: RUF009  # is never changed
    stated: Mapping[str, Any] = field(default_factory=dict)
    dimensions: Callable[[], list[str]] = list
    read: Callable[[], NDArray[Any] | list[Any] | str] = str
    group: Mapping[str, Any] = field(default_factory=dict)
    refusal: str = ""
    filters: str = ""


def variables(
    path: Path, wanted: Sequence[str] | None = None, texts: bool = False
) -> Iterator[tuple[Any, Any]]:
    """Yield the attributes of the file, and what each variable is, and its values as stored, or why they are not read."""
    left = content_allowed(path.stat().st_size)
    with _opened(path) as (found, attributes):
        yield "attributes", attributes
        for name, variable in found.items():
            about: dict[str, Any] = {"attributes": {}, "packing": {}, "dims": [], "shape": variable.shape}
            about |= {
                "text": variable.dtype.kind in "OSU",
                "refusal": _refusal(variable, name, wanted, texts=texts),
            }
            if not about["refusal"]:
                declared = math.prod(variable.shape) * variable.dtype.itemsize
                left -= declared
                if left < 0:
                    size = megabytes(path.stat().st_size)
                    raise packed(path, f"'{name}' declares {megabytes(declared)} in a file of {size}")
                about |= {"attributes": _attributes(variable.stated), "packing": _packing(variable.stated)}
                about |= {"dims": variable.dimensions(), "group": _attributes(variable.group, _FACTOR)}
                try:
                    values = variable.read()
                except OSError:
                    if not variable.filters:
                        raise
                    about["refusal"] = variable.filters
            yield ("about", name), about
            if not about["refusal"]:
                yield ("values", name), values


def _refusal(variable: NetcdfVariable, name: str, wanted: Sequence[str] | None, *, texts: bool) -> str:
    if wanted is not None and not any(each.startswith(name_and_unit(name)[0]) for each in wanted):
        return "is not asked for"
    if variable.dtype.kind in "fiubc" or texts:
        return variable.refusal
    return variable.refusal or ("holds text" if variable.dtype.kind in "OSU" else "holds no numbers")


@contextmanager
def _opened(path: Path) -> Iterator[tuple[dict[str, NetcdfVariable], dict[str, Any]]]:
    """Open a file; yield its variables, also those in groups and the fields of records, and its attributes."""
    with path.open("rb") as file:
        classic = file.read(3) == _CLASSIC
    if classic:
        import scipy.io

        with scipy.io.netcdf_file(path, "r", mmap=False, maskandscale=False) as old:
            # there is no other access to the attributes
            yield dict(_of_classic(old.variables)), _attributes(old._attributes)  # noqa: SLF001
        return
    import h5py

    with h5py.File(path, "r") as new:
        yield dict(_in_groups(new)), _attributes(new.attrs)


def _of_classic(variables: Mapping[str, Any]) -> Iterator[tuple[str, NetcdfVariable]]:
    for name, entry in variables.items():
        yield (
            name,
            NetcdfVariable(
                shape=tuple(entry.shape),
                dtype=np.dtype(object) if entry.data.dtype.kind == "S" else entry.data.dtype,
                stated=entry._attributes,  # noqa: SLF001
                dimensions=functools.partial(list, entry.dimensions),
                read=functools.partial(getattr, entry, "data"),
            ),
        )


def _in_groups(file: h5py.File) -> Iterator[tuple[str, NetcdfVariable]]:
    """Iterate over the variables of a file, those of a group before those of the groups in it; links are not followed."""
    import h5py

    waiting: list[tuple[str, h5py.Group, int]] = [("", file, 0)]
    count = 0
    for prefix, group, depth in waiting:
        for name in group:
            count, place = count + 1, f"{prefix}{name}"
            if count > _MOST_OBJECTS or depth > _DEEPEST:
                yield place, NetcdfVariable(refusal=_TOO_MANY)
                return
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                yield place, NetcdfVariable(refusal=_ELSEWHERE)
                continue
            entry = group[name]
            if isinstance(entry, h5py.Group):
                waiting.append((f"{place}/", entry, depth + 1))
            elif isinstance(entry, h5py.Dataset):
                label = _text(entry.attrs.get("NAME", ""))
                yield from () if label.startswith(_NO_VARIABLE) else _dataset(file, place, entry)


def _dataset(file: h5py.File, place: str, entry: h5py.Dataset) -> Iterator[tuple[str, NetcdfVariable]]:
    """Yield a dataset, or the fields of one of records, read at once."""
    import h5py

    is_text, refusal = h5py.check_string_dtype(entry.dtype) is not None, ""
    if entry.external or entry.is_virtual:  # numbers in another file, which could be any file of the computer
        refusal = _ELSEWHERE
    elif entry.shape is None:
        refusal = "is empty"
    elif entry.size and not entry.id.get_storage_size():
        refusal = f"declares {entry.size} numbers and holds none"
    elif entry.dtype.kind == "O" and not is_text:
        refusal = "holds references, or rows of several lengths"
    if refusal:
        yield place, NetcdfVariable(refusal=refusal)
        return
    whole = functools.cache(lambda: _texts(entry) if is_text else np.asarray(entry[()]))
    variable = NetcdfVariable(
        shape=entry.shape,
        dtype=np.dtype(object) if is_text else entry.dtype,
        stated=entry.attrs,
        dimensions=lambda: _dimensions(file, place.rpartition("/")[2], entry),
        read=whole,
        group=entry.parent.attrs,
        filters=_filters(entry),
    )
    if not entry.dtype.names:
        yield place, variable
    for name, (kind, *_) in (entry.dtype.fields or {}).items():
        read, shape = functools.partial(lambda name: whole()[name], name), (*entry.shape, *kind.shape)
        yield f"{place}.{name}", replace(variable, shape=shape, dtype=kind.base, read=read)


def _texts(entry: h5py.Dataset) -> list[Any] | str:
    values = entry.asstr(errors="replace")[()]
    return str(values) if isinstance(values, str) else list(values.tolist())


def _filters(entry: h5py.Dataset) -> str:
    """Say by which filters a dataset is compressed that are not there; empty if all are."""
    import h5py

    plan = entry.id.get_create_plist()
    codes = [plan.get_filter(at)[0] for at in range(plan.get_nfilters())]
    missing = [code for code in codes if not h5py.h5z.filter_avail(code)]
    named = " and ".join(f"{code} ({_FILTERS.get(code, 'of no common name')})" for code in missing)
    why = f"is compressed with filter {named}, which the HDF5 library here does not have"
    return f"{why}; where it was written: h5repack -f GZIP=4 OLD NEW" if missing else ""


def _dimensions(file: h5py.File, name: str, entry: h5py.Dataset) -> list[str]:
    """Return the names of the dimensions: those of the attached scales, or its own if the variable is a scale."""
    if "DIMENSION_LIST" in entry.attrs:
        scales = [file[references[0]] for references in entry.attrs["DIMENSION_LIST"] if len(references)]
        found = [str(scale.name).rpartition("/")[2] for scale in scales]
    else:
        found = [name] * len(entry.shape)
    return found if len(found) == len(set(found)) == len(entry.shape) else []


def _attributes(stated: Mapping[str, Any], form: re.Pattern[str] | None = None) -> dict[str, Any]:
    """Read attributes, of a `form` if one is given; one that is damaged, or of a type of its own, is left out."""
    found = {}
    for name in stated:
        if name not in _OF_THE_FORMAT and (form is None or form.fullmatch(name)):
            with suppress(OSError, RuntimeError, ValueError, LookupError, TypeError):
                found[name] = _plain(stated[name])
    return found


def _packing(stated: Mapping[str, Any]) -> dict[str, tuple[str, Any]]:
    """Read the numbers that say how a variable is packed, each with its type; a damaged one is a fault of the file."""
    numbers = {name: np.asarray(stated[name]) for name in (*_PACKING, *_RANGE) if name in stated}
    return {
        name: (each.dtype.str, each.tolist()) for name, each in numbers.items() if each.dtype.kind in "fiu"
    }


def _plain(value: Any) -> Any:
    """Return an attribute as a text, a number or a list."""
    if isinstance(value, (str, bytes)):
        return _text(value)
    if isinstance(value, (np.ndarray, np.generic)) and np.asarray(value).dtype.kind in "fiubSUO":
        listed = np.asarray(value).reshape(-1).tolist()
        plain = [_text(item) if isinstance(item, (str, bytes)) else item for item in listed]
        if all(isinstance(item, (str, int, float)) for item in plain):
            return plain[0] if len(plain) == 1 else plain
    return ""


def _text(value: str | bytes) -> str:
    """Decode a text; bytes that are no UTF-8 become replacement characters."""
    raw = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else bytes(value)
    return raw.decode("utf-8", "replace")


def _can_read(head: bytes, suffix: str) -> CanRead:
    if suffix != ".mat" and (
        head.startswith((b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02")) or head[512:516] == b"\x89HDF"
    ):
        return CanRead.NO if head.startswith(b"MATLAB") else CanRead.YES
    return CanRead.PERHAPS if suffix in (".nc", ".h5", ".hdf5") else CanRead.NO


FORMAT: Final = FileFormat(
    name="hdf5",
    description="netCDF and HDF5 (.nc, .h5, .hdf5): arrays of one or two dimensions",
    can_read=_can_read,
    read=read_hdf5,
    columns=read_columns,
    options=("part",),
)
