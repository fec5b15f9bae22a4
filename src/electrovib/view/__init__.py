"""For eyes: plots, the report of a run and the report of a reproduced paper."""
