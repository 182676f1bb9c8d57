"""Exceptions of the package."""


class Error(Exception):
    """Base of all exceptions of this package."""


class InputError(Error, ValueError):
    """Something is wrong with what was given; the text names the array and the index, or the file and the line."""


class InternalError(Error, RuntimeError):
    """Something failed that is not the caller's doing, such as a full disk."""


class Interrupted(Error):
    """The progress callable returned False; there is no result, and no file was written."""
