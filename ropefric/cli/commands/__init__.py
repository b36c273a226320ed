"""The commands: one file each, found by themselves."""

__all__: list[str] = []
