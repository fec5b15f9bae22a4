"""Computing time of a texture stream: the share of one core for a clock of 10 kHz with blocks of 1 ms, and of 192 kHz.

Run from the root of the repository with ``python -m benchmarks.texture_stream``. The time is that of the processor
(`time.process_time`) over 10 s of blocks through `electrovib.texture_stream`; the blocks are computed one after the other without
waiting. The longest block is by the wall clock, the interruptions of the machine included.
"""

from time import perf_counter, process_time

import numpy as np
from benchmarks.table import surroundings, write

import electrovib as ev

BLOCKS = 10_000
BLOCK = 1e-3
RUNS = 3
PICTURE = np.random.default_rng(1).integers(0, 120, 400 * 400).astype(float)
PROFILE = np.linspace(0.0, 0.1, 2001)
TEXTURES = {
    "grating": {"model": "Grating", "period": "2 mm", "amplitude": "1 mN"},
    "height profile of 2001 heights": {
        "model": "HeightProfile",
        "position_samples": PROFILE,
        "height_samples": 1e-6 * np.sin(2 * np.pi * PROFILE / 5e-3),
    },
    "picture of 400 x 400 pixels": {
        "model": "GreyscalePicture",
        "width": 400,
        "value_samples": PICTURE,
        "pixels_per_millimetre": 4,
    },
}
LIMITS = {"voltage": "1 kV", "current": "250 uA"}


def measured(
    texture: dict[str, object], carrier: str | None, rate: str, dimensions: int
) -> tuple[float, float, float]:
    """Return the least share of one core [1], that of the slowest run, and the median time of a block [s]."""
    shares, blocks = [], []
    for _ in range(RUNS):
        stream = ev.texture_stream(
            "vezzoli_2014/fig6",
            texture=texture,
            carrier=carrier,
            rate=rate,
            block=BLOCK,
            dimensions=dimensions,
            limits=LIMITS,
        )
        times = np.arange(BLOCKS) * BLOCK
        places = 0.05 + 0.04 * np.sin(2 * np.pi * 0.5 * times)
        given = places.tolist() if dimensions == 1 else np.stack([places, places / 2], axis=-1).tolist()
        begin = process_time()
        for now, place in zip(times.tolist(), given, strict=True):
            started = perf_counter()
            stream.render(place, now)
            blocks.append(perf_counter() - started)
        shares.append((process_time() - begin) / (BLOCKS * BLOCK))
        assert stream.error is None, stream.error
    return min(shares), max(shares), float(np.median(blocks))


def main() -> None:
    """Measure every texture with and without carrier, and one at a rate for a carrier of 3 kHz."""
    rows = []
    for name, texture in TEXTURES.items():
        dimensions = 2 if "picture" in name else 1
        cases = [
            (None, "10 kHz"),
            ("3 kHz", "10 kHz"),
            *([("3 kHz", "192 kHz")] if "picture" in name else []),
        ]
        for carrier, rate in cases:
            least, most, block = measured(texture, carrier, rate, dimensions)
            wanted = "under 5 %" if rate == "10 kHz" else ""
            label = f"{name}, {'carrier of ' + carrier if carrier else 'no carrier'}, {rate}"
            rows.append([label, f"{100 * least:.2f} to {100 * most:.2f}", wanted, f"{1e6 * block:.0f}"])
    write(
        "texture_stream.md",
        "Streams of textures",
        [
            "`ev.texture_stream(...).render(position, time)` for 10 s of blocks of 1 ms: processor time over the duration of\n"
            f"the blocks, the least and the largest of {RUNS} runs; a picture in two dimensions, the others in one.",
            surroundings(["numpy"]),
        ],
        ["texture", "share of one core, %", "wanted", "median block, us"],
        rows,
    )


if __name__ == "__main__":
    main()
