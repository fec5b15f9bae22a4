"""Files: measured tables and Traces.

Each file of `readers` declares one `FORMAT`, found by its first bytes and then by its suffix (`registry`): a new format is
one file. The libraries of HDF5 and MATLAB do not survive damaged files, so they run in a process with limits of memory and
time (`guarded`), which returns JSON and plain arrays, unless the checksum of a file shows that it is whole; all other readers
run here, and those in Python compare every declared size with the bytes of the file. What is written is
complete or was not changed (`atomic`), and replaces only a file that carries our checksum (`marks`).
"""
