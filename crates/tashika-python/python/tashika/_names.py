"""Suggestions for unknown keywords of functions."""

import difflib
import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def suggesting(function: Callable[P, R]) -> Callable[P, R]:
    """Wraps a function so that its TypeError for an unknown keyword suggests a known one."""
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

    # Module in which the name is found, so that the function can be pickled.
    call.__module__ = "tashika"
    return call
