"""A publication as data, how it was read, and a number that it states beside ours."""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


ARTICLE, PROCEEDINGS, MISC = "article", "inproceedings", "misc"
KINDS: Final = (ARTICLE, PROCEEDINGS, MISC)
"""Types of BibTeX entries that papers are cited with."""


@dataclass(frozen=True, kw_only=True)
class Citation:
    """A publication, with what is known of it: nothing is filled in that was not read.

    - `kind`: one of `KINDS`.
    - `authors`: initials before the family name; ``"others"`` as the last one where the rest is not known.
    - `title`: as it is printed; `about` says in words of our own what the text is about where the title is
      not known.
    - `pages`: the first page or the article number if no more is known.
    - `eprint`: number of a preprint on arXiv; `archive` that in another archive, such as ``hal-01253573``.
    - `read`: how it was read here if not the whole text: ``abstract``, or ``cited from memory, unverified``.
    - `key`: key of the BibTeX entry where it is not the name of the paper's module.
    """

    kind: str
    authors: tuple[str, ...] = ()
    title: str = ""
    about: str = ""
    journal: str = ""
    booktitle: str = ""
    year: int | None = None
    volume: str = ""
    number: str = ""
    pages: str = ""
    doi: str = ""
    eprint: str = ""
    url: str = ""
    archive: str = ""
    read: str = ""
    note: str = ""
    key: str = ""

    def __post_init__(self) -> None:
        """Refuse an unknown kind, and a place of publication of another kind."""
        if self.kind not in KINDS:
            raise TypeError(f"a citation is one of {', '.join(KINDS)}, not '{self.kind}'")
        if bool(self.journal) != (self.kind == ARTICLE) or bool(self.booktitle) != (self.kind == PROCEEDINGS):
            raise TypeError(
                f"{self.kind}: an article has a journal, a contribution to a conference a booktitle"
            )

    def __str__(self) -> str:
        authors = ", ".join(self.authors).replace(", others", " and others")
        parts = [authors, self.title or self.about, self._place(), self.doi and f"doi:{self.doi}"]
        parts += [f"arXiv:{self.eprint}" if self.eprint and self.kind != MISC else "", self.archive, self.url]
        text = ", ".join(part for part in parts if part)
        remarks = "; ".join(part for part in (self.note, self.read) if part)
        return f"{text} ({remarks})" if remarks else text

    def _place(self) -> str:
        if self.kind == PROCEEDINGS:
            return f"{self.booktitle}, {self.pages}" if self.pages else self.booktitle
        if self.kind == MISC:
            place = f"arXiv:{self.eprint}" if self.eprint else ""
        else:
            number = f"({self.number})" if self.number else ""
            volume = f"{self.journal} {self.volume}{number}".rstrip()
            place = f"{volume}, {self.pages}" if self.pages else volume
        return f"{place} ({self.year})" if self.year else place

    def bibtex(self, key: str) -> str:
        """Write a BibTeX entry under its own key or `key`; a text above it says how the publication was read here."""
        doubtful = self.read if UNVERIFIED in self.read else ""
        remarks = (self.about, self.archive, self.note, doubtful)
        fields = {
            "author": _typeset(" and ".join(self.authors)),
            "title": _typeset(self.title),
            "journal": _typeset(self.journal),
            "booktitle": _typeset(self.booktitle),
            "year": str(self.year or ""),
            "volume": self.volume,
            "number": self.number,
            "pages": self.pages.replace("-", "--"),
            "doi": self.doi,
            "eprint": self.eprint,
            "archiveprefix": "arXiv" if self.eprint else "",
            "url": self.url,
            "note": _typeset("; ".join(part for part in remarks if part)),
        }
        lines = [f"  {name} = {{{value}}}" for name, value in fields.items() if value]
        before = f"% source status: {self.read}\n" if self.read else ""
        return f"{before}@{self.kind}{{{self.key or key},\n" + ",\n".join(lines) + "\n}"


