"""Selection of a variable of a MATLAB file by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from electrovib.core.errors import DataFileError, suggestion

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

Known: TypeAlias = dict[str, tuple[str, tuple[int, ...], bool]]
"""Maps the name of a variable, or the path of a field, to its kind, its shape and whether it is a real numeric array."""


def structs_on_path(wanted: str, known: Mapping[str, object]) -> Iterator[str]:
    """Iterate over the known structs on the path to a field, including the last, whose fields a message may list."""
    parts = wanted.split(".")
    for depth in range(1, len(parts) + 1):
        if (name := ".".join(parts[:depth])) in known:
            yield name


def chosen(path: Path, wanted: str, known: Known) -> str:
    """Return the name of the selected variable, or refuse with a list of what there is."""

    def listed(names: Sequence[str]) -> str:
        shown = [_described(name, *known[name][:2]) for name in names[:20]]
        return ", ".join(shown) + (", ..." if len(names) > 20 else "")

    if not known:
        raise DataFileError("holds no variables.", path=path)
    outside = [name for name in known if "." not in name]
    if wanted:
        if wanted not in known:
            above = next((name for name in reversed(list(structs_on_path(wanted, known)))), "")
            if above and not (inside := _fields(known, above)):
                raise DataFileError(
                    f"'{wanted}' cannot be reached, {_unreachable(above, *known[above][:2])}", path=path
                )
            names = inside if above else outside
            near = suggestion(wanted, names)
            what = "field" if above else "variable"
            has = f"'{above}'" if above else "It"
            raise DataFileError(
                f"there is no {what} '{wanted}'.{near} {has} has: {listed(names)}.", path=path
            )
        if not known[wanted][2]:
            fields = _fields(known, wanted)
            more = f"; name one of its fields: {listed(fields)}" if fields else ""
            raise DataFileError(
                f"'{wanted}' is no real numeric array, but {listed([wanted])}{more}.", path=path
            )
        return wanted
    arrays = [name for name in outside if known[name][2] and max(known[name][1], default=0) > 1]
    if len(arrays) != 1:
        what = "no real numeric array" if not arrays else "more than one numeric array"
        how = f"; name one, as in '{arrays[0]}[0]'" if arrays else ""
        structs = [name for name in outside if known[name][0] == "struct"]
        how = how or (f"; a field of a struct is named as in '{structs[0]}.force'" if structs else "")
        raise DataFileError(f"holds {what}{how}. It has: {listed(outside)}.", path=path)
    return arrays[0]


def _described(name: str, kind: str, shape: tuple[int, ...]) -> str:
    return f"{name} ({' x '.join(map(str, shape))} {kind})" if shape else f"{name} ({kind})"


def _fields(known: Known, name: str) -> list[str]:
    depth = name.count(".") + 1
    return [path for path in known if path.startswith(f"{name}.") and path.count(".") == depth]


def _unreachable(name: str, kind: str, shape: tuple[int, ...]) -> str:
    """Return why an entry on the path to a field has no fields."""
    if kind.startswith("object of class"):
        return f"because '{name}' is an {kind}: only MATLAB reads it; save its numbers there as arrays."
    if kind == "struct" and any(size != 1 for size in shape):
        of = " x ".join(map(str, shape))
        return f"because '{name}' is an array of {of} structs: save the one that is meant on its own."
    return f"because {_described(name, kind, shape)} is no struct with fields."
