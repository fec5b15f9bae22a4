"""File formats of waveforms: how each holds the samples, and what a player makes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.data.marks import Form
from electrovib.exports.waveform import hp_33120a, plain, wave_audio

if TYPE_CHECKING:
    from electrovib.exports.waveform.encoded import Encoded, Scaling
    from electrovib.studies.waveform import Waveform


@dataclass(frozen=True, kw_only=True)
class WaveformFormat:
    """One format of files of waveforms.

    `encode` gives what the file can hold of samples and scaling, and `content` its bytes with notes. A format
    without a place for a mark has no `form`. With `held` a player holds each sample until the next; what is
    `played` by an instrument has to begin and end at 0 V. Any rate will do if `rates` is empty, else those
    that players offer [Hz].
    """

    name: str
    encode: Callable[[Waveform, Scaling], Encoded]
    content: Callable[[Encoded, Sequence[str]], bytes]
    form: Form | None = Form.WAVEFORM
    held: bool = False
    played: bool = True
    most_points: int | None = None
    fewest_points: int = 2
    rates: tuple[float, ...] = ()
    whole_rate: bool = False


FORMATS: Final[dict[str, WaveformFormat]] = {
    ".csv": WaveformFormat(name="CSV", encode=plain.encode, content=plain.as_csv),
    ".npy": WaveformFormat(name="NumPy array", encode=plain.encode, content=plain.as_npy, form=None),
    ".mat": WaveformFormat(name="MATLAB file", encode=plain.encode, content=plain.as_mat),
    ".wav": WaveformFormat(
        name="WAV",
        encode=wave_audio.encode,
        content=wave_audio.as_wav,
        rates=wave_audio.RATES,
        whole_rate=True,
    ),
    ".pwl": WaveformFormat(name="SPICE source", encode=plain.encode, content=plain.as_pwl, played=False),
}
"""Suffix to format."""
INSTRUMENTS: Final[dict[str, WaveformFormat]] = {
    "hp_33120a": WaveformFormat(
        name="HP 33120A arbitrary waveform",
        encode=hp_33120a.encode,
        content=hp_33120a.as_csv,
        held=True,
        most_points=hp_33120a.MOST_POINTS,
        fewest_points=hp_33120a.FEWEST_POINTS,
    )
}
"""Name of an instrument to its format."""
