"""The exceptions of the package; each states the found value and the accepted ones."""


class Error(Exception):
    """Base class of all errors of the library."""


class FileError(Error, OSError):
    """The system could not read or write a file."""


class InputError(Error, ValueError):
    """A file or an array has invalid contents."""


class UnsupportedError(Error, ValueError):
    """The input is valid, but needs a feature that is not supported."""


class OptionError(Error, ValueError):
    """An argument has an unusable value."""


# Modules by which users import the names.
for _class in (Error, FileError, InputError, UnsupportedError, OptionError):
    _class.__module__ = "tashika"
