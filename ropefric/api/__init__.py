"""The functions of `import ropefric as rf`: what notebooks and scripts need, each a call into its room.

Each module is loaded on the first use of one of its functions, see `ropefric.__getattr__`.
"""

__all__: list[str] = []
