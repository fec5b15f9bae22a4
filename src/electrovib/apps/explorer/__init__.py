"""The explorer: a page in the browser in which parameters are changed and their effect is seen.

One event loop serves all visitors and computes nothing. Short runs go to the threads of `Workers.quick`, in turn, because
threads of one interpreter do not compute at once; long ones to `patient`. A visitor has one task and at most one wish that
waits, the latest (`runner`); work that nobody waits for ends between two time steps. Files of visitors are read in processes
with limits.
"""
