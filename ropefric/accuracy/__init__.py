"""What accuracy costs in time: every numerical choice of the tool, its error and its time, measured."""

__all__: list[str] = []
