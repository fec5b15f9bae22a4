"""What a model is: a frozen, declared, named set of physical parameters, and how a tree of them is read."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Final, NoReturn, Self, TypeVar, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from electrovib.core.deprecation import Former
from electrovib.core.discovery import find_member, find_members, find_offer
from electrovib.core.errors import LONGEST_QUOTED, InputError, Problem, refuse, shortened, suggestion
from electrovib.core.files import DeclaresFile
from electrovib.core.mistakes import explained, near_members, problems, wants
from electrovib.core.own_results import check_results
from electrovib.core.quantity import Quantity, quantity_of
from electrovib.core.tables import Changed
from electrovib.core.unchangeable import frozen

M = TypeVar("M", bound="Model")


class Written(BaseModel):
    """A model that is written as nested tables, and compared by them."""

    is_member: ClassVar[bool] = False
    """Whether it is one of a family, whose tables name it."""
    later_parameters: ClassVar[frozenset[str]] = frozenset()
    """Parameters that were added later: at their defaults they do not enter the hash, which older files carry."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Shorten the annotations of class variables, which pydantic would evaluate once more for every subclass."""
        super().__init_subclass__(**kwargs)
        own = vars(cls).get("__annotations__", {})
        own.update((name, ClassVar) for name, text in own.items() if str(text).startswith("ClassVar["))

    def to_dict(self) -> dict[str, Any]:
        """Give the nested tables that build this model again, floats in SI.

        Returns
        -------
        dict
            Member of a family: with its ``model`` name first.
        """
        return self._tables(hashed=False)

    def _tables(self, *, hashed: bool) -> dict[str, Any]:
        content = {"model": type(self).__name__} if self.is_member else {}
        fields, later = type(self).model_fields, self.later_parameters if hashed else ()
        kept = ((name, value) for name, value in self if name not in later or value != fields[name].default)
        return content | {name: _plain(value, hashed=hashed) for name, value in kept}

    def canonical(self) -> str:
        """Write the canonical JSON: what equality, hash and the scenario's hash are made of.

        Returns
        -------
        str
            Parameters in the order of their declaration, layers in that of the stack, which is physics.
        """
        return json.dumps(self._tables(hashed=True), separators=(",", ":"), default=_content)

    def digest(self) -> str:
        """Give the SHA-256 of the canonical JSON, hexadecimal."""
        return hashlib.sha256(self.canonical().encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Written) and type(self) is type(other) and self.canonical() == other.canonical()
        )

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.canonical()))


def _plain(value: Any, *, hashed: bool) -> Any:
    if isinstance(value, Written):
        return value._tables(hashed=hashed)  # noqa: SLF001  # of its own kind
    if isinstance(value, (tuple, list)):
        return [_plain(item, hashed=hashed) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain(item, hashed=hashed) for key, item in value.items()}
    return value


def _content(value: Any) -> Any:
    return value.canonical_content()


_COPY = 'replace returns a changed copy, as in scenario.replace({"drive.high": "150 V"})'


class Immutable(BaseModel):
    """A pydantic model that refuses assignments to its instances and names the call that returns a changed copy."""

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        """Refuse an assignment."""
        raise InputError(f"{type(self).__name__}.{name}: is not changed in place; {_COPY}")

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse a deletion."""
        raise InputError(f"{type(self).__name__}.{name}: is not deleted in place; {_COPY}")

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Copy it with parameters that are not validated, and cannot be changed in place either."""
        changes = {name: frozen(value) for name, value in (update or {}).items()}
        return super().model_copy(update=changes, deep=deep)


ABOUT: Final = frozenset({"equation", "reference", "status"})
"""Attributes of a class that are listed beside its parameters, if they are not empty."""


@functools.cache
def hidden_names(base: type[BaseModel]) -> frozenset[str]:
    """Return the names that a base class of models has for its subclasses, and not for the user of a model."""
    return frozenset(
        name
        for name in dir(base)
        if name in dir(BaseModel)
        or not callable(getattr(base, name))
        or isinstance(inspect.getattr_static(base, name), classmethod)
    )


