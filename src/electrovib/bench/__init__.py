"""Real or simulated set-ups: roles of the instruments, the sequence of a finite triggered burst, drivers, and a twin.

A plan is cleared by `studies.check` as it is played, and nothing is enabled before all settings were read back. Every end
leads to 0 V, and to a disabled amplifier where a line disables it: the last step, an error, a lost connection, Ctrl-C and
signals, the first of which raises while later ones wait; what the end needs is rehearsed before (`run`, `sequence`). After
SIGKILL the finite burst ends at 0 V by itself; the next run on this bench says so. Software protects nobody: the hardware
that limits the current does.
"""
