"""tashika: a many-light renderer that knows its own error.

>>> import tashika
>>> image = tashika.render(tashika.builtin("tiny"), size=(8, 6), vpls=200, error=0.02)
>>> image["radiance"].shape
(6, 8, 3)
"""

from collections.abc import Mapping as _Mapping
from typing import TYPE_CHECKING as _TYPE_CHECKING

from ._errors import Error, FileError, InputError, OptionError, UnsupportedError
from ._tashika import (
    Camera,
    Comparison,
    Image,
    Light,
    Material,
    Medium,
    Mesh,
    Scene,
    VplSet,
    __version__,
    builtin,
    compare,
    coverage,
    exact,
    load,
    merge,
    read,
    render,
    sensors,
    vpls,
)

_Mapping.register(Image)

if not _TYPE_CHECKING:
    from ._names import suggesting as _suggesting

    builtin, compare, coverage, exact, load, merge, read, render, sensors, vpls = map(
        _suggesting, (builtin, compare, coverage, exact, load, merge, read, render, sensors, vpls)
    )

__all__ = [
    "Camera",
    "Comparison",
    "Error",
    "FileError",
    "Image",
    "InputError",
    "Light",
    "Material",
    "Medium",
    "Mesh",
    "OptionError",
    "Scene",
    "UnsupportedError",
    "VplSet",
    "builtin",
    "compare",
    "coverage",
    "exact",
    "load",
    "merge",
    "read",
    "render",
    "sensors",
    "vpls",
]
