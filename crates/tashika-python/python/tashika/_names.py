"""Keywords that a function does not have, with the one that was probably meant."""

import difflib
import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def suggesting(function: Callable[P, R]) -> Callable[P, R]:
    """The same function, whose TypeError for an unknown keyword suggests a known one."""
    known = list(inspect.signature(function).parameters)
    name = function.__name__

    @functools.wraps(function)
    def call(*args: P.args, **keywords: P.kwargs) -> R:
        for keyword in keywords:
            if keyword not in known:
                near = difflib.get_close_matches(keyword, known, n=1, cutoff=0.7)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise TypeError(f"{name}() got an unexpected keyword argument {keyword!r}{hint}")
        return function(*args, **keywords)

    # Where it is found by its name, so that it can be pickled.
    call.__module__ = "tashika"
    return call
