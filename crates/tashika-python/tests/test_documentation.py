"""Examples in the documentation run, types match the module, the example makes its table."""

import ast
import doctest
import importlib.util
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import tashika
from tashika import _tashika

HERE = Path(__file__).parent.parent
NAMES = [name for name in tashika.__all__ if not name.endswith("Error")]


def documented() -> Iterator[tuple[str, str]]:
    """Everything that has documentation, with its text."""
    yield "tashika", tashika.__doc__ or ""
    for name in tashika.__all__:
        thing = getattr(tashika, name)
        yield name, thing.__doc__ or ""
        for attribute, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not attribute.startswith("_") and attribute not in ("KINDS",):
                yield (
                    f"{name}.{attribute}",
                    getattr(value, "__doc__", None) or getattr(thing, attribute).__doc__ or "",
                )


@pytest.mark.parametrize(("name", "text"), list(documented()))
def test_examples_run(name: str, text: str) -> None:
    if not name.endswith("Error"):
        assert text.strip(), f"{name} has no documentation"
    without_fences = "\n".join(line for line in text.splitlines() if not line.startswith("```"))
    test = doctest.DocTestParser().get_doctest(without_fences, {"tashika": tashika}, name, None, 0)
    runner = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    said: list[str] = []
    runner.run(test, out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)


def test_there_are_examples() -> None:
    assert sum(">>>" in text for _, text in documented()) >= 10


def parameters(function: ast.FunctionDef) -> list[tuple[str, str]]:
    """Names and defaults as the types file has them; `...` stands for any default."""
    arguments = function.args
    plain = [*arguments.posonlyargs, *arguments.args]
    defaults = [None] * (len(plain) - len(arguments.defaults)) + list(arguments.defaults)
    pairs = [*zip(plain, defaults), *zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return [(a.arg, ast.unparse(d) if d else "") for a, d in pairs if a.arg not in ("self", "cls")]


def assert_same_parameters(where: str, typed: ast.FunctionDef, built: object) -> None:
    signature = inspect.signature(built)  # type: ignore[arg-type]
    real = [
        (p.name, "" if p.default is p.empty else repr(p.default))
        for p in signature.parameters.values()
        if p.name not in ("self", "cls")
    ]
    stated = parameters(typed)
    assert [name for name, _ in stated] == [name for name, _ in real], where
    for (name, ours), (_, theirs) in zip(stated, real):
        # A default that is no literal in Rust is `...` at run time.
        assert ours == theirs or (theirs and "..." in (ours, theirs.replace("Ellipsis", "..."))), (
            f"{where}({name}={ours}), but {theirs}"
        )


def test_types_are_those_of_the_module() -> None:
    source = Path(_tashika.__file__ or "").with_name("_tashika.pyi").read_text()
    stated = {
        node.name: node
        for node in ast.parse(source).body
        if isinstance(node, (ast.ClassDef, ast.FunctionDef))
    }
    assert sorted(stated) == sorted(NAMES)
    for name, node in stated.items():
        built = getattr(_tashika, name)
        if isinstance(node, ast.FunctionDef):
            assert_same_parameters(name, node, built)
            continue
        members = {n.name: n for n in node.body if isinstance(n, ast.FunctionDef)}
        public = {member for member in vars(built) if not member.startswith("_")}
        constants = {
            n.target.id for n in node.body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)
        }
        assert {m for m in members if not m.startswith("_")} | constants == public, name
        for member, function in members.items():
            is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in function.decorator_list)
            if member == "__new__":
                assert_same_parameters(name, function, built)
            elif not is_property and not member.startswith("__"):
                assert_same_parameters(f"{name}.{member}", function, getattr(built, member))


def test_the_package_says_that_it_is_typed() -> None:
    spec = importlib.util.find_spec("tashika")
    assert spec is not None and spec.origin is not None and Path(spec.origin).with_name("py.typed").exists()


def test_the_example_makes_the_table_of_the_program() -> None:
    typed = ["builtin:tiny", "--size", "8", "6", "--vpls", "100", "--gather", "1"]
    program = [sys.executable, str(HERE / "examples" / "iwasaki2019_table.py"), *typed]
    said = subprocess.run(program, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split()[0] for line in said[1:]] == [
        "lightcuts", "mdlc", "nabata2016", "sakai2018", "iwasaki2019", "tashika", "tashika-certified",
    ]  # fmt: skip
    assert "48 of 48" in said[-1]
