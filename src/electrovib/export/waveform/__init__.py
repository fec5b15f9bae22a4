"""Waveforms for instruments and simulators, refused unless they are within declared limits."""

from electrovib.export.waveform.formats import FORMATS as FORMATS
from electrovib.export.waveform.formats import INSTRUMENTS as INSTRUMENTS
from electrovib.export.waveform.write import WrittenWaveform as WrittenWaveform
from electrovib.export.waveform.write import check_waveform_file as check_waveform_file
from electrovib.export.waveform.write import export_waveform as export_waveform
