"""One recording -> the break-away force F_A.

In: a recording file and an `ImportProfile`. Out: `Breakaway`. On the way: RawRecording -> ForceTrace -> Breakaway.

readers/: file -> `RawRecording`, columns as they are in it. assemble.py: -> `ForceTrace` (trace.py) in SI, with channels
computed by formula, by clock.py (time stamps mended or refused) and calibration.py (counts -> newtons, tare, what the
chain leaves uncertain). protocols.py: a way of measuring picks its break-aways, or a person does; decision.py: whether
there is one; slips.py: which fall is macroscopic; evidence.py: what speaks for a slip or a motor, and what the converter
did not show; doubts.py: what the samples right before a top give away; zero.py: what the rope at rest and sliding says
of the zero; results.py: how what was found is told; segments.py: noise, rest, sliding; events.py: falls and pulls, and
what they look like; peak.py: its height and uncertainty; noise.py: noise, spikes, stuck converters, mains hum;
smoothing.py: the moving average; breakaway.py: the result, and what a user decides.
"""
