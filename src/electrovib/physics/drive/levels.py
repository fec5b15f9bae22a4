"""Drives between two levels, given and read as amplitude and offset or as high and low."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic_core import InitErrorDetails, PydanticCustomError, ValidationError

from electrovib.core.errors import InputError, gathered, refuse
from electrovib.core.mistakes import shown
from electrovib.core.quantity import Number, Quantity, quantity_of
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear

if TYPE_CHECKING:
    from pydantic import ModelWrapValidatorHandler

    from electrovib.physics.drive.parts import Part

SWING: Final[tuple[str, str]] = ("amplitude", "offset")
LEVELS: Final[tuple[str, str]] = ("high", "low")
IN_PLACE_OF_SWING: Final = "in place of amplitude and offset"
_IN_PLACE_OF_LEVELS: Final = "in place of high and low"
_CHANGED: Final = (
    "changed alone, amplitude keeps the offset and offset the amplitude, and high and low keep each other, except that a"
    " drive that is symmetric about 0 stays symmetric"
)
_PAIRS: Final = "give amplitude and offset, or high and low"


class LevelledDrive(Drive, family=True):
    """A voltage or current between two levels, with one pair of parameters stored and the other derived from it.

    Notes
    -----
    high = offset + c amplitude and low = offset - c amplitude, with the crest factor c = 1 except under a modulation,
    where high and low are the extremes of the envelope. In a table either pair is given, never one of each; `offset` is
    0 unless given, and `low` is 0 unless given in drives that store it. A change of one parameter keeps another one:
    amplitude keeps the offset, offset the amplitude; high and low keep each other, except that a drive that is
    symmetric about 0 stays symmetric, for which `low` = 0 alone is refused. A drive that is off (high = low = 0) keeps
    `low` = 0 where it stores it, and is otherwise symmetric.
    """

    _stored_pair: ClassVar[tuple[str, str]]

    if TYPE_CHECKING:  # of each pair one is stored, the other derived

        @property
        def amplitude(self) -> float: ...
        @property
        def offset(self) -> float: ...
        @property
        def high(self) -> float: ...
        @property
        def low(self) -> float: ...

    @classmethod
    def _crest_of(cls, content: Mapping[str, Any]) -> float:  # noqa: ARG003  # members with a modulation need it
        """Return the largest departure from the offset over the amplitude [1], from the drive's other parameters."""
        return 1.0

    @property
    def crest(self) -> float:
        """Largest departure from the offset over the amplitude [1]."""
        return self._crest_of(dict(self))

    @classmethod
    def _build(cls, content: dict[str, Any], handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Validate a table in which either pair is given."""
        given = {name: content[name] for name in (*SWING, *LEVELS) if name in content}
        if not any(name in cls.derived for name in given):
            return super()._build(content, handler)
        rest = {name: value for name, value in content.items() if name not in given}
        try:
            return super()._build(rest | cls._stored_of_table(given, rest), handler)
        except InputError as error:
            found = [
                _detail(problem.reason, (problem.path,), given[problem.path]) for problem in error.problems
            ]
        first = cls._stored_pair[0]
        try:  # with any amplitude, to find what is wrong beside it
            super()._build(rest | {first: cls.example[first]}, handler)
        except ValidationError as others:
            found += [
                _detail(each["msg"], each["loc"], each["input"], each["type"]) for each in others.errors()
            ]
        raise ValidationError.from_exception_data(cls.__name__, found)

    @classmethod
    def _stored_of_table(cls, given: Mapping[str, Any], rest: Mapping[str, Any]) -> dict[str, Any]:
        """Convert the derived pair of a table into the stored one."""
        _refuse_mixed(given)
        first, second = SWING if SWING[0] in cls.derived else LEVELS
        if first == "amplitude" and first in given:
            given = {first: given[first], second: given.get(second, 0.0)}
        for name, other in ((first, second), (second, first)):
            if other not in given:
                why = f"needs '{other}' beside it; {_PAIRS}"
                if name == "high" and isinstance(given[name], (int, float, str)):
                    example = f"low = {_negative(given[name])} for a drive symmetric about 0"
                    why = f"needs 'low' beside it, for instance {example}; {_PAIRS}"
                raise InputError(why, path=name, value=shown(given[name]))
        problems: list[str] = []
        numbers = dict[str, float]()
        for name, value in given.items():
            with gathered(problems):
                numbers[name] = cls._number(name, value)
        refuse(problems)
        return cls._converted(numbers, rest)

    def stored(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return given parameters as those that the drive stores; one of a pair is completed from what is stored."""
        named = {name: given[name] for name in (*SWING, *LEVELS) if name in given}
        derived = any(name in self.derived for name in named)
        if not named or (not derived and (len(named) > 1 or self._stored_pair == SWING)):
            return dict(given)
        _refuse_mixed(named)
        pair = self._completed(named)
        others = {name: value for name, value in given.items() if name not in named}
        if derived:
            return others | self._converted(pair, dict(self) | others)
        return others | {
            name: value for name, value in pair.items() if name in named or value != getattr(self, name)
        }

    def _completed(self, named: Mapping[str, Any]) -> dict[str, Any]:
        """Add the other one of a pair, from what is stored."""
        if len(named) == 2:
            return dict(named)
        (name,) = named
        pair = SWING if name in SWING else LEVELS
        other = pair[1 - pair.index(name)]
        symmetric = self.offset == 0 and (self.high != 0 or self._stored_pair == SWING)
        if pair == SWING or not symmetric:
            return {name: named[name], other: getattr(self, other)}
        number = named[name]
        if name == "low" and number == 0:
            why = f"high is -low in this drive, so both would be 0; give 'high' as well, for instance high = {self.high:g}"
            raise InputError(why, path=name, value=shown(number))
        return {name: number, other: 0.0 - number}

    @classmethod
    def _converted(cls, pair: Mapping[str, float], others: Mapping[str, Any]) -> dict[str, Any]:
        """Convert a whole derived pair into the stored one."""
        crest = cls._crest_of(others)
        if cls._stored_pair == LEVELS:
            amplitude, offset = pair["amplitude"], pair["offset"]
            return {"high": offset + crest * amplitude, "low": offset - crest * amplitude}
        high, low = pair["high"], pair["low"]
        if high < low:
            raise InputError(
                f"must not be below low, which is {low:g}", path="high", value=shown(pair["high"])
            )
        return {"amplitude": (high - low) / 2 / crest, "offset": (high + low) / 2}

    @classmethod
    def _number(cls, name: str, value: Any) -> float:
        quantity = cls.derived[name] if name in cls.derived else quantity_of(cls, name)
        assert quantity is not None
        try:
            return quantity.read(value)
        except PydanticCustomError as error:
            raise InputError(error.message(), path=name, value=shown(value)) from None


class Swing(LevelledDrive, family=True):
    """A drive that stores amplitude and offset; high and low are derived."""

    _stored_pair: ClassVar[tuple[str, str]] = SWING
    derived_note: ClassVar[str] = (
        f"give amplitude and offset (0 unless given), or both high and low; {_CHANGED}"
    )
    later_parameters: ClassVar[frozenset[str]] = frozenset({"offset"})
    derived: ClassVar[Mapping[str, Quantity]] = {
        "high": Quantity("V", -1e5, 1e5, "highest voltage, offset + amplitude", IN_PLACE_OF_SWING),
        "low": Quantity("V", -1e5, 1e5, "lowest voltage, offset - amplitude", IN_PLACE_OF_SWING),
    }

    amplitude: Annotated[Number, Quantity("V", 0, 1e5, "peak voltage about the offset")]
    offset: Annotated[Number, Quantity("V", -1e5, 1e5, "constant voltage added, from time 0 on")] = 0.0

    @property
    def high(self) -> float:
        """Highest voltage or current, of the envelope under a modulation [V or A]."""
        return self.offset + self.crest * self.amplitude

    @property
    def low(self) -> float:
        """Lowest voltage or current, of the envelope under a modulation [V or A]."""
        return self.offset - self.crest * self.amplitude

    def _with_offset(self, parts: tuple[Part, ...]) -> tuple[Part, ...]:
        """Add the constant to what oscillates."""
        if self.offset == 0:
            return parts
        return (*parts, Linear(np.zeros(1), np.zeros(1), np.array([self.offset]), None))


class Levels(LevelledDrive, family=True):
    """A drive that stores high and low; amplitude and offset are derived."""

    _stored_pair: ClassVar[tuple[str, str]] = LEVELS
    derived_note: ClassVar[str] = (
        f"give high and low (0 unless given), or amplitude and offset (0 unless given); {_CHANGED}"
    )
    derived: ClassVar[Mapping[str, Quantity]] = {
        "amplitude": Quantity(
            "V", -1e5, 1e5, "half the difference between high and low", _IN_PLACE_OF_LEVELS
        ),
        "offset": Quantity("V", -1e5, 1e5, "mean of high and low", _IN_PLACE_OF_LEVELS),
    }

    if TYPE_CHECKING:
        high: float
        low: float

    @property
    def amplitude(self) -> float:
        """Half the difference between high and low [V]; negative where high is below low."""
        return (self.high - self.low) / 2

    @property
    def offset(self) -> float:
        """Mean of high and low [V]."""
        return (self.high + self.low) / 2


def _refuse_mixed(given: Mapping[str, Any]) -> None:
    swing, levels = ([name for name in pair if name in given] for pair in (SWING, LEVELS))
    if swing and levels:
        raise InputError(f"is given beside '{swing[0]}', of the other pair; {_PAIRS}", path=levels[0])


def _negative(value: float | str) -> str:
    text = str(value).strip()
    text = text[1:] if text.startswith("-") else f"-{text}"
    return f"'{text}'" if isinstance(value, str) else text


def _detail(why: str, loc: tuple[int | str, ...], given: Any, kind: str = "levels") -> InitErrorDetails:
    return InitErrorDetails(type=PydanticCustomError(kind, "{why}", {"why": why}), loc=loc, input=given)
