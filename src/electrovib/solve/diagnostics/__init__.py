"""Validity of a result.

Largest values are sought from time 0 at corners and oscillations of the drive, not at the output times (`peaks`). The error
of a reduced material is computed as a response (`memory`): `transfer_error` is the largest of all quantities,
`attraction_error` that of the attraction. A diagnostic reaches every door: Traces, sweeps and studies carry it as attribute
`validity`, other results as property `diagnostics`, and `tests/contract/test_doors.py` calls every function and command under
a scenario that warns.
"""
