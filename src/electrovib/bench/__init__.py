"""Real or simulated set-ups: roles of the instruments, the sequence of a finite triggered burst, drivers, and a twin."""
