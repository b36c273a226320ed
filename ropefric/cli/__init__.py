"""The command line: presentation only. Every number it prints comes from the library."""

__all__: list[str] = []
