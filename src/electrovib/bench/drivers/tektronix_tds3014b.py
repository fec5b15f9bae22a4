"""Tektronix TDS3014B oscilloscope: one record of 10 000 points for each burst.

Commands, with their source status. The reference is the programmer manual of the TDS3000, TDS3000B and TDS3000C series
(Tektronix 071-0381); it was not at hand, so page numbers are missing, and every command but the first two is unverified: taken
from public drivers for the series.

================================ =====================================================================================
``WFMPre?`` then ``CURVe?``      manual, page not noted, and a preamble of the series: keys ``BYT_NR``, ``BIT_NR``, ``ENCDG``,
                                 ``BN_FMT``, ``BYT_OR``, ``NR_PT``, ``XINCR``, ``XZERO``, ``PT_OFF``, ``YMULT``,
                                 ``YOFF``, ``YZERO``; records of 500 or 10 000 points of 1 or 2 bytes
``HORizontal:RECOrdlength``      500 or 10000 (manual, page not noted); the spelling of the command is unverified
``HEADer``, ``VERBose``          unverified
``DATa:SOUrce``, ``:ENCdg``,     unverified
``:WIDth``, ``:STARt``, ``:STOP``
``HORizontal:MAIn:SCAle``,       unverified
``HORizontal:TRIGger:POSition``
``CH<x>:SCAle``, ``:OFFSet``,    unverified
``:POSition``, ``:COUPling``,
``SELect:CH<x>``
``TRIGger:A:TYPe``, ``:MODe``,   unverified; the trigger is the SYNC output of the generator at the EXT input
``:EDGE:SOUrce``, ``:LEVel``,
``TRIGger:STATE?``
``ACQuire:MODe``, ``:STOPAfter`` unverified
``SEQuence``, ``ACQuire:STATE``
``*IDN?``, ``*OPC?``             common commands of IEEE 488.2
================================ =====================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.bench.link import BenchError
from electrovib.data.readers.isf import number_of, preamble_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.bench.link import Link

RECORD: Final = 10_000
DIVISIONS: Final = 10
HEIGHT: Final = 8
"""Vertical divisions of the display."""
LEVELS: Final = 50.0
"""Readings of the 9-bit converter in one division [1]; unverified."""
BEFORE: Final = 10.0
"""Share of the record before the trigger, in percent."""
_TIMES: Final = (1.0, 2.0, 4.0)
_VOLTS: Final = (1.0, 2.0, 5.0)
_SLOWEST, _FASTEST = 10.0, 4e-9
_COARSEST, _FINEST = 10.0, 1e-3


class TektronixTds3014b:
    """Driver of the Tektronix TDS3014B; `also` is a further model that the user has named, empty for none."""

    models: Final = ("TDS3014B", "TDS3014")

    def __init__(self, link: Link, *, also: str = "") -> None:
        self.link = link
        self._also = also

    def identify(self) -> str:
        """Return maker, model and versions; a model that is not known is refused."""
        return self.link.identify(self.models, self._also, "oscilloscope.accept_model")

    def set_time(self, duration: float) -> float:
        """Set a record that begins before the trigger and lasts longer than the burst; return its length [s]."""
        scale = time_scale(duration)
        self.link.write(
            "HEAD OFF", f"HOR:RECO {RECORD}", f"HOR:MAI:SCA {scale:.3E}", f"HOR:TRIG:POS {BEFORE:g}", "ACQ:MOD SAM",
            "ACQ:STOPA SEQ", "TRIG:A:TYP EDGE", "TRIG:A:MOD NORM", "TRIG:A:EDGE:SOU EXT", "TRIG:A:EDGE:SLO RIS",
            "TRIG:A:LEV 1.0",
        )  # fmt: skip
        return DIVISIONS * scale

    def set_channel(self, channel: int, low: float, high: float) -> float:
        """Set an input so that its record holds a range of voltages; return the difference of two readings [V]."""
        scale = volt_scale(low, high)
        for setting in ("COUP DC", "POS 0", f"SCA {scale:.3E}", f"OFFS {(low + high) / 2:.6E}"):
            self.link.write(f"CH{channel}:{setting}")
        self.link.write(f"SEL:CH{channel} ON")
        return scale / LEVELS

    def finish_settings(self) -> None:
        """Wait until all settings are made: ``*OPC?``."""
        if self.link.ask_number("*OPC?") != 1:
            raise BenchError("the oscilloscope does not confirm its settings")

    @staticmethod
    def expected(duration: float, ranges: dict[int, tuple[float, float]]) -> dict[str, Any]:
        """Return what the instrument has to report by query, for a burst [s] and the ranges of the inputs [V]."""
        found: dict[str, Any] = {
            "HOR:RECO?": RECORD, "HOR:MAI:SCA?": time_scale(duration), "HOR:TRIG:POS?": BEFORE, "ACQ:MOD?": "SAMPLE",
            "ACQ:STOPA?": "SEQUENCE", "TRIG:A:MOD?": "NORMAL", "TRIG:A:EDGE:SOU?": "EXT",
        }  # fmt: skip
        for channel, (low, high) in ranges.items():
            found |= {
                f"CH{channel}:SCA?": volt_scale(low, high),
                f"CH{channel}:OFFS?": (low + high) / 2,
                f"CH{channel}:POS?": 0.0,
                f"CH{channel}:COUP?": "DC",
            }
        return found

    def start(self) -> None:
        """Begin to wait for the trigger."""
        self.link.write("ACQ:STATE RUN")

    def is_ready(self) -> bool:
        """Return whether the part before the trigger is filled and the trigger is awaited."""
        return self.link.ask("TRIG:STATE?").upper().startswith("REA")

    def is_done(self) -> bool:
        """Return whether the record is complete."""
        return self.link.ask_number("ACQ:STATE?") == 0

    def record(self, channel: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Read the record of an input: times relative to the trigger (n,) [s], and voltages at the input (n,) [V].

        A record is refused whose preamble and curve disagree, or that has another form than was set.
        """
        self.link.write(
            f"DAT:SOU CH{channel}", "DAT:ENC RIB", "DAT:WID 2", "DAT:STAR 1", f"DAT:STOP {RECORD}"
        )
        self.link.write("HEAD ON;:VERB ON")
        keys = preamble_of(self.link.ask("WFMP?"))
        self.link.write("HEAD OFF")
        data = self.link.ask_block("CURV?")
        form = (keys.get("byt_nr"), keys.get("bn_fmt", "")[:2].upper(), keys.get("byt_or", "")[:3].upper())
        if form != ("2", "RI", "MSB") or len(data) % 2:
            raise BenchError(
                f"the oscilloscope announces samples of the form {form}, where ('2', 'RI', 'MSB') was set"
            )
        counts = np.frombuffer(data, ">i2").astype(np.float64)
        points = _number(keys, "nr_pt")
        if counts.size != points or counts.size != RECORD:
            raise BenchError(
                f"the oscilloscope announces {points:g} points of CH{channel} and sent {counts.size}, where {RECORD} were set"
            )
        index = np.arange(counts.size, dtype=np.float64)
        times = _number(keys, "xzero") + _number(keys, "xincr") * (index - _number(keys, "pt_off"))
        return times, _number(keys, "yzero") + _number(keys, "ymult") * (counts - _number(keys, "yoff"))


