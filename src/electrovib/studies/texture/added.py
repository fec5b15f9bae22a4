"""Added friction of a texture, which may be the user's own model, called and checked."""

from __future__ import annotations

import math
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.texture.base import RenderingPlate, Texture


def added_friction(texture: Texture, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
    """Return the added friction of a texture, which is given copies; NaN where the model returned NaN or infinity."""
    try:
        found: Any = texture.added_friction(position.copy(), velocity.copy(), plate)
    except Exception as error:
        raise failure(texture, error) from error
    try:
        force = np.asarray(found)
    except Exception as error:
        raise _unsuitable(texture, f"a {type(found).__name__} that is no array of numbers") from error
    if force.dtype.kind not in "buif":
        what = "complex numbers" if force.dtype.kind == "c" else f"a {type(found).__name__}"
        raise _unsuitable(texture, what)
    if force.shape != (len(position),):
        raise _unsuitable(texture, f"an array of shape {force.shape}")
    force = force.astype(float)
    force[~np.isfinite(force)] = np.nan
    return force


def _unsuitable(texture: Texture, what: str) -> InputError:
    """Return the error of a texture that returned something else than one real number for each position."""
    return InputError(
        f"the model '{type(texture).__name__}' returned {what}, and an array of real numbers, one force for each position, is"
        " needed",
        path="texture",
    )


def failure(texture: Texture, error: Exception) -> InputError:
    """Return the error of a texture that raised an exception, with the last line of the model's file that led to it."""
    kind = type(texture)
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    where = f" ({Path(str(file)).name}, line {lines[-1]})" if lines else ""
    words = f": {error}" if str(error) else ""
    return InputError(
        f"the model '{kind.__name__}' raised {type(error).__name__}{words}{where}", path="texture"
    )


def place_across(texture: Texture) -> float:
    """Return the place y of a stroke along x where no other is given [m]."""
    try:
        found = float(texture.across)
    except Exception as error:
        raise failure(texture, error) from error
    if not math.isfinite(found):
        name = type(texture).__name__
        raise InputError(
            f"the model '{name}' has across = {found}, and a place in metres is needed", path="texture"
        )
    return found
