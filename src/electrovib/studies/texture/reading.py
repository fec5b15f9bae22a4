"""Reading of textures and of paths of the finger: models, tables, TOML and data files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from electrovib.core.errors import InputError, NoColumnError, Problem, shortened
from electrovib.core.files import kind_of, note_input
from electrovib.core.model import Model
from electrovib.core.parsing import read_toml, read_toml_file
from electrovib.core.samples import Samples
from electrovib.core.units import parse_quantity
from electrovib.data.registry import read_picture
from electrovib.physics.texture.base import Texture
from electrovib.physics.texture.path import FingerPath
from electrovib.physics.texture.profile import MOST_PIXELS, GreyscalePicture
from electrovib.scenario import read_part
from electrovib.studies.check import first_columns

M = TypeVar("M", bound=Model)
TextureSource: TypeAlias = "str | Path | Mapping[str, Any] | Texture"
"""A TOML file or an inline table of TOML, a table, or a Texture."""
PathSource: TypeAlias = "str | Path | Mapping[str, Any] | FingerPath"
"""A speed as text, a file with times and positions, TOML, a table, or a FingerPath."""
_TEXTURE = '{ model = "Grating", period = "2 mm", amplitude = "1 mN" }'
_PATH = "\"30 mm/s\", path.csv with the columns time and x, or { model = \"ConstantSpeed\", speed = '30 mm/s', stroke = '2 cm' }"
_HEADINGS = (("time", "x", "y"), ("time", "x"), ("time", "position"))
"""Headings of a recorded path that are tried in a file, in this order."""


def read_texture(source: TextureSource) -> Texture:
    """Read a texture from a table, alone or as ``[texture]`` in a file, to whose folder names of files are relative."""
    if isinstance(source, Texture):
        return source
    table, folder = _table(source, "texture", _TEXTURE)
    kind = Texture.chosen(table) if isinstance(table.get("model"), str) else None
    if kind is GreyscalePicture and table.get("file") and "value_samples" not in table:
        table = table | _pixels(folder / str(table["file"]))
    return _read(Texture, table, folder, "texture")  # type: ignore[type-abstract]


def read_path(source: PathSource, texture: Texture) -> FingerPath:
    """Read the path of the finger; every mistake is reported at once.

    A speed is one stroke over the length of the texture, along x from x = 0, of a picture along its middle; a
    file has the columns ``time`` and ``x`` (or ``position``), and ``y`` if there is one.
    """
    if isinstance(source, FingerPath):
        return source
    if isinstance(source, str) and (speed := _speed(source)) is not None:
        stroke = {
            "model": "ConstantSpeed",
            "speed": speed,
            "stroke": texture.length,
            "across": texture.across,
        }
        return _read(FingerPath, stroke, Path(), "path")  # type: ignore[type-abstract]
    is_toml = isinstance(source, str) and source.lstrip().startswith("{")
    if isinstance(source, str | Path) and not is_toml and Path(source).suffix.lower() != ".toml":
        _refuse_no_file(source)
        return _recorded(Path(source), texture.across)
    table, folder = _table(source, "path", _PATH)
    return _read(FingerPath, table, folder, "path")  # type: ignore[type-abstract]


def _speed(text: str) -> float | None:
    """Return the speed that a text states [m/s]; None if it states none."""
    try:
        return parse_quantity(text, "m/s")
    except ValueError:
        return None


def _refuse_no_file(source: str | Path) -> None:
    path = Path(source)
    if not isinstance(source, str) or kind_of(path) or path.suffix.lower() in _DATA:
        return
    unit = re.fullmatch(r"[-+]?[\d.]+(?:e[-+]?\d+)?\s*([a-zA-Z]+)", source.strip())
    meant = f" Did you mean '{source.strip()}/s'?" if unit and _speed(f"{source}/s") is not None else ""
    raise InputError(
        f"neither a speed nor a file.{meant} Give {_PATH}", path="path", value=shortened(source, 60)
    )


def _table(source: object, name: str, example: str) -> tuple[dict[str, Any], Path]:
    """Return the table of a model and the folder to which names of files are relative."""
    if isinstance(source, Mapping):
        return dict(source), Path()
    if not isinstance(source, str | Path):
        why = f"expected a TOML file or a table such as {example}, not a {type(source).__name__}"
        raise InputError(why, path=name)
    if isinstance(source, str) and source.lstrip().startswith("{"):
        try:
            return dict(read_toml(f"{name} = {source}")[name]), Path()
        except ValueError as error:
            raise InputError(f"not valid TOML: {error}; for instance {example}", path=name) from None
    path = Path(source)
    if path.suffix.lower() == ".png" and name == "texture":
        if not kind_of(path):
            raise InputError("there is no such file", path=path)
        why = (
            "a picture is the file of a texture, and its size on the plate has to be given:"
            f' {{ model = "GreyscalePicture", file = "{path}", pixels_per_millimetre = 5 }}'
        )
        raise InputError(why, path=path)
    advice = f"Give a TOML file or a table such as {example}"
    content = read_toml_file(path, kind=f"a {name}", advice=advice)
    inner = content.get(name)
    return dict(inner if isinstance(inner, Mapping) else content), path.parent


def _pixels(path: Path) -> dict[str, Any]:
    note_input(path)
    values = read_picture(path, most_pixels=MOST_PIXELS)
    return {"width": values.shape[1], "value_samples": Samples(values.reshape(-1))}


def _read(kind: type[M], table: dict[str, Any], folder: Path, name: str) -> M:
    """Build a model, and name the argument in front of the path of each mistake that is not one of a file."""
    try:
        return read_part(kind, table, folder=folder)
    except InputError as error:
        raise InputError(
            each if str(each.path).endswith(_DATA) else each.within(name) for each in error.problems
        ) from None


_DATA = (".csv", ".txt", ".tsv", ".npy", ".nc", ".mat", ".png")


def _recorded(path: Path, across: float) -> FingerPath:
    """Read a path from a file with headings, or from its first two columns without them."""
    units = {"time_samples": "s", "x_samples": "m", "y_samples": "m"}
    try:
        columns = first_columns(path, _HEADINGS, units)
    except NoColumnError as error:
        raise InputError(
            Problem(each.reason.replace("'x'", "'x' or 'position'"), path=path) for each in error.problems
        ) from None
    table: dict[str, Any] = {name: Samples(values) for name, values in columns.items()} | {"across": across}
    try:
        found: FingerPath = read_part(FingerPath, {"model": "RecordedPath", **table})  # type: ignore[type-abstract]
    except InputError as error:
        raise InputError(Problem(each.reason, path=path) for each in error.problems) from None
    return found
