"""What a number, a model and a result are.

An experiment is a frozen tree of Models in SI. A result is a Trace: an `xarray.Dataset` whose variables are named by one
table (`signals`); a measurement is one too, so that whatever takes a prediction takes a recording. Any other result is an
`Answer` (`answer`): it states its sentences, tables, figures and files as data, and nothing of how they are shown.

Models and papers are found by their class and place, never listed (`discovery`). It imports the folder `papers` by name, the
one import that goes upwards, because a paper must not need a line elsewhere. A user's own models are a file that is imported
once (`own_models`); a Trace names it with its SHA-256, can be read without it, and is computed again only with it.
"""
