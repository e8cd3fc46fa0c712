"""One run of a scenario: its parts, its loop and its metrics."""

__all__: list[str] = []
