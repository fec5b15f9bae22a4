"""The citation of the paper, and what was not read of it."""

CITATION = (
    "Y. Vardar, B. Guclu, C. Basdogan, Effect of waveform on tactile perception by electrovibration displayed on"
    " touch screens, IEEE Trans. Haptics 10(4), 488 (2017), doi:10.1109/TOH.2017.2704603 (abstract); the same,"
    " EuroHaptics 2016, doi:10.1007/978-3-319-42321-0_18 (abstract)"
)
STATUS = "abstract"
NOT_READ = (
    "The circuit and the law of the force are cited from memory, unverified; the polynomials of the skin's permittivity and"
    " resistivity and the thresholds in volts were not read."
)
