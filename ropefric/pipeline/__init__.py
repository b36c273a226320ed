"""A campaign's whole way: recordings to forces, forces to a law, the law to the lift force of a wheel.

`run` does it and writes tables, fits and prediction; `evidence` adds what a report shows beyond the answer, and says
what a result was made from, in a manifest by which it can be made again.
"""
