"""Flight with the largest response of a search."""

from collections.abc import Generator
from typing import TypeVar

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.search.moves import FIRST, Answers, Moves

Result = TypeVar("Result")


class Largest:
    """Flight with the largest response so far; the first one of equal responses.

    Attributes:
        number: Its number; `FIRST` before the first flight.
        response: Its response; minus infinity before the first flight.
        normal: Its standard normal numbers, (keys,).
    """

    def __init__(self) -> None:
        self.number, self.response = FIRST, -np.inf
        self.normal: Vector = np.zeros(0)

    def follow(
        self, search: Generator[Moves, Answers, Result]
    ) -> Generator[Moves, Answers, Result]:
        """Pass on the requests of a search and their answers.

        Every flight of the search passes here, whatever it was requested for. The result is
        therefore the largest one in the table of runs.
        """
        moves = next(search)
        while True:
            answers = yield moves
            self._take(answers)
            try:
                moves = search.send(answers)
            except StopIteration as end:
                return end.value

    def _take(self, answers: Answers) -> None:
        indices = np.flatnonzero(answers.numbers >= 0)
        if len(indices) == 0:
            return
        index = indices[np.argmax(answers.response[indices])]
        if answers.response[index] > self.response or self.number == FIRST:
            self.number = int(answers.numbers[index])
            self.response = float(answers.response[index])
            self.normal = answers.normal[index]
