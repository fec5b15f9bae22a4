"""Files of instruments as Traces and materials: columns as signals, calibrated, on one time axis, with their history."""

from electrovib.recordings.importing.import_file import import_file as import_file
from electrovib.recordings.importing.import_file import list_columns as list_columns
from electrovib.recordings.importing.merging import merge_traces as merge_traces
from electrovib.recordings.importing.own_material import import_material as import_material
from electrovib.recordings.recording import calibrate as calibrate
