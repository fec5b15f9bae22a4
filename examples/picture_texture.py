"""A greyscale picture as a texture: drive along a recorded path, predicted friction, and the same samples as a stream."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from PIL import Image

import electrovib as ev

if TYPE_CHECKING:
    from electrovib.studies.texture import TextureDrive

PLATE = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
CARRIER, RATE = 3e3, 192e3
BLOCK = 1e-3


class Rendered(NamedTuple):
    """What the example computes."""

    drive: TextureDrive
    difference: float
    """Largest difference of the squared voltages of stream and drive over the largest square [1]."""


def picture() -> np.ndarray:
    """Return ridges of 2 mm that become stronger to the right, on 24 mm x 12 mm with 10 pixels per millimetre."""
    x, y = np.meshgrid((np.arange(240) + 0.5) / 10, (np.arange(120) + 0.5) / 10)
    ridges = (1 - np.cos(2 * np.pi * (x + 0.3 * y) / 2)) / 2
    return np.round(255 * ridges * x / 24).astype(np.uint8)


def strokes() -> tuple[np.ndarray, np.ndarray]:
    """Return time stamps of a sensor at 1 kHz [s] and places [m] of a stroke to the right and half of it back."""
    time = np.arange(601) / 1000
    x = 12e-3 - 11e-3 * np.cos(np.pi * time / 0.4)
    return time, np.stack([x, 4e-3 + 6e-3 * time], axis=-1)


def main(folder: Path) -> Rendered:
    """Render the picture along the path, as a whole and block by block.

    Parameters
    ----------
    folder : Path
        Where the picture is written.
    """
    Image.fromarray(picture()).save(folder / "ridges.png")
    texture = {"model": "GreyscalePicture", "file": str(folder / "ridges.png"), "pixels_per_millimetre": 10}
    options = {"texture": texture, "carrier": CARRIER, "rate": RATE, "limits": LIMITS}
    time, places = strokes()
    # a stream begins one block before the first time stamp, with the finger at rest
    x, y = np.concatenate([places[:1], places]).T
    stamps = np.concatenate([[time[0] - BLOCK + 1 / RATE], time])
    path = {"model": "RecordedPath", "time_samples": stamps, "x_samples": x, "y_samples": y}
    drive = ev.texture_drive(PLATE, path=path, **options)
    stream = ev.texture_stream(PLATE, block=BLOCK, dimensions=2, **options)
    blocks = [stream.render(place, now) for now, place in zip(time, places, strict=True)]
    samples = np.concatenate([*blocks, stream.close()])
    # squares, to which the force is proportional: near 0 a root magnifies the rounding of the positions
    squares = samples * np.abs(samples), drive.voltages * np.abs(drive.voltages)
    difference = np.max(np.abs(squares[0] - squares[1])) / np.max(squares[1])
    return Rendered(drive, float(difference))


def draw(rendered: Rendered, file: Path) -> None:
    """Draw picture and path, friction, and voltage.

    Parameters
    ----------
    rendered : Rendered
        From `main`.
    file : Path
        Picture to write.
    """
    import matplotlib.pyplot as plt

    drive = rendered.drive
    figure, (above, middle, below) = plt.subplots(
        3, 1, figsize=(7, 8), layout="constrained", height_ratios=[1.2, 1, 1]
    )
    grey = above.imshow(picture(), cmap="gray", extent=(0, 24, 12, 0), vmin=0, vmax=255)
    above.plot(*(1e3 * drive.positions.T), color="tab:orange", label="path of the finger")
    above.plot(*(1e3 * drive.positions[0]), "o", color="tab:orange", label="beginning")
    above.set(xlabel="x [mm]", ylabel="y [mm]")
    above.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    figure.colorbar(grey, ax=above, label="grey value", shrink=0.8)
    time = 1e3 * drive.times
    friction = drive.scenario.friction.without_memory()
    load = drive.scenario.load.normal_force
    wanted = friction.lateral_force(load, drive.wanted_force, np.nan)
    middle.plot(
        time,
        1e3 * drive.predicted_friction,
        color="tab:blue",
        lw=2,
        label="predicted by the full model, mean over a carrier period",
    )
    middle.plot(time, 1e3 * wanted, "--", color="black", lw=1, label="wanted")
    middle.set(xlabel="time [ms]", ylabel="friction [mN]")
    middle.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    below.plot(time, drive.voltages, color="tab:green", lw=0.3)
    below.set(xlabel="time [ms]", ylabel="voltage [V]", title="drive: carrier of 3 kHz")
    below.title.set_fontsize("medium")
    figure.savefig(file, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    place = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    found = main(place)
    draw(found, place / "picture_texture.png")
    print(found.drive.misfit_in_words)
    print(f"the squared voltages of stream and drive differ by {found.difference:.1e} of the largest one")