def cited(citations: Iterable[Citation]) -> str:
    """Write several citations as one text."""
    return "; ".join(map(str, citations))


def is_reference(text: str) -> bool:
    """Return whether a source is a publication that one can look up: it has a year, or the number of a document."""
    return bool(re.search(r"\b(?:1[89]|20)\d\d\b|\b(?:doi:|arXiv:|https?:|ISO |IEC )", text))


def bibtex_of(text: str, key: str) -> str:
    """Write an entry ``@misc`` for a citation that is known as a text only; the year is that of the key ``author_year``."""
    doi = re.search(r"doi:(10\.\S+?)(?=[\s,;)]|$)", text)
    year = re.search(r"_(\d{4})", key)
    fields = {"note": _typeset(text), "year": year[1] if year else "", "doi": doi[1] if doi else ""}
    lines = [f"  {name} = {{{value}}}" for name, value in fields.items() if value]
    return f"@{MISC}{{{key},\n" + ",\n".join(lines) + "\n}"


def _typeset(text: str) -> str:
    """Escape what TeX would take for a command."""
    return re.sub(r"(?<!\\)([&%#_$])", r"\\\1", text)


_SHOWN: Final = {
    "full text": "full text",
    "in part": "in part",
    "abstract": "abstract only",
    "second-hand": "second-hand",
    "derived": "derived here",
    "unverified": "unverified, cited from memory",
}
STATUSES: Final = tuple(_SHOWN)
"""How a source was read, from best to not at all."""
UNVERIFIED: Final = STATUSES[-1]
"""A value or an equation cited from memory: shown as such wherever it is used, and never a check."""
SECOND_HAND: Final = "second-hand"
"""A number of a source that was read where another publication gives it."""
STATUSES_EXPLAINED: Final = (
    "in full text; in part, as data or code that its authors published; as an abstract only; second-hand, where another"
    " publication gives its numbers; derived here from values that were read; or not at all, then it is unverified, cited"
    " from memory, and its numbers are never a check"
)


def status_text(status: str) -> str:
    """Write one of `STATUSES` for people; the empty status is that of a definition, which has no source."""
    return _SHOWN[status] if status else "a definition"


@dataclass(frozen=True)
class Check:
    """Comparison of a published or derived number with the number computed here.

    - `name`: the method of the model that is called with `given`, or the quantity that `compute` returns.
    - `expect`: the number that the source states [SI].
    - `rtol`: relative tolerance, from the digits that the source prints.
    - `compute`: for a check of a whole paper, takes nothing and returns the number computed here.
    - `status`: one of `STATUSES`; a number cited from memory is never a check.
    """

    name: str
    _: KW_ONLY
    expect: float
    rtol: float
    source: str
    given: Mapping[str, float] = field(default_factory=dict)
    compute: Callable[[], float] | None = None
    status: str = "full text"

    def __post_init__(self) -> None:
        """Refuse a check against a number whose source was not read."""
        if self.status not in STATUSES or self.status == UNVERIFIED:
            msg = f"check '{self.name}': status '{self.status}' cannot be checked against"
            raise TypeError(msg)
        if self.expect == 0 or not 0 < self.rtol < 1:
            msg = f"check '{self.name}': needs a number other than 0 and a relative tolerance below 1"
            raise TypeError(msg)

    def value(self, model: Any = None) -> float:
        """Compute the number."""
        if self.compute is not None:
            return float(self.compute())
        return float(getattr(model, self.name)(**self.given))

    def accepts(self, value: float) -> bool:
        """Return whether a number agrees within the tolerance, bounds included; NaN never agrees."""
        return abs(value - self.expect) <= self.rtol * abs(self.expect)


def counted(checks: Iterable[Check]) -> str:
    """Write how many checks have each status, the best first: ``2 full text, 1 derived here``."""
    found = Counter(check.status for check in checks)
    return ", ".join(f"{found[each]} {status_text(each)}" for each in STATUSES if found[each])


derived: Final = functools.partial(Check, status="derived")
"""A check against a number that follows from what a source states, computed apart from this code."""
