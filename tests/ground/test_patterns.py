"""Every regular expression of the package takes time in proportion to its text, whatever the text.

Decided without a clock: a backtracking matcher needs more than linear time only if its automaton can loop in one
state and, reading the same letters, also leave it for another that it can loop in (or come back on two ways). Each
pattern is parsed by Python's own parser, made into such an automaton and searched for that. Measured times would be
noise on a busy machine, and strings of ours would only show the attacks we thought of.
"""

import importlib
import pkgutil
import re
from collections import deque
from pathlib import Path
from re import _compiler, _constants, _parser

import ropefric

METHODS = {"match", "fullmatch", "search", "sub", "subn", "split", "findall", "finditer"}
SEARCHING = METHODS - {"match", "fullmatch"}
OTHERS = " \t\n0189aAzZ_éµ²°%$-+*/^.,;:()[]{}'\"\\#=<>|!"
FEW = 4  # repeats up to so many are unrolled; more count as endless


def patterns():
    """Return every compiled pattern that is a module's own, by the name it has there."""
    found = {}
    names = (name for _, name, _ in pkgutil.walk_packages(ropefric.__path__, "ropefric."))
    for name in sorted(one for one in names if "__main__" not in one and not one.endswith(".training")):
        for key, value in vars(importlib.import_module(name)).items():
            for one in value.values() if isinstance(value, dict) else [value]:
                if isinstance(one, re.Pattern):
                    found.setdefault((one.pattern, one.flags), set()).add(key)
    return found


def uses():
    """Return by which methods names are used that may be those of patterns, in the whole package."""
    call = re.compile(rf"\b(\w+)(?:\[[^]\n]*\])?\.({'|'.join(METHODS)})\(")
    found = {}
    for path in Path(ropefric.__file__).parent.rglob("*.py"):
        for name, method in call.findall(path.read_text(encoding="utf-8")):
            found.setdefault(name, set()).add(method)
    return found


class Automaton:
    """States, each reading one letter of a set; `before` and `last` as in Glushkov's construction.

    Possessive repeats and atomic groups give nothing back: what they repeat counts as read once. Assertions are
    letters that are never there, so that nothing behind one is sure to match.
    """

    def __init__(self, pattern, flags, *, searching):
        tree = _parser.parse(pattern, flags)
        self.flags = tree.state.flags
        self.alphabet = sorted(set(OTHERS) | {c for c in pattern if c.isprintable()})
        self.reads, self.follow, self.twice = [], {}, set()
        first, last, _ = self.build(tree)
        self.accepting = set(last)
        if searching:  # every place may be the start: a loop over anything before the pattern
            self.reads.append(frozenset(self.alphabet))
            self.follow[len(self.reads) - 1] = {len(self.reads) - 1, *first}

    def leaf(self, node):
        one = _parser.SubPattern(self.state, [node])
        read = _compiler.compile(one, self.flags)
        self.reads.append(frozenset(c for c in self.alphabet if read.fullmatch(c)))
        self.follow[len(self.reads) - 1] = set()
        return {len(self.reads) - 1}

    def sequence(self, parts):
        first, last, empty = set(), set(), True
        for a, b, e in parts:
            for state in last:
                self.follow[state] |= a
            if empty:
                first |= a
            last = b | (last if e else set())
            empty = empty and e
        return first, last, empty

    def loop(self, part):
        for state in part[1]:
            # A loop around a loop: two ways from one letter to the next.
            self.twice |= {(state, after) for after in part[0] & self.follow[state]}
            self.follow[state] |= part[0]
        return part

    def build(self, tree):
        self.state = tree.state
        return self.sequence([self.node(one) for one in tree])

    def node(self, one):  # noqa: PLR0911  (a kind of node, a return)
        kind, value = one
        if kind in (_constants.MAX_REPEAT, _constants.MIN_REPEAT):
            low, high, inner = value
            if high == _constants.MAXREPEAT or high > FEW:
                first, last, empty = self.loop(self.build(inner))
                return first, last, empty or low == 0
            parts = [self.build(inner) for _ in range(high)]
            return self.sequence([(a, b, e or place >= low) for place, (a, b, e) in enumerate(parts)])
        if kind is _constants.POSSESSIVE_REPEAT:
            low, _, inner = value
            first, last, empty = self.build(inner)
            return first, last, empty or low == 0
        if kind is _constants.ATOMIC_GROUP:
            return self.build(value)
        if kind is _constants.SUBPATTERN:
            return self.build(value[3])
        if kind is _constants.BRANCH:
            parts = [self.build(branch) for branch in value[1]]
            return (set().union(*(p[0] for p in parts)), set().union(*(p[1] for p in parts)),
                any(p[2] for p in parts))  # fmt: skip
        if kind in (_constants.AT, _constants.ASSERT, _constants.ASSERT_NOT, _constants.GROUPREF):
            if kind in (_constants.ASSERT, _constants.ASSERT_NOT):
                assert not any(inner[0] in (_constants.MAX_REPEAT, _constants.MIN_REPEAT)
                    for inner in value[1])  # fmt: skip
            return set(), set(), True
        return (*[self.leaf(one)] * 2, False)

    def step(self, states, letter):
        """Return where tuples of states may be after reading a letter."""
        choices = [[s for s in self.follow[state] if letter in self.reads[s]] for state in states]
        return [(a, b, c) for a in choices[0] for b in choices[1] for c in choices[2]]

    def ambiguous(self):
        """Return two states p, q with p->p, p->q and q->q on one text; None where there are none."""
        letters = self.alphabet
        reach = {state: self.reached(state) for state in self.follow}
        for before, after in self.twice:
            if before in reach[after]:
                return before, after
        loops = [state for state in self.follow if state in reach[state]]
        for p in loops:
            for q in loops:
                if p == q or q not in reach[p]:
                    continue
                seen, queue = {(p, p, q)}, deque([(p, p, q)])
                while queue:
                    for letter in letters:
                        for now in self.step(queue[0], letter):
                            if now == (p, q, q):
                                return p, q
                            if (now not in seen and p in reach[now[0]] and q in reach[now[1]] | {now[1]}
                                    and q in reach[now[2]]):  # fmt: skip
                                seen.add(now)
                                queue.append(now)
                    queue.popleft()
        return None

    def reached(self, state):
        seen, queue = set(), [state]
        while queue:
            for after in self.follow[queue.pop()]:
                if after not in seen:
                    seen.add(after)
                    queue.append(after)
        return seen


