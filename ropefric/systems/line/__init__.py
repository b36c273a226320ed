"""A rope, cable, belt or tendon through a series of elements: conduits, tendon drives, tendons in concrete, hauling.

The tension is known at one end. Each element changes it: a bend by e^M, a straight run by its weight and friction, a
wheel by its bearing, a drum by what drives or brakes it. `element` says what an element is and how a rope passes it,
`elements` has one file for each kind, `line` puts them together, `tendon` adds what stressing and anchoring a tendon
does, `effects` says what a scene may leave out.

A line is pulled when the rope moves from the first element to the last: friction then makes the tension grow. It is
paid out when the rope moves the other way, so that friction helps the hand at the end.
"""
