"""Measures the prose of comments and documents by module, against allowances that only fall.

    python3 scripts/words.py                 a table of all modules
    python3 scripts/words.py --check         fails where a module exceeds its allowance
    python3 scripts/words.py --lower         lowers the allowances to the measures
    python3 scripts/words.py --list FILE...  every finding of these files, with its line

Columns, in the order of scripts/words.txt:

    openings   share of documentation comments that begin with a word of OPENINGS, in per cent
    what       occurrences of "what" in a thousand words
    told       occurrences of a word of TOLD in a thousand words
    echoes     documentation comments of at most four words that repeat the name of their item
    long       lines of prose over 100 characters

The measures do not judge sentences: they keep a text from going back to habits that it has left.
"""

import argparse
import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parent.parent
ALLOWANCES = ROOT / "scripts/words.txt"
OPENINGS = set("what how whether of where which so who whose whoever those that".split())
TOLD = set("tell tells told said whoever".split())
WIDTH = 100
COLUMNS = ("openings", "what", "told", "echoes", "long")

ITEM = re.compile(
    r"(?:pub(?:\([a-z:]+\))?\s+)?(?:const\s+|async\s+|unsafe\s+)*"
    r"(?:fn|struct|enum|trait|mod|const|static|type|union)?\s*([A-Za-z_][A-Za-z0-9_]*)"
)
# A string or a character, whose slashes begin no comment, or the comment itself.
TOKEN = re.compile(r'r(#+)".*?"\1|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|//[^\n]*', re.DOTALL)


class Prose:
    """Comments and paragraphs of one file: (line, text, true at the start of a document, item)."""

    def __init__(self, path):
        self.path = path
        self.lines = path.read_text(encoding="utf-8").splitlines()
        self.parts = []
        {".rs": self._rust, ".py": self._python, ".md": self._markdown}[path.suffix]()

    def _rust(self):
        text = "\n".join(self.lines)
        open_block, fenced = None, False
        for found in TOKEN.finditer(text):
            if not found.group().startswith("//"):
                continue
            number = text.count("\n", 0, found.start())
            comment = found.group()
            whole = self.lines[number].lstrip().startswith("//")
            kind = next((k for k in ("///", "//!") if comment.startswith(k)), "//")
            body = comment[len(kind) :].strip()
            begins = kind != "//" and whole and open_block != (kind, number)
            open_block = (kind, number + 1) if kind != "//" and whole else None
            if begins:
                fenced = False
            if body.startswith("```"):
                fenced = not fenced
                continue
            if not fenced and body:
                self.parts.append((number, body, begins, self._item(number) if begins else None))

    def _item(self, number):
        """Name of the item that the documentation on this line belongs to; none for longer
        blocks."""
        size = number
        while size < len(self.lines) and self.lines[size].lstrip().startswith("///"):
            size += 1
        if size - number != 1:
            return None
        while size < len(self.lines) and self.lines[size].lstrip().startswith("#["):
            size += 1
        found = ITEM.match(self.lines[size].strip()) if size < len(self.lines) else None
        return found and found.group(1)

    def _python(self):
        quoted = False
        for number, line in enumerate(self.lines):
            text = line.strip()
            begins = False
            if not quoted and re.match(r'[rf]?"""', text):
                quoted, begins, text = True, True, text.lstrip("rf")[3:]
            if quoted:
                if text.endswith('"""'):
                    quoted, text = False, text[:-3]
                if text and not text.startswith(">>>"):
                    self.parts.append((number, text, begins, None))
            elif text.startswith("#") and not text.startswith("#!"):
                self.parts.append((number, text.lstrip("#: "), False, None))

    def _markdown(self):
        fenced = False
        for number, line in enumerate(self.lines):
            if line.lstrip().startswith("```"):
                fenced = not fenced
            elif not fenced and line.strip():
                self.parts.append((number, line.strip(), False, None))

    def _is_long(self, number):
        line = self.lines[number]
        # A table's row and an address cannot be wrapped.
        return len(line) > WIDTH and not line.lstrip().startswith("|") and "://" not in line

    def findings(self):
        """(column, line, excerpt) of all that is counted."""
        for number, text, begins, item in self.parts:
            words = words_of(text)
            if begins and words and words[0] in OPENINGS:
                yield "openings", number, text
            yield from (("what", number, text) for word in words if word == "what")
            yield from (("told", number, text) for word in words if word in TOLD)
            if item and len(words) <= 4 and set(parts_of(item)) <= set(words):
                yield "echoes", number, text
            if self._is_long(number):
                yield "long", number, text


