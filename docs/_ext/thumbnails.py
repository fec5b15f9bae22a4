"""Thumbnails of the gallery: of a picture with several panels, the one that can be read at this size."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PIL import Image
from sphinx.application import Sphinx

SIZE: Final = (600, 420)
"""Width and height of a thumbnail [pixels], twice the size at which it is shown."""
PANELS: Final = {
    "field_solution": (0.0, 0.13, 0.54, 0.87),
    "measured_swipe": (0.0, 0.0, 0.665, 1.0),
    "picture_texture": (0.18, 0.0, 1.0, 0.37),
    "whole_experiment": (0.0, 0.469, 0.49, 1.0),
}
"""Left, upper, right and lower edge of a panel in the first picture of an example, as shares of its width and height."""
WHOLE: Final = (0.0, 0.0, 1.0, 1.0)


def thumbnail(picture: Image.Image, panel: tuple[float, float, float, float]) -> Image.Image:
    """Return a panel of a picture, enlarged or reduced to the size of a thumbnail, on white.

    Parameters
    ----------
    picture : Image
        First picture of an example.
    panel : tuple of float
        Left, upper, right and lower edge as shares of its width and height.

    Returns
    -------
    Image
        Of `SIZE`.
    """
    width, height = picture.size
    left, upper, right, lower = panel
    cut = picture.convert("RGB").crop(
        (round(left * width), round(upper * height), round(right * width), round(lower * height))
    )
    scale = min(SIZE[0] / cut.width, SIZE[1] / cut.height)
    cut = cut.resize((round(cut.width * scale), round(cut.height * scale)), Image.Resampling.LANCZOS)
    found = Image.new("RGB", SIZE, "white")
    found.paste(cut, ((SIZE[0] - cut.width) // 2, (SIZE[1] - cut.height) // 2))
    return found


def draw(app: Sphinx) -> None:
    """Draw the thumbnail of each example that has a picture."""
    for place in (Path(app.srcdir) / "gallery").glob("*/images/thumb/sphx_glr_*_thumb.png"):
        name = place.stem.removeprefix("sphx_glr_").removesuffix("_thumb")
        picture = place.parents[1] / f"sphx_glr_{name}_001.png"
        if picture.exists():
            with Image.open(picture) as opened:
                thumbnail(opened, PANELS.get(name, WHOLE)).save(place)


def setup(app: Sphinx) -> dict[str, bool]:
    """Draw the thumbnails after sphinx-gallery has run the examples."""
    app.connect("builder-inited", draw, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
