"""What was meant by a word at the command line: the words of other commands, of Python and of other tools."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError, nearest, suggestion
from electrovib.core.files import kind_of
from electrovib.core.parsing import read_toml

if TYPE_CHECKING:
    from typer.core import TyperCommand, TyperGroup

_DASHES: Final = "\u2010\u2011\u2012\u2013\u2014\u2015\u2212"
QUOTED: Final = re.compile("(^|=\\s*)[\u201c\u201d\u201e\u2018\u2019]")
"""A text, or a value after its equals sign, in quotation marks of a word processor."""


@functools.cache
def words_meant() -> dict[str, Any]:
    """Read the words of other commands, of Python and of other tools, by what they are for."""
    return read_toml((Path(__file__).parent / "meant.toml").read_text(encoding="utf-8"))


def done_by() -> dict[str, str]:
    """Return the command that does what a word stands for, in Python and in other tools."""
    return {word: command for command, words in words_meant()["commands"].items() for word in words.split()}


def command_meant(word: str, path: str, commands: Iterable[str]) -> str:
    """Say which command was meant by a word that is none; `path` is what stands before it."""
    plain = word.lower().replace("_", "-")
    lists = f"'{path} -h' lists the commands."
    if word.startswith("-"):
        return f"'{word}' stands before the command; options follow it: {path} COMMAND {word} ..."
    if plain in commands:
        return f"'{word}' is no command, but '{plain}' is: {path} {plain}"
    if plain in (others := done_by()) and path.count(" ") == 0:
        return f"'{word}' is no command; this is done by '{path} {others[plain]}'"
    place, suffix = Path(word), Path(word).suffix.lower()
    if suffix in {".toml", ".nc"} or "/" in word:
        return f"'{word}' is no command; a scenario is simulated by '{path} run {word}'"
    if kind_of(place) or suffix in {".csv", ".mat", ".xlsx", ".txt"}:
        of_file = "import", "reads a file of an instrument"
        command, does = ("report", "shows a study") if kind_of(place) == "folder" else of_file
        return f"'{word}' is no command; '{path} {command} {word}' {does}. {lists}"
    return f"'{word}' is no command.{nearest(word, commands)} {lists}"


@contextmanager
def explained(command: TyperCommand | TyperGroup, ctx: Any) -> Iterator[None]:
    """Say of arguments that cannot be read, in one sentence, what was typed and what was meant."""
    try:
        yield
    except Exception as wrong:
        kind = type(wrong).__name__  # of click, or of the copy of it within typer
        if kind == "NoSuchOption":
            raise InputError(_option_meant(getattr(wrong, "option_name", ""), command, ctx)) from None
        if not hasattr(wrong, "format_message") or kind == "NoArgsIsHelpError":
            raise
        message = wrong.format_message()
        extra = re.search(r"unexpected extra arguments?(?:\(s\))? \((.*)\)", message)
        raise InputError(_too_many(extra[1], command, ctx) if extra else f"{message} {_shows(ctx)}") from None


def _shows(ctx: Any) -> str:
    return f"'{ctx.command_path} -h' shows what it takes."


def refuse_other_forms(words: Iterable[str], command: TyperCommand | TyperGroup) -> None:
    """Refuse words by their form: dashes and quotation marks of a word processor, options as in Python."""
    if why := next(filter(None, (_typed_otherwise(each, command) for each in words)), ""):
        raise InputError(why)


def _typed_otherwise(text: str, command: TyperCommand | TyperGroup) -> str:
    """Say what was meant by a word in another form than that of the command line; empty where nothing is wrong with it."""
    if text[:1] in _DASHES and (name := text.strip(f"{_DASHES}-").partition("=")[0])[:1].isalpha():
        return f"'{text}' begins with a dash of a word processor; type two hyphens: --{name}"
    if QUOTED.search(text):
        return f"{text}: has quotation marks of a word processor; type straight ones, or none"
    name, sign, value = text.partition("=")
    if not (sign and name.replace(".", "").replace("_", "").isalnum()) or kind_of(Path(text)):
        return ""
    option = _in_python(name, command) or f"--{name.replace('_', '-')}"
    if option in options_of(command):
        return f"'{text}': an option begins with two hyphens: {option} '{value}'"
    if "." in name and "--set" in options_of(command):
        return f"'{text}': a parameter is changed by --set '{text}'"
    return ""


def _too_many(extra: str, command: TyperCommand | TyperGroup, ctx: Any) -> str:
    """Say what an argument is that a command does not take."""
    own = " ".join(str(each.name).upper() for each in command.params if each.param_type_name == "argument")
    takes = f"'{ctx.command_path}' takes {own or 'no argument'} and options"
    if Path(extra).suffix.lower() in {".toml", ".nc"} and own:
        takes += f"; 'electrovib report {extra} ...' overlays several"
    return f"'{extra}' is one argument too many; {takes}. {_shows(ctx)}"


def _option_meant(wrong: str, command: TyperCommand | TyperGroup, ctx: Any) -> str:
    """Say which commands have an option, and which one of this command is for the same."""
    own, root = options_of(command), ctx.find_root().command
    elsewhere = words_meant()["elsewhere"].get(wrong, "")
    if ctx.parent is None:
        if elsewhere in own:
            return f"'electrovib' has no option '{wrong}'; it is {elsewhere}"
        return f"'{wrong}' stands before the command; options of a command follow it: electrovib COMMAND {wrong} ..."
    synonym = _in_python(wrong.strip("-").replace("-", "_"), command) or elsewhere
    groups = [
        (synonym,),
        *(line.split() for line in words_meant()["alike"]["options"] if wrong in line.split()),
    ]
    alike = [name for names in groups for name in names if name in own]
    owners = [name for name, each in _every(root) if wrong in options_of(each)]
    if wrong in options_of(root):
        said = f"'{wrong}' stands before the command: electrovib {wrong} ... {ctx.info_name}"
    elif alike or not owners:
        said = f"no option '{wrong}' of '{ctx.command_path}'"
    else:
        said = f"'{wrong}' belongs to {', '.join(repr(name) for name in owners if name != ctx.info_name)}"
    if alike:
        return f"{said}; '{ctx.info_name}' takes '{alike[0]}'"
    if not set(own) - {"-h", "--help"}:
        return f"{said}; '{ctx.command_path}' prints, and takes no option: {ctx.command_path} > FILE"
    near = suggestion(wrong, own)
    return f"{said}; '{ctx.info_name}' has no such option.{near} {_shows(ctx)}"


def _in_python(name: str, command: TyperCommand | TyperGroup) -> str:
    """Return the option for an argument of that name in Python; empty if there is none."""
    own = {str(each.name): each.opts[0] for each in command.params if each.param_type_name == "option"}
    return own.get(name) or str(words_meant()["in_python"].get(name, ""))


def options_of(command: TyperCommand | TyperGroup) -> list[str]:
    """List the options of a command."""
    return [name for each in command.params if each.param_type_name == "option" for name in each.opts]


def _every(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over all commands, those of a group after its name."""
    for name, each in group.commands.items():
        yield from _every(each, f"{name} ") if hasattr(each, "commands") else [(f"{before}{name}", each)]