def words_of(text):
    """Words outside of code, in lower case."""
    return re.findall(r"[a-z]+(?:'[a-z]+)?", re.sub(r"`[^`]*`", " ", text).lower())


def parts_of(name):
    """Words that a name is made of."""
    return [part.lower() for part in re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+", name)]


def files():
    """All sources and documents that are held to the measures."""
    paths = [*ROOT.glob("crates/**/*.rs"), *ROOT.glob("crates/**/*.py"), *ROOT.glob("scripts/*.py")]
    paths += [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    return sorted(p for p in paths if "target" not in p.relative_to(ROOT).parts)


def module_of(path):
    """A crate, a folder of its sources where it has some, its tests, or a document."""
    parts = path.relative_to(ROOT).parts
    if parts[0] != "crates":
        return parts[0] if len(parts) > 1 and parts[0] != "docs" else "/".join(parts)
    if "tests" in parts[:-1] or path.name == "tests.rs":
        return f"{parts[1]}/tests"
    folder = parts[3:-1] if parts[2] == "src" else parts[2:3]
    name = folder[0] if folder else Path(parts[-1]).stem
    return f"{parts[1]}/{name}"


def measure():
    """The five numbers of each module."""
    count, words, docs = defaultdict(lambda: dict.fromkeys(COLUMNS, 0)), defaultdict(int), defaultdict(int)
    for path in files():
        prose, module = Prose(path), module_of(path)
        words[module] += sum(len(words_of(text)) for _, text, _, _ in prose.parts)
        docs[module] += sum(begins for _, _, begins, _ in prose.parts)
        for column, _, _ in prose.findings():
            count[module][column] += 1
    for module in sorted(words):
        found = count[module]
        per_word, per_doc = 1000 / max(words[module], 1), 100 / max(docs[module], 1)
        yield module, (
            round(found["openings"] * per_doc, 1),
            round(found["what"] * per_word, 1),
            round(found["told"] * per_word, 1),
            found["echoes"],
            found["long"],
        )


def allowances():
    """The numbers of words.txt by module; a module that is not listed is allowed nothing."""
    if not ALLOWANCES.exists():
        return {}
    rows = (line.split() for line in ALLOWANCES.read_text(encoding="utf-8").splitlines())
    return {row[0]: tuple(map(float, row[1:])) for row in rows if row and row[0] != "#"}


def write(rows):
    """Writes words.txt."""
    lines = ["# Allowances of scripts/words.py; `--lower` lowers them."]
    lines.append(f"# {'module':40}" + "".join(f"{column:>10}" for column in COLUMNS))
    lines += [f"{module:42}" + "".join(f"{value:>10g}" for value in row) for module, row in rows]
    ALLOWANCES.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--check", action="store_true")
    arguments.add_argument("--lower", action="store_true")
    arguments.add_argument("--list", nargs="+", type=Path)
    arguments = arguments.parse_args()
    if arguments.list:
        for path in arguments.list:
            for column, number, text in Prose(path.resolve()).findings():
                print(f"{path}:{number + 1}: {column}: {text}")
        return
    measured, allowed = list(measure()), allowances()
    if arguments.lower:
        nothing = (float("inf"),) * len(COLUMNS)
        write((name, tuple(map(min, row, allowed.get(name, nothing)))) for name, row in measured)
        return
    if not arguments.check:
        print(f"{'':42}" + "".join(f"{column:>10}" for column in COLUMNS))
        for module, row in measured:
            print(f"{module:42}" + "".join(f"{value:>10g}" for value in row))
        return
    above = [
        f"{module}: {column} {value:g}, allowed {limit:g}"
        for module, row in measured
        for column, value, limit in zip(COLUMNS, row, allowed.get(module, (0,) * len(COLUMNS)))
        if value > limit
    ]
    if above:
        print("\n".join(above), "python3 scripts/words.py --list FILE names each place", sep="\n")
        sys.exit(1)


main()
