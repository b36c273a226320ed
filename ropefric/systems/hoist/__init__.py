"""A rope on a driven wheel: what it lifts, with as many effects as are asked for.

`contact` has the data of a hoist at many operating points, the force balance along the wrap and the lift force,
`effects` what a scene may leave out, and what that may cost.
"""
