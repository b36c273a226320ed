"""A rope on a driven wheel: what it lifts, with as many effects as are asked for.

`contact` is what is known of a hoist at many operating points, the force balance along the wrap and the lift it gives,
`effects` what a scene may leave out, and what that may cost.
"""
