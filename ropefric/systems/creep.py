"""Elastic creep: in a steady run as much belt passes every place, so a strained belt runs faster than a slack one."""

from ropefric.arrays import FloatArray


def speed_ratio(strain: FloatArray, reference: FloatArray | float = 0.0) -> FloatArray:
    """Return how fast a belt runs where it is strained, over where it has the reference's strain T/EA."""
    return (1.0 + strain) / (1.0 + reference)
