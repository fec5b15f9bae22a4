"""Declared equations as they are drawn on the pages of the models."""

import ast
import importlib
import inspect
import re
from pathlib import Path

import pytest
from declared_equations import CONSTANTS, symbols

from electrovib.studies.catalogue.items import everything

ROOT = Path(__file__).parents[1]
WORDS = {
    r"\varepsilon_0": "eps0",
    r"\pi": "pi",
    r"\mathrm{j}": "I",
    r"\max": "Max",
    r"\min": "Min",
    r"\ln": "log",
}
MODELS = {
    item.thing.__name__: item.thing
    for item in everything(own=True)
    if isinstance(item.thing, type) and item.thing.equation
}


@pytest.fixture(scope="module")
def build():
    """Return a function that imports a part of the build of the documentation."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "docs" / "_ext"))
        yield importlib.import_module


@pytest.fixture(scope="module")
def pages(build):
    """Return the pages of all models by the name of the model."""
    return {Path(name).stem: page for name, page in build("models").pages().items()}


@pytest.fixture
def lines(build):
    """Return the function that draws an equation."""
    return build("formula").lines


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("eps0*E**2/2", [r"\frac{\varepsilon_0\,E^{2}}{2}"]),
        ("2*(a + b)", [r"2\,\left(a + b\right)"]),
        ("a/(b/c)", [r"\frac{a}{\frac{b}{c}}"]),
        ("a**(b/(2*c))", [r"a^{b / \left(2\,c\right)}"]),
        ("(-a)**2", [r"\left(-a\right)^{2}"]),
        ("a % b - c", [r"\left(a\ \mathrm{mod}\ b\right) - c"]),
        ("a*load**2*part.at(x)", [r"a\,\mathrm{load}^{2} \cdot \mathrm{part.\!at}\left(x\right)"]),
        ("sum(term.x for term in terms)", [r"\sum_{\mathrm{term}\,\in\,\mathrm{terms}} \mathrm{term.\!x}"]),
        ("part.whole().at(x)", [r"\mathrm{part.\!at}\left(x\right)"]),
        ("(a, b[x])", [r"\left(a,\ b_{x}\right)"]),
        ("1 + (a if t < b else 0)", [r"1 + a \quad \mathrm{for}\ t < b", r"1 + 0 \quad \mathrm{otherwise}"]),
        ("a if b is None else c", [r"a \quad \mathrm{without}\ b", r"c \quad \mathrm{otherwise}"]),
    ],
)
def test_an_equation_is_drawn_in_the_order_in_which_it_is_declared(lines, text, expected):
    assert lines("F", text) == [f"F = {line}" for line in expected]
    assert lines("gap'", "-a") == [r"\frac{\mathrm{d}\,\mathrm{gap}}{\mathrm{d}t} = -a"]


@pytest.mark.parametrize(
    "text", ["a @ b", "not a", "[a]", "a if b else c", "a if t < b else (c if t < d else e) + 1 or 2"]
)
def test_what_cannot_be_drawn_is_refused(lines, text):
    with pytest.raises(ValueError, match="cannot be drawn"):
        lines("F", text)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_what_is_drawn_is_what_is_declared(lines, model):
    """The formula is read back, and is the same expression for each case."""
    for name, text in model.equation.items():
        path = text.replace("element().", "")  # a call without arguments is not drawn
        declared = list(cases(ast.parse(path, mode="eval").body))
        drawn = lines(name, text)
        assert len(drawn) == len(declared)
        for line, (condition, node) in zip(drawn, declared, strict=True):
            right = line.partition(" = ")[2]
            formula, _, when = right.partition(r" \quad ")
            assert ast.dump(read_back(formula)) == ast.dump(node), line
            if condition is None:
                assert when in ("", r"\mathrm{otherwise}")
            elif isinstance(condition.ops[0], ast.Is):
                assert when == rf"\mathrm{{without}}\ \mathrm{{{condition.left.id}}}"
            else:
                assert when.startswith(r"\mathrm{for}\ ")
                assert ast.dump(read_back(when.removeprefix(r"\mathrm{for}\ "))) == ast.dump(condition), line


def cases(node):
    """Return the cases of a declaration of which the choice is the outermost operation, each with its condition."""
    while isinstance(node, ast.IfExp):
        yield node.test, node.body
        node = node.orelse
    yield None, node


def read_back(latex):
    """Return the expression of a formula."""
    for sign, word in WORDS.items():
        latex = latex.replace(sign, f" {word} ")
    latex = latex.replace(r"\ \mathrm{mod}\ ", "%").replace(r"\!", "")
    latex = re.sub(r"\\mathrm{([^}]*)}", lambda match: match[1].replace(r"\_", "_"), latex)
    latex = re.sub(r"\\sum_{(\w+)\\,\\in\\,(\w+)} (.*)$", r"sum(\3 for \1 in \2)", latex)
    latex = latex.replace(r"\leq", "<=").replace(r"\cdot", "*").replace(r",\ ", ", ").replace(r"\,", "*")
    for sign, word in {r"\left|": "Abs(", r"\right|": ")", r"\left": "", r"\right": ""}.items():
        latex = latex.replace(sign, word)
    text, rest = without_braces(re.sub(r"\\(sin|cos|exp)\b", r"\1", latex))
    assert not rest
    return ast.parse(text.strip(), mode="eval").body


def without_braces(latex):
    """Return what stands before the end of a group, with operations in place of braces, and what follows it."""
    text = ""
    while latex and not latex.startswith("}"):
        sign = next((sign for sign in (r"\frac{", r"\sqrt{", "^{", "_{") if latex.startswith(sign)), latex[0])
        latex = latex.removeprefix(sign)
        if len(sign) == 1:
            text += sign
            continue
        inner, latex = without_braces(latex)
        latex = latex.removeprefix("}")
        if sign == r"\frac{":
            under, latex = without_braces(latex.removeprefix("{"))
            latex = latex.removeprefix("}")
            text += f"(({inner})/({under}))"
        else:
            text += {r"\sqrt{": f"sqrt({inner})", "^{": f"**({inner})", "_{": f"[{inner}]"}[sign]
    return text, latex


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_every_symbol_of_an_equation_is_explained_on_the_page(pages, model):
    """It is a parameter, an abbreviation, or explained below the equations or in the notes."""
    page = pages[model.__name__]
    explained = set(re.findall(r"``([\w', ]+)``:", page))
    known = {*model.model_fields, *(name for names in explained for name in names.split(", "))}
    known |= set(re.findall(r"`([\w.]+)`", inspect.getdoc(model)))
    known |= {name.removesuffix("'") for name in model.equation}
    known |= set(re.findall(r"for (\w+) in", " ".join(model.equation.values())))
    for text in model.equation.values():
        for symbol in symbols(text) - set(CONSTANTS):
            path = symbol.partition("(")[0]
            assert path in known or path.partition(".")[0] in known, symbol