class Model(Immutable, DeclaresFile, Written):
    """A thing with declared parameters: abstract (a family) or final, never in between.

    Notes
    -----
    A family is declared with ``class Drive(Model, family=True)``; where a family is expected, a table with
    ``model = "Name"`` chooses the member. Every other class is final. Equality and hash are those of the
    canonical JSON, so that two equal numbers written differently are one model.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True, defer_build=True)

    is_family: ClassVar[bool] = True
    reference: ClassVar[str] = ""
    status: ClassVar[str] = ""
    equation: ClassVar[Mapping[str, str]] = {}
    """Formulas by the name of the method that computes them, in Python's notation.

    ``a if time < b else c`` is a formula by cases, ``sum(term.x for term in terms)`` a sum over parameters, ``%`` the
    remainder, ``I`` the imaginary unit; other methods and the parts of a model can be called. ``state'`` is a rate of change
    in time, and a name that is neither a method nor a rate an abbreviation that other formulas use.
    """
    checks: ClassVar[tuple[Any, ...]] = ()
    example: ClassVar[Mapping[str, Any]] = {}
    """Parameters without a default, for tests and documents."""
    derived: ClassVar[Mapping[str, Quantity]] = {}
    """Parameters that can be given in place of stored ones, and are read as attributes."""
    former: ClassVar[Mapping[str, Former]] = {}
    """Former names: of a family those of its members, of a member those of its parameters."""
    never_negative: ClassVar[frozenset[str]] = frozenset()
    """Methods that return no negative number; of complex numbers no positive imaginary part."""
    checked_elsewhere: ClassVar[frozenset[str]] = frozenset()
    """Methods whose results are checked by what calls them."""
    derived_note: ClassVar[str] = ""
    """How stored and derived parameters go together, for the list of models."""
    offered_by: ClassVar[tuple[str, ...]] = ()
    """Functions of papers that offer ready-made ones, which can then be named ``author_year/name``."""
    how_to_omit: ClassVar[str] = ""
    """How to do without a part, for who gives a word such as ``none`` in the place of its table."""

    def __init_subclass__(cls, *, family: bool = False, **kwargs: Any) -> None:
        """Keep classes abstract or final."""
        super().__init_subclass__(**kwargs)
        for parent in cls.__bases__:
            if issubclass(parent, Model) and not parent.is_family:
                msg = f"{cls.__name__} subclasses the final class {parent.__name__}: wrap it instead"
                raise TypeError(msg)
        cls.is_family = family
        cls.is_member = not family and cls.__mro__[1] is not Model
        check_results(cls)

    @model_validator(mode="wrap")
    @classmethod
    def _read(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if isinstance(value, cls):
            return value
        if isinstance(value, str) and cls.is_offer(value):
            return cls._offered(value)
        if isinstance(value, str) and cls.is_family and find_member(cls, value):
            value = {"model": value}
        if not isinstance(value, Mapping):
            raise PydanticCustomError("table", "{why}", {"why": wants(cls, value)})
        content = dict(value)
        name = content.pop("model", None)
        if cls.is_family:
            member = cls._member(name)
            return member.model_validate({**value, "model": member.__name__})  # its name is for messages
        if name not in (None, cls.__name__):
            why = f"expected the model {cls.__name__}, not '{name}'"
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        return cls._build(content, handler)

    if not TYPE_CHECKING:  # a checker would take every attribute for known

        def __getattr__(self, name: str) -> Any:
            """Read a parameter by its former name."""
            return getattr(self, self.present(name)) if name in self.former else super().__getattr__(name)

    @classmethod
    def present(cls, name: str) -> str:
        """Give the present name of a parameter or of a member; a former name warns."""
        return cls.former[name].warn(f"{cls.__name__}.{name}") if name in cls.former else name

    @field_validator("*", mode="before")
    @classmethod
    def _counts_are_no_booleans(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse yes and no where Python would take them for 1 and 0."""
        if isinstance(value, bool) and info.field_name in cls.model_fields:
            annotation = cls.model_fields[info.field_name].annotation
            if int in (annotation, *get_args(annotation)):
                raise PydanticCustomError("count", "{why}", {"why": "expected a whole number"})
        return value

    @classmethod
    def complete(cls, content: dict[str, Any]) -> dict[str, Any]:
        """Add what a table leaves to be found; it is validated after that."""
        return content

    @classmethod
    def part(cls, name: str) -> type[Model] | None:
        """Give the kind of model that a parameter holds, alone or in a list; None if it holds none."""
        field = cls.model_fields.get(name)
        waiting: list[Any] = [] if field is None else [field.annotation]
        while waiting:
            kind = waiting.pop()
            if isinstance(kind, type) and issubclass(kind, Model):
                return kind
            waiting += get_args(kind)
        return None

    @classmethod
    def chosen(cls, table: Mapping[str, Any]) -> type[Model] | None:
        """Give the model that a table is of; None where it names no member of the family."""
        name = table.get("model")
        if not cls.is_family:
            return cls
        return find_member(cls, name) if isinstance(name, str) else None

    @classmethod
    def _build(cls, content: dict[str, Any], handler: ModelWrapValidatorHandler[Self]) -> Self:
        if missing := ", ".join(sorted(getattr(cls, "__abstractmethods__", ()))):
            why = f"the class {cls.__name__} does not define {missing}, which {cls.__mro__[1].__name__} asks of its members"
            raise PydanticCustomError("unfinished", "{why}", {"why": why})
        for name in cls.former.keys() & content.keys():
            if cls.former[name].now not in content:  # else it is an unknown parameter
                content[cls.present(name)] = content.pop(name)
        try:
            return handler(cls.complete(content))
        except ValidationError as error:
            lines = [explained(cls, item) for item in error.errors(include_url=False)]
        raise ValidationError.from_exception_data(cls.__name__, lines)

    @classmethod
    def _member(cls, name: object) -> type[Self]:
        if not isinstance(name, str):
            known = ", ".join(sorted(find_members(cls)))
            why = f'needs a name, for instance model = "...", one of: {known}'
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        member = find_member(cls, name)
        if member is None:
            near = near_members(cls, name)
            if not suggestion(name, find_members(cls)):
                near += (
                    " A model of your own: 'electrovib --models FILE.py ...', or import its file in Python."
                )
            why = f"unknown {cls.__name__} model '{shortened(name, LONGEST_QUOTED)}'.{near}"
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        return member

    @classmethod
    def is_offer(cls, text: str) -> bool:
        """Tell whether a text in the place of a table is the name of something ready-made."""
        return "/" in text and bool(cls.offered_by)

    @classmethod
    def offer(cls, name: str) -> Any:
        """Find something ready-made by its name, ``author_year/name`` of a paper.

        Raises
        ------
        InputError
            If nothing has that name; the message has the nearest one.
        """
        return find_offer(name, cls.offered_by)

    @classmethod
    def _offered(cls, name: str) -> Self:
        """Read the name of something ready-made."""
        try:
            return cls.from_offer(cls.offer(name))
        except InputError as error:
            raise PydanticCustomError("offer", "{why}", {"why": str(error)}) from None

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Take the model out of what a paper offers: that itself, unless a family says otherwise."""
        return cls.model_validate(offer)

    def stored(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return given parameters as those that this model stores: a member may offer derived ones beside them."""
        return dict(given)

    def __dir__(self) -> list[str]:
        """List the parameters and the methods of a model that exists, without pydantic's names and those of the class."""
        about = {name for name in ABOUT if getattr(self, name)}
        names = (
            (set(super().__dir__()) - hidden_names(Model) - {"stored"}) | about | {name for name, _ in self}
        )
        return sorted(name for name in names if not name.startswith("_"))

    @classmethod
    def rebuilt(cls, content: dict[str, Any]) -> Self:
        """Build the model from tables in which something was changed."""
        return read_model(cls, content)

    @classmethod
    def with_place(cls, tables: dict[str, Any], name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return tables with an empty one for a new part, from what is given of it; by default there is none to add."""
        del name, given
        return tables

    @classmethod
    def how_to_add(cls, content: Mapping[str, Any], path: str) -> str:
        """Explain how to add the optional part that a dotted path leads into; empty where it leads into none."""
        del content, path
        return ""

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Give a copy with some parameters changed.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to number, text with a unit, or table: ``{"drive.high": "150 V"}``.

        Returns
        -------
        Model
            A new, validated model.

        Raises
        ------
        InputError
            For every path that does not exist and every value that does not fit, all at once.
        """
        found = Changed(self)
        return self._after(found.within(changes, self), found.problems)

    def _after(self, content: dict[str, Any], mistakes: list[Problem]) -> Self:
        """Build the changed model, or refuse every mistake at once."""
        problems: list[str] = [*mistakes]
        try:
            built = self.rebuilt(content)
        except InputError as error:
            problems += error.problems
        refuse(problems)
        return built

    def parameters(self, prefix: str = "") -> Iterator[tuple[str, float | None, Quantity]]:
        """Walk over all physical parameters of this tree of models, in the order of the file.

        Parameters
        ----------
        prefix : str
            What a path begins with.

        Yields
        ------
        tuple
            Dotted path, value in SI (None where it is optional and absent), declaration.
        """
        for name, value in self:
            path = f"{prefix}{name}"
            quantity = quantity_of(type(self), name)
            if quantity is not None:
                yield path, value, quantity
            elif isinstance(value, Model):
                yield from value.parameters(f"{path}.")
            elif isinstance(value, tuple):
                for index, item in enumerate(value):
                    if isinstance(item, Model):
                        yield from item.parameters(f"{path}.{index}.")


def read_model(kind: type[M], content: object) -> M:
    """Build a model from nested tables and list every mistake at once."""
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        raise InputError(problems(error.errors(include_url=False))) from None
