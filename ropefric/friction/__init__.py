"""Friction laws of a rope on a wheel and the integral of μ over the wrap."""
