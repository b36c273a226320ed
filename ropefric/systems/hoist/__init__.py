"""A rope on a driven wheel: what it lifts, with as many effects as are asked for.

`problem` is what is known of a hoist at many operating points, `contact` the force balance along the wrap and the
lift it gives, `effects` what a scene may leave out and what that may cost.
"""
