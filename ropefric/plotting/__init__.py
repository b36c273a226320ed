"""Figures: the only room that knows matplotlib. Each figure carries the data it shows."""

__all__: list[str] = []
