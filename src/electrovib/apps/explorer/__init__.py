"""The explorer: a page in the browser in which parameters are changed and their effect is seen.

One person uses it, on this machine. The event loop computes nothing: short runs go to the thread of `Workers.quick`, long ones,
fits and reports to `patient`. A page has one task and at most one wish that waits, the latest (`runner`); work that nobody waits
for ends between two time steps. Files that are dropped are read in processes with limits.
"""
