"""The exceptions of the package; each says what was found and what would be accepted."""


class Error(Exception):
    """Everything that the library refuses."""


class FileError(Error, OSError):
    """The system could not read or write a file."""


class InputError(Error, ValueError):
    """What a file or an array says cannot be."""


class UnsupportedError(Error, ValueError):
    """The input is sound, but asks for what is not done here."""


class OptionError(Error, ValueError):
    """An argument has an unusable value."""


# Named as users import them.
for _class in (Error, FileError, InputError, UnsupportedError, OptionError):
    _class.__module__ = "tashika"
