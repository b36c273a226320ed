"""A campaign's whole way: recordings to forces, forces to a law, the law to the lift force of a wheel."""

__all__: list[str] = []
