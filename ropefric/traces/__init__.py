"""One recording -> the break-away force F_A.

In: a recording file and an `ImportProfile`. Out: `Breakaway`. On the way: RawRecording -> ForceTrace -> Breakaway.

readers/: file -> `RawRecording`, columns as they are in it. assemble.py: -> `ForceTrace` (trace.py) in SI, from
signals over clocks of their own (signals.py), by clock.py (time stamps mended or refused), calibration.py (counts or
volts -> newtons, tare, what the chain leaves uncertain) and formulas.py (channels computed from others).
protocols.py: a way of measuring picks its break-aways, or a person does; coherence.py: interleaved signals, repeated
blocks, sudden steps; segments.py: the samples to pick from, rest, climb and sliding; picker.py: a trained network
says where the break-away may be, picker.npz are its weights; decision.py: what follows from it, a force, a doubt or a
reason why there is none; peak.py: the height of a peak and its uncertainty; zero.py: what the rope at rest says of
the zero; noise.py: noise, spikes, stuck converters, mains hum; smoothing.py: the moving average; breakaway.py: the
result, and what a user decides.
"""
