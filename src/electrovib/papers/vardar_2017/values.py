"""The citation of the paper, and what was not read of it."""

from __future__ import annotations

from electrovib.core.citation import Citation, cited

CITATIONS = (
    Citation(
        kind="article",
        authors=("Y. Vardar", "B. Guclu", "C. Basdogan"),
        title="Effect of waveform on tactile perception by electrovibration displayed on touch screens",
        journal="IEEE Trans. Haptics",
        year=2017,
        volume="10",
        number="4",
        pages="488",
        doi="10.1109/TOH.2017.2704603",
        read="abstract",
    ),
    Citation(
        kind="inproceedings",
        authors=("Y. Vardar", "B. Guclu", "C. Basdogan"),
        about="the earlier conference paper on the same",
        booktitle="EuroHaptics 2016",
        year=2016,
        doi="10.1007/978-3-319-42321-0_18",
        read="abstract",
        key="vardar_2016",
    ),
)
CITATION = cited(CITATIONS)
STATUS = "abstract"
NOT_READ = (
    "The circuit and the law of the force are cited from memory, unverified; the polynomials of the skin's permittivity and"
    " resistivity and the thresholds in volts were not read."
)
