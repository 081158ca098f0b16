"""What is said of an export."""


class CannotBeRendered(Exception):
    """Why there can be no picture, in words for the user."""


class Notes:
    """What was left out or replaced, each with the names of what it is about."""

    #: Names that are told of one kind.
    NAMES = 5

    def __init__(self):
        self._found = {}

    def add(self, what, name=None):
        names = self._found.setdefault(what, [])
        if name is not None and name not in names:
            names.append(name)

    def lines(self):
        return [self._line(what, names) for what, names in self._found.items()]

    def _line(self, what, names):
        if not names:
            return what
        more = len(names) - self.NAMES
        told = ", ".join(names[: self.NAMES]) + (f" and {more} more" if more > 0 else "")
        return f"{what}: {told}"
