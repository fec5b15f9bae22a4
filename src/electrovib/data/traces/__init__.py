"""Lossless storage of a Trace: netCDF, CSV with one file per dimension, or MATLAB."""

from electrovib.data.traces.comma_separated import TABLES as TABLES
from electrovib.data.traces.comma_separated import csv_files as csv_files
from electrovib.data.traces.comma_separated import csv_forms as csv_forms
from electrovib.data.traces.comma_separated import load_csv as load_csv
from electrovib.data.traces.comma_separated import save_csv as save_csv
from electrovib.data.traces.matlab import load_mat as load_mat
from electrovib.data.traces.matlab import save_mat as save_mat
from electrovib.data.traces.netcdf import load_nc as load_nc
from electrovib.data.traces.netcdf import save_nc as save_nc
from electrovib.data.traces.opened import FORMATS as FORMATS
from electrovib.data.traces.opened import is_trace_file as is_trace_file
from electrovib.data.traces.opened import open_if_trace as open_if_trace
from electrovib.data.traces.opened import open_trace as open_trace
from electrovib.data.traces.structure import joined as joined
from electrovib.data.traces.structure import not_a_trace as not_a_trace
from electrovib.data.traces.structure import prepared as prepared
from electrovib.data.traces.structure import rebuilt as rebuilt
from electrovib.data.traces.structure import structure_of as structure_of