def time_scale(duration: float) -> float:
    """Return the time per division [s] with which a burst of a duration [s] fits into the record after the trigger."""
    return _scale(duration / (DIVISIONS * (1 - BEFORE / 100) * 0.98), _TIMES, _FASTEST, _SLOWEST)


def volt_scale(low: float, high: float) -> float:
    """Return the voltage per division for a range [V], with a tenth of the range to spare on either side."""
    return _scale(1.2 * (high - low) / HEIGHT, _VOLTS, _FINEST, _COARSEST)


def _scale(least: float, steps: tuple[float, ...], smallest: float, largest: float) -> float:
    decade = 10.0 ** np.floor(np.log10(max(least, smallest)) - 1)
    found = next(
        step * decade * ten
        for ten in (1.0, 10.0, 100.0)
        for step in steps
        if step * decade * ten >= max(least, smallest) * (1 - 1e-9)
    )
    if found > largest * (1 + 1e-9):
        raise BenchError(
            f"the oscilloscope would need a scale of {found:g} a division, and its coarsest is {largest:g}"
        )
    return float(f"{found:.3g}")


def _number(keys: dict[str, str], key: str) -> float:
    try:
        return number_of(keys, key)
    except ValueError as error:
        raise BenchError(f"the preamble of the oscilloscope {error}") from None
