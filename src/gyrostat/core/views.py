"""Text and JSON of results, as generic functions.

A result calls them for its own methods. The file of a view imports the result and registers itself
for its class, so that a result does not import its views; the room imports both.
"""

from functools import singledispatch


@singledispatch
def lines(result: object) -> list[str]:
    """Lines of a result, as the command line prints them.

    Raises:
        TypeError: No view is registered for the class of the result.
    """
    raise TypeError(f"found no text of {type(result).__name__}, expected a registered view")


@singledispatch
def content(result: object) -> dict[str, object]:
    """Content of the JSON file of a result.

    Raises:
        TypeError: No view is registered for the class of the result.
    """
    raise TypeError(f"found no JSON of {type(result).__name__}, expected a registered view")
