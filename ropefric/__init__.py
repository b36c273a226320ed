"""From force traces of a rope on a wheel to a friction law with honest uncertainty, and on to design."""

__all__ = ["__version__"]

__version__ = "0.1.0"
