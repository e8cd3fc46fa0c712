"""The one error that a user's input can cause."""


class InputError(ValueError):
    """Input that cannot be used.

    Its text is one line that names the file or place, what was found and what was expected. The
    command line prints it and exits with 2.
    """
