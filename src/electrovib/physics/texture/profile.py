"""Textures measured along a line, heights of a surface or recorded friction, or taken from a greyscale picture."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.files import UNREAD
from electrovib.core.quantity import ColumnName, Number, Quantity, column_unit
from electrovib.core.samples import Samples, fault_of_record
from electrovib.physics.texture.base import RenderingPlate, Texture, TextureAlongLine

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real


_SHORTEST: Final = 1e-9
_NAME_ONE: Final = 'name the record, for instance file = "profile.csv"'
_LONGEST: Final = 10.0
"""Shortest step and longest extent of a profile [m]."""
_SCALE = Quantity("1", 0, 1e3, "factor of the recorded variation", "no scaling")


class MeasuredTexture(TextureAlongLine, family=True):
    """Values recorded at increasing positions along a line.

    Notes
    -----
    Positions count from the first one. The file has a column of positions and one of values.
    """

    value_field: ClassVar[str] = ""
    """Parameter that holds the values, without ``_samples``."""

    file: Annotated[str, Field(description="csv, npy or nc file with the record")] = ""
    position_column: ColumnName = "position"
    position_unit: Annotated[str, column_unit("m"), Field(description="unit of the column")] = "m"
    position_samples: Annotated[Samples, Field(description="positions [m], in place of a file")] = Samples([])

    @model_validator(mode="after")
    def _is_a_record(self) -> Self:
        _check(self.position_samples.values, self._values, self.value_field, self.file)
        return self

    @property
    def _values(self) -> Real:
        samples: Samples = getattr(self, f"{self.value_field}_samples")
        return samples.values

    @functools.cached_property
    def _places(self) -> Real:
        """Positions from the first one [m]."""
        stated = self.position_samples.values
        return np.asarray(stated - stated[0])

    @property
    def length(self) -> float:
        """Extent of the record [m]."""
        return float(self._places[-1])

    def _faded(self, values: Real) -> tuple[Real, Real]:
        """Return places and values that fall to 0 within one sample distance beyond either end."""
        places = self._places
        first, last = places[0] - (places[1] - places[0]), 2 * places[-1] - places[-2]
        return np.concatenate([[first], places, [last]]), np.concatenate([[0.0], values, [0.0]])


class HeightProfile(MeasuredTexture):
    """Added friction proportional to the rising slope of a height profile (gradient mapping).

    Notes
    -----
    F = gain F_n max(0, h'(s) m), with the load F_n, the slope h' of the profile and the direction of sliding m, which is 1 or
    -1 from the speed `slow` on and proportional to the speed below it. Downhill the plate's own friction remains, because
    attraction cannot reduce friction. That friction follows the local slope of the rendered surface is the idea of Kim, Israr
    and Poupyrev 2013 (of which only the abstract was read); their relation of voltage and friction is not used. The factor is
    a choice: with gain = 1 the force is that of a frictionless slope, F_n h' for small slopes.
    Slopes are central differences of the heights, linear between the positions, and fall to 0 within one step beyond the ends.
    """

    value_field: ClassVar[str] = "height"
    equation: ClassVar[Mapping[str, str]] = {
        "along": "vectors[x]*cos(angle) + vectors[y]*sin(angle)",
        "direction": "Max(-1, Min(1, along(velocity)/slow))",
        "added_friction": "gain*plate.normal_force*Max(0, slope(position)*direction)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "position_samples": [0, 1e-3, 2e-3],
        "height_samples": [0, 1e-5, 0],
    }

    height_column: ColumnName = "height"
    height_unit: Annotated[str, column_unit("m"), Field(description="unit of the column")] = "m"
    height_samples: Annotated[Samples, Field(description="heights [m], in place of a file")] = Samples([])
    gain: Annotated[Number, Quantity("1", 0, 1e3, "friction force over load and slope", "a choice")] = 1.0
    slow: Annotated[
        Number, Quantity("m/s", 1e-6, 1, "speed below which the slope counts in part", "a choice")
    ] = 1e-3

    @functools.cached_property
    def _slopes(self) -> tuple[Real, Real]:
        """Places [m] and slopes [1], which fall to 0 beyond the ends."""
        heights, places = self._values, self._places
        slopes = np.gradient(heights, places, edge_order=2 if len(places) > 2 else 1)
        return self._faded(slopes)

    def slope(self, position: Real) -> Real:
        """Return the slope of the profile.

        Parameters
        ----------
        position : ndarray, shape (n, 2)
            Places x and y of the finger [m].

        Returns
        -------
        slope : ndarray, shape (n,)
            Rise of the height over the distance [1]; 0 beyond the ends of the profile.
        """
        return np.asarray(np.interp(self.along(position), *self._slopes))

    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return gain F_n max(0, h' m) [N]."""
        slope = self.slope(position)
        direction = np.maximum(np.minimum(self.along(velocity) / self.slow, 1.0), -1.0)
        return np.asarray(self.gain * plate.normal_force * np.maximum(slope * direction, 0.0))


class FrictionRecord(MeasuredTexture, family=True):
    """Recorded friction that is replayed above the plate's own friction.

    Notes
    -----
    Values are linear between the positions, and the added friction falls to 0 within one step beyond the ends.
    """

    scale: Annotated[Number, _SCALE] = 1.0

    if TYPE_CHECKING:
        baseline: float | None

    @functools.cached_property
    def _added(self) -> tuple[Real, Real]:
        """Places and values above the baseline, times the scale."""
        values = self._values
        lowest = float(np.min(values)) if self.baseline is None else self.baseline
        return self._faded(self.scale * (values - lowest))

    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return what is recorded above the baseline, times the scale [N]; of a coefficient times the load."""
        del velocity, plate
        return np.asarray(np.interp(self.along(position), *self._added))


class RecordedFrictionForce(FrictionRecord):
    """Replay of a recorded friction force.

    Notes
    -----
    F = scale (F_recorded(s) - baseline). In a published replay of recorded friction the variation had to be scaled about
    threefold (fine textures) to fivefold (coarse ones) to match the real texture (doi 10.1109/TOH.2021.3130091, abstract only).
    """

    value_field: ClassVar[str] = "friction_force"
    equation: ClassVar[Mapping[str, str]] = {
        "along": "vectors[x]*cos(angle) + vectors[y]*sin(angle)",
        "place": "position_samples[first] + along(position)",
        "recorded": "interpolated(place, position_samples, friction_force_samples)",
        "added_friction": "scale*(recorded - baseline)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "position_samples": [0, 1e-3, 2e-3],
        "friction_force_samples": [0.25, 0.26, 0.25],
    }

    friction_force_column: ColumnName = "friction_force"
    friction_force_unit: Annotated[str, column_unit("N"), Field(description="unit of the column")] = "N"
    friction_force_samples: Annotated[Samples, Field(description="forces [N], in place of a file")] = Samples(
        []
    )
    baseline: Annotated[
        Number | None,
        Quantity("N", -1e3, 1e3, "recorded force rendered as the plate's own friction; the lowest if absent"),
    ] = None


class RecordedFrictionCoefficient(FrictionRecord):
    """Replay of a recorded coefficient of friction.

    Notes
    -----
    F = scale (mu_recorded(s) - baseline) F_n with the load F_n.
    """

    value_field: ClassVar[str] = "friction_coefficient"
    equation: ClassVar[Mapping[str, str]] = {
        "along": "vectors[x]*cos(angle) + vectors[y]*sin(angle)",
        "place": "position_samples[first] + along(position)",
        "recorded": "interpolated(place, position_samples, friction_coefficient_samples)",
        "added_friction": "plate.normal_force*scale*(recorded - baseline)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "position_samples": [0, 1e-3, 2e-3],
        "friction_coefficient_samples": [0.5, 0.52, 0.5],
    }

    friction_coefficient_column: ColumnName = "friction_coefficient"
    friction_coefficient_unit: Annotated[str, column_unit("1"), Field(description="unit of the column")] = "1"
    friction_coefficient_samples: Annotated[
        Samples, Field(description="coefficients [1], in place of a file")
    ] = Samples([])
    baseline: Annotated[
        Number | None,
        Quantity("1", -100, 100, "coefficient rendered as the plate's own friction; the lowest if absent"),
    ] = None

    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return scale (mu_recorded - baseline) F_n [N]."""
        return np.asarray(plate.normal_force * super().added_friction(position, velocity, plate))


def _check(places: Real, values: Real, what: str, file: str) -> None:
    """Refuse a record without two finite values at increasing positions."""
    words = what.replace("_", " ")
    differing = f"{len(places)} positions but {len(values)} values of the {words}"
    columns, missing = {"position": places, words: values}, UNREAD if file else _NAME_ONE
    why = fault_of_record(columns, missing=missing, differing=differing, needing="a record")
    if not why and np.min(np.diff(places)) < _SHORTEST:
        first = int(np.argmax(np.diff(places) < _SHORTEST)) + 1
        why = (
            f"positions must increase by at least 1 nm, but sample {first} ({places[first]:.9g} m) follows"
            f" {places[first - 1]:.9g} m"
        )
    if not why and places[-1] - places[0] > _LONGEST:
        why = f"the record is {places[-1] - places[0]:.4g} m long, and 10 m are allowed; is position_unit right?"
    if why:
        raise ValueError(why)


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
            raise ValueError(why)
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
