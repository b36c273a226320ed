"""A virtual test rig: recordings and campaigns whose truth is known."""
