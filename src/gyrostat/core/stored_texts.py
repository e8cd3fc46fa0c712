"""Texts that take long to make, kept in the private cache."""

import hashlib
import json
from collections.abc import Callable
from typing import Any

from gyrostat.core.cache import private_cache
from gyrostat.core.stored_function import surroundings
from gyrostat.core.stored_trees import structure_text


def stored_texts(about: Any, make: Callable[[], dict[str, str]]) -> dict[str, str]:
    """Return the texts that were made for the same data before, or make and keep them.

    Args:
        about: All data that determine the texts, without arrays: a tree of numbers, texts and
            classes. The code of this package, all versions and the processor are part of the name
            of the entry. With an object, class or function that is not of this package, the texts
            are made anew and not kept.
        make: Function that makes the texts from these data: name -> text.
    """
    description = structure_text(about, is_data=False)
    cache = None if description is None else private_cache()
    if cache is None:
        return make()
    name = f"texts-{hashlib.sha256(f'{description} {surroundings()}'.encode()).hexdigest()}"
    content = cache.read(name)
    if content is not None:
        return json.loads(content)
    texts = make()
    cache.write(name, json.dumps(texts).encode())
    return texts
