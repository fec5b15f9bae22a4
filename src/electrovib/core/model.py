"""What a model is: a frozen, declared, named set of physical parameters, and how a tree of them is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Self, TypeVar, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from electrovib.core.errors import LONGEST_QUOTED, InputError, nearest, shortened
from electrovib.core.quantity import Quantity

M = TypeVar("M", bound="Model")


class Model(BaseModel):
    """A thing with declared parameters: abstract (a family) or final, never in between.

    Notes
    -----
    A family is declared with ``class Drive(Model, family=True)``; where a family is expected, a table with
    ``model = "Name"`` chooses the member. Every other class is final. Equality and hash are those of the
    canonical JSON, so that two equal numbers written differently are one model.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    is_family: ClassVar[bool] = True
    reference: ClassVar[str] = ""
    status: ClassVar[str] = ""
    equation: ClassVar[Mapping[str, str]] = {}
    checks: ClassVar[tuple[Any, ...]] = ()
    example: ClassVar[Mapping[str, Any]] = {}
    """Parameters without a default, for tests and documents."""
    offered_by: ClassVar[tuple[str, ...]] = ()
    """Functions of papers that offer ready-made ones, which can then be named ``author_year/name``."""

    def __init_subclass__(cls, *, family: bool = False, **kwargs: Any) -> None:
        """Keep classes abstract or final."""
        super().__init_subclass__(**kwargs)
        for parent in cls.__bases__:
            if issubclass(parent, Model) and not parent.is_family:
                msg = f"{cls.__name__} subclasses the final class {parent.__name__}: wrap it instead"
                raise TypeError(msg)
        cls.is_family = family

    @model_validator(mode="wrap")
    @classmethod
    def _read(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if isinstance(value, cls):
            return value
        if isinstance(value, str) and "/" in value and cls.offered_by:
            return cls._offered(value)
        if not isinstance(value, Mapping):
            raise PydanticCustomError("table", "{why}", {"why": cls._wants(value)})
        content = dict(value)
        name = content.pop("model", None)
        if cls.is_family:
            return cls._member(name).model_validate(dict(value))  # with its name, for messages
        if name not in (None, cls.__name__):
            why = f"expected the model {cls.__name__}, not '{name}'"
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        return cls._build(content, handler)

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
        """Add what a table leaves to be found, for instance the numbers of a file it names."""
        return content

    @classmethod
    def _build(cls, content: dict[str, Any], handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Complete and validate a table; a file that cannot be read does not hide the table's other mistakes."""
        if missing := ", ".join(sorted(getattr(cls, "__abstractmethods__", ()))):
            why = f"the class {cls.__name__} does not define {missing}, which {cls.__mro__[1].__name__} asks of its members"
            raise PydanticCustomError("unfinished", "{why}", {"why": why})
        lines: list[InitErrorDetails] = []
        complete = content
        try:
            complete = cls.complete(content)
        except PydanticCustomError as fault:
            lines.append(InitErrorDetails(type=fault, loc=(), input=cls._named(content)))
        try:
            built = handler(complete)
        except ValidationError as error:
            found = [cls._explained(item) for item in error.errors(include_url=False)]
            lines += [line for line in found if line["loc"] or not lines]
        if lines:
            raise ValidationError.from_exception_data(cls.__name__, lines)
        return built

    @classmethod
    def _explained(cls, item: Any) -> InitErrorDetails:
        """Say for an unknown parameter of which class it was, and the nearest known one."""
        kind, loc, shown = item["type"], item["loc"], item["input"]
        if kind == "extra_forbidden" and len(loc) == 1:
            known = nearest(str(loc[0]), cls.model_fields)
            name = shortened(str(loc[0]), LONGEST_QUOTED)
            kind, why = "unknown", f"unknown parameter '{name}' of {cls.__name__}.{known}"
        elif kind == "missing" and len(loc) == 1:
            kind, why = "missing_parameter", f"missing: {cls._describe(str(loc[0]))}"
        else:
            why = item["msg"]
        if not loc and isinstance(shown, Mapping):
            shown = cls._named(shown)
        return InitErrorDetails(type=PydanticCustomError(kind, "{why}", {"why": why}), loc=loc, input=shown)

    @classmethod
    def _named(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Put the name of the model back into a table, for messages."""
        return {"model": cls.__name__, **content} if cls.__mro__[1] is not Model else dict(content)

    @classmethod
    def _describe(cls, field: str) -> str:
        quantity = quantity_of(cls, field)
        if quantity is None:
            return cls.model_fields[field].description or f"'{field}' of {cls.__name__}"
        return f"{quantity.doc}, between {quantity.range()}"

    @classmethod
    def _wants(cls, value: object) -> str:
        """Say how to write what stands where a table belongs; of a family, which members there are."""
        expected = (
            'expected "author_year/name" of a paper, or a table' if cls.offered_by else "expected a table"
        )
        if not cls.is_family:
            return f"{expected} of parameters of {cls.__name__}"
        from electrovib.core.discovery import find_members

        known = nearest(str(value), find_members(cls))
        return f'{expected} that names a {cls.__name__} model, {{ model = "..." }}.{known}'

    @classmethod
    def _member(cls, name: object) -> type[Self]:
        from electrovib.core.discovery import find_members

        if not isinstance(name, str):
            known = ", ".join(sorted(find_members(cls)))
            why = f'needs a name, for instance model = "...", one of: {known}'
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        members = find_members(cls, wanted=name)
        if name not in members:
            why = f"unknown {cls.__name__} model '{shortened(name, LONGEST_QUOTED)}'.{nearest(name, members)}"
            raise PydanticCustomError("model_name", "{why}", {"why": why})
        return members[name]

    @classmethod
    def _offered(cls, name: str) -> Self:
        """Read the name of something that a paper offers."""
        from electrovib.core.discovery import find_offer

        try:
            return cls.from_offer(find_offer(name, cls.offered_by))
        except InputError as error:
            raise PydanticCustomError("offer", "{why}", {"why": str(error)}) from None

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Take the model out of what a paper offers: that itself, unless a family says otherwise."""
        return cls.model_validate(offer)

    def to_dict(self) -> dict[str, Any]:
        """Give the nested tables that build this model again, floats in SI.

        Returns
        -------
        dict
            Member of a family: with its ``model`` name first.
        """
        content = {"model": type(self).__name__} if type(self).__mro__[1] is not Model else {}
        return content | {name: _plain(value) for name, value in self}

    def canonical(self) -> str:
        """Write the canonical JSON: what equality, hash and the scenario's hash are made of.

        Returns
        -------
        str
            Parameters in the order of their declaration, layers in that of the stack, which is physics.
        """
        return json.dumps(self.to_dict(), separators=(",", ":"), default=_content)

    def digest(self) -> str:
        """Give the SHA-256 of the canonical JSON, hexadecimal."""
        return hashlib.sha256(self.canonical().encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        """Compare the canonical JSON."""
        return (
            isinstance(other, Model) and type(self) is type(other) and self.canonical() == other.canonical()
        )

    def __hash__(self) -> int:
        """Hash the canonical JSON."""
        return hash((type(self).__name__, self.canonical()))

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
        from electrovib.core.paths import replaced

        content, problems = replaced(self, changes)
        try:
            changed = read_model(type(self), content)
        except InputError as error:
            problems += error.problems
        if problems:
            raise InputError(problems)
        return changed

    def parameters(self) -> Iterator[tuple[str, float | None, Quantity]]:
        """Walk over the physical parameters: dotted path, value in SI, declaration."""
        from electrovib.core.paths import walk_parameters

        return walk_parameters(self)


def quantity_of(model: type[BaseModel], field: str) -> Quantity | None:
    """Find the declaration of a field, if it is a physical parameter."""
    found = [m for m in model.model_fields[field].metadata if isinstance(m, Quantity)]
    return found[0] if found else None


def read_model(kind: type[M], content: object) -> M:
    """Build a model from nested tables and list every mistake at once.

    Raises
    ------
    InputError
        One sentence a mistake: dotted path, value, what is allowed, nearest name.
    """
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        raise InputError(sentence(item) for item in error.errors(include_url=False)) from None


def sentence(item: Mapping[str, Any]) -> str:
    """Write one validation error as ``path = value: why``."""
    path = ".".join(shortened(str(part), LONGEST_QUOTED) for part in item["loc"])
    item = {**item, "msg": item["msg"].removeprefix("Value error, ")}
    if item["type"] in {"missing_parameter", "unknown"}:
        return f"{path}: {item['msg']}"
    shown = item["input"]
    if isinstance(shown, Mapping):
        named = [
            f"{key} = {shortened(repr(shown[key]), LONGEST_QUOTED)}, "
            for key in ("model", "file")
            if shown.get(key)
        ]
        return f"{path or 'the file'} = {{{''.join(named)}...}}: {item['msg']}"
    try:
        text = repr(shown)
    except ValueError:  # Python writes no whole number of thousands of digits
        text = "a whole number of thousands of digits"
    return f"{path or 'the file'} = {shortened(text, LONGEST_QUOTED)}: {item['msg']}"


def _plain(value: Any) -> Any:
    if isinstance(value, Model):
        return value.to_dict()
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return value


def _content(value: Any) -> Any:
    return value.canonical_content()
