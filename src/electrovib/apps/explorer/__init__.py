"""The explorer: a page in the browser in which parameters are changed and their effect is seen.

One event loop serves all visitors and computes nothing. Short runs go to the threads of `Workers.quick`, long ones, fits and
reports to `patient`, which has as many as run at once. A visitor has one task and at most one wish that waits, the latest
(`runner`); work that nobody waits for ends between two time steps. Files of visitors are read in processes with limits.
"""
