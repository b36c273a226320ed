"""A law's equation, as declared in plain text, typeset as MathML.

The notation is that of every law: `mu_inf (1 - exp(a R_w/R_r + b))`. A name right before a bracket is a function of
what stands in it, two factors beside each other are multiplied, and `integral of X from A to B` is one over the wrap.
"""

import re
from html import escape

from ropefric.friction.law import FrictionLaw

_TOKEN = re.compile(r"(\d+(?:\.\d+)?)|([A-Za-z]\w*)|(\S)")
_GREEK = {"mu": "μ", "phi": "φ", "lambda": "λ", "inf": "∞"}
_SYMBOL = re.compile(r"([A-Za-z]+?)(?:_(\w+)|(\d+))?")
_FUNCTIONS = {"exp", "sqrt", "sin", "arccos", "ln"}
_SPACE = '<mspace width="0.17em"/>'


def formulas(law: FrictionLaw) -> tuple[str, ...]:
    """Return the statements of a law's equation as MathML elements; what is not in our notation stays plain text."""
    statements = [text for part in law.equation.split(";") for text in _split(part.strip())]
    return tuple(f'<math display="block">{_typeset(text)}</math>' for text in statements)


def _typeset(text: str) -> str:
    try:
        return _Statement(text).typeset()
    except ValueError:  # a law of somebody's own may be written in any way
        return f"<mtext>{escape(text)}</mtext>"


def symbol(name: str) -> str:
    """Return a plain symbol such as mu_R as MathML, its index set low."""
    found = _SYMBOL.fullmatch(name)
    base, *indices = found.groups() if found else (name, None, None)
    index = indices[0] or indices[1]
    if len(base) > 2 and base not in _GREEK:  # a word, not a letter with an index
        return f"<mi>{name.replace('_', ' ')}</mi>"
    letter = f"<mi>{_GREEK.get(base, base)}</mi>"
    if not index:
        return letter
    kind = "mn" if index.isdigit() else "mi"
    return f"<msub>{letter}<{kind}>{_GREEK.get(index, index)}</{kind}></msub>"


def _split(text: str) -> list[str]:
    """Return what commas outside brackets part."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


class _Bracket(str):
    """What stands in brackets, with them; `inner` is without, for where a bar or a raised place takes their part."""

    __slots__ = ("inner",)
    inner: str


def _bare(found: str) -> str:
    return found.inner if isinstance(found, _Bracket) else found


class _Statement:
    """A statement and how far it is read; each method reads what it is named after and returns it as MathML."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = [(found[0], found.start(found.lastindex or 0)) for found in _TOKEN.finditer(text)]
        self.place = 0

    def typeset(self) -> str:
        words = ""
        while self.ahead in {"local", "average"}:
            words += f"<mtext>{self.take()}</mtext>{_SPACE}"
        found = words + self.sum()
        while self.ahead == "=":
            self.take()
            found += f"<mo>=</mo>{self.sum()}"
        if self.ahead:
            raise ValueError(f"{self.text!r} is no equation from {self.ahead!r} on")
        return f"<mrow>{found}</mrow>"

    @property
    def ahead(self) -> str:
        return self.tokens[self.place][0].strip() if self.place < len(self.tokens) else ""

    def take(self) -> str:
        found = self.ahead
        self.place += 1
        return found

    def sum(self) -> str:
        found = self._sign() + self.product() if self.ahead == "-" else self.product()
        while self.ahead in {"+", "-"}:
            found += self._sign() + self.product()
        return found

    def _sign(self) -> str:
        return f"<mo>{self.take().replace('-', '−')}</mo>"

    def product(self) -> str:
        found = [self.quotient()]
        while self.ahead and self.ahead not in "=+-)" and self.ahead not in {"from", "to"}:
            found.append(self.quotient())
        return _SPACE.join(found)

    def quotient(self) -> str:
        found = self.power()
        while self.ahead == "/":
            self.take()
            found = f"<mfrac><mrow>{_bare(found)}</mrow><mrow>{_bare(self.power())}</mrow></mfrac>"
        return found

    def power(self) -> str:
        found = self.atom()
        if self.ahead != "^":
            return found
        self.take()
        raised = f"<mrow>{_bare(self.atom())}</mrow>"
        if found.startswith("<msub>"):
            return f"<msubsup>{found[6:-7]}{raised}</msubsup>"
        return f"<msup>{found}{raised}</msup>"

    def atom(self) -> str:
        word = self.take()
        if word == "(":
            return self._bracket()
        if word == "integral":
            return self._integral()
        if word[:1].isdigit():
            return f"<mn>{word}</mn>"
        if not word[:1].isalpha():
            raise ValueError(f"{self.text!r} has {word!r} where a number or a name belongs")
        called = self.place < len(self.tokens) and self.tokens[self.place][0] == "("  # no blank before it
        if not called:
            return symbol(word)
        self.take()
        inner = self._bracket()
        if word == "sqrt":
            return f"<msqrt>{_bare(inner)}</msqrt>"
        name = f"<mi>{word}</mi>" if word in _FUNCTIONS else symbol(word)
        return f"<mrow>{name}<mo>&#x2061;</mo>{inner}</mrow>"

    def _bracket(self) -> str:
        inner = self.sum()
        self.expect(")")
        found = _Bracket(f"<mrow><mo>(</mo>{inner}<mo>)</mo></mrow>")
        found.inner = inner
        return found

    def _integral(self) -> str:
        self.expect("of")
        of = self.sum()
        self.expect("from")
        low = self.sum()
        self.expect("to")
        high = self.sum()
        ends = f"<munderover><mo>∫</mo><mrow>{low}</mrow><mrow>{high}</mrow></munderover>"
        return f"<mrow>{ends}{of}{_SPACE}<mi>d</mi>{symbol('phi')}</mrow>"

    def expect(self, word: str) -> None:
        if self.take() != word:
            raise ValueError(f"{self.text!r} lacks {word!r}")
