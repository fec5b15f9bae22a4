"""Columns of a measured file as SI arrays, from delimited text, NumPy or netCDF."""

from electrovib.data.columns.delimited import TextTable as TextTable
from electrovib.data.columns.delimited import read_table as read_table
from electrovib.data.columns.faults import DAMAGE as DAMAGE
from electrovib.data.columns.faults import check_file as check_file
from electrovib.data.columns.faults import damaged as damaged
from electrovib.data.columns.read import read_columns as read_columns
