"""Waveforms for instruments and simulators, refused unless they are within declared limits."""

from electrovib.exports.waveform.formats import FORMATS as FORMATS
from electrovib.exports.waveform.formats import INSTRUMENTS as INSTRUMENTS
from electrovib.exports.waveform.write import WrittenWaveform as WrittenWaveform
from electrovib.exports.waveform.write import check_waveform_file as check_waveform_file
from electrovib.exports.waveform.write import export_waveform as export_waveform