def fault(pattern, flags, methods):
    """Return what makes a pattern slow, or nothing."""
    pattern = pattern.decode("latin-1") if isinstance(pattern, bytes) else pattern
    found = Automaton(pattern, flags, searching=False).ambiguous()
    if found:
        return f"states {found} read the same text"
    if methods & SEARCHING:
        automaton = Automaton(pattern, flags, searching=True)
        found = automaton.ambiguous()
        guarded = pattern.startswith(("(?<!", "^"))  # starts once in a run, or at one place only
        # Where a match is sure once that state was read, a search goes on behind it.
        if found and not guarded and found[1] not in automaton.accepting:
            return f"a search begins again at each letter of what state {found[1]} has read"
    return ""


def test_every_pattern_is_linear_and_a_constant_of_its_module():
    used = uses()
    assert "re" not in used
    for pattern, names in patterns().items():
        # One without a method of its own is part of another pattern.
        methods = set().union(*(used.get(name, set()) for name in names)) or {"fullmatch"}
        assert not fault(*pattern, methods), names


SLOW = ((r"(a+)+b", "match"), (r"(aa|a)*b", "match"), (r"\s*(.+?)[\s._]*[(]x", "fullmatch"),
    (r"\d+\.?\d*x", "match"), (r"(?:[^\W\d_]+|_)+\d", "fullmatch"), (r"\s*,", "sub"), (r"a+_", "search"),
    (r"(x+x+)+y", "match"), (r"[\d.,]*,[\d.,]*", "fullmatch"), (r"(.*?,){3,}x", "match"),
    (r"(ab|a|b)*c", "match"))  # fmt: skip
QUICK = ((r"\s++,x", "match"), (r"\d++(?:\.\d*+)?", "fullmatch"), (r"a*", "sub"), (r"[a-z]+_\d+", "match"),
    (r"(?:,\d{3})+", "fullmatch"), (r'"[^"]*"', "fullmatch"), (r"a?b?c?", "match"),
    (r"\$[a-z]+\$", "search"))  # fmt: skip


def test_slow_patterns_are_told_from_quick_ones():
    assert [one for one in SLOW if not fault(one[0], 0, {one[1]})] == []
    assert [one for one in QUICK if fault(one[0], 0, {one[1]})] == []
