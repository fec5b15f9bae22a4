"""Texture from a greyscale picture."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.quantity import Number, Quantity
from electrovib.core.samples import Samples
from electrovib.physics.texture.base import RenderingPlate, Texture

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real

WHITE: Final = 255.0
"""Grey value that is rendered as the largest force of the hardware."""
MOST_PIXELS: Final = 4_000_000
"""Most pixels of a picture; a choice."""


class GreyscalePicture(Texture):
    """Added friction from a picture: grey value 0 is the plate's own friction, 255 the most that the hardware gives.

    Notes
    -----
    The added friction is value/255 times the largest one of the hardware. The upper left corner of the picture is x = y = 0,
    x points to the right and y downwards, as on a screen. Values apply to the centres of pixels, are bilinear between them,
    and fall to 0 within one pixel beyond the edges of the picture. Velocity has no influence.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "width": 2,
        "value_samples": [0, 255, 128, 0],
        "pixels_per_millimetre": 2,
    }

    file: Annotated[str, Field(description="png file")] = ""
    pixels_per_millimetre: Annotated[Number, Quantity("1", 1e-3, 1e4, "pixels per millimetre of the plate")]
    width: Annotated[int, Field(description="pixels of a row, 1 to 4 million, in place of a file")] = 0
    value_samples: Annotated[Samples, Field(description="grey values, row by row, in place of a file")] = (
        Samples([])
    )

    @model_validator(mode="after")
    def _is_a_picture(self) -> Self:
        values = self.value_samples.values
        why = ""
        if not len(values):
            why = 'holds no pixels: name a picture, for instance file = "texture.png"'
        elif not 1 <= self.width <= MOST_PIXELS or len(values) % self.width or len(values) > MOST_PIXELS:
            why = f"{len(values)} pixels are no rows of {self.width}; width must divide them, and {MOST_PIXELS} are allowed"
        elif not np.all((values >= 0) & (values <= WHITE)):
            why = "grey values lie between 0 and 255"
        if why:
            raise PydanticCustomError("picture", "{why}", {"why": why})
        return self

    @functools.cached_property
    def _table(self) -> tuple[Real, int, Real, Real]:
        """Return shares of the largest force with zeros around them, row by row; columns; largest place; last pixel."""
        shares = np.pad(self.value_samples.values.reshape(-1, self.width) / WHITE, 1)
        rows, columns = shares.shape
        highest = np.array([columns - 1.0, rows - 1.0])
        return shares.reshape(-1), columns, highest, highest - 1

    @property
    def length(self) -> float:
        """Width of the picture [m]."""
        return self.width * self.pixel

    @property
    def height(self) -> float:
        """Height of the picture [m]."""
        return len(self.value_samples) // self.width * self.pixel

    @property
    def across(self) -> float:
        """Half the height of the picture [m]."""
        return self.height / 2

    @property
    def pixel(self) -> float:
        """Side of a pixel [m]."""
        return 1e-3 / self.pixels_per_millimetre

    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return the share of the picture times the largest added friction [N]."""
        del velocity
        shares, columns, highest, last_pixel = self._table
        # pixel 0 has its centre at half a pixel and is number 1 of the padded picture
        place = np.maximum(np.minimum(position * (1 / self.pixel) + 0.5, highest), 0.0)
        pixel = np.minimum(place, last_pixel).astype(np.intp)
        right, down = (place - pixel).T
        corner = pixel[:, 0] + pixel[:, 1] * columns
        upper, lower = shares[corner], shares[corner + columns]
        upper += right * (shares[corner + 1] - upper)
        lower += right * (shares[corner + (columns + 1)] - lower)
        return np.asarray(plate.largest_added_friction * (upper + down * (lower - upper)))
