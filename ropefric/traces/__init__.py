"""One recording -> the break-away force F_A.

In: a recording file and an `ImportProfile`. Out: `Breakaway`. On the way: RawRecording -> ForceTrace -> Breakaway.

readers/: file -> `RawRecording`, columns as they are in it. assemble.py: -> `ForceTrace` (trace.py) in SI, with
channels computed by formula, by clock.py (time stamps mended or refused) and calibration.py (counts -> newtons, tare,
what the chain leaves uncertain). protocols.py: a way of measuring picks its break-aways, or a person does; picker.py:
the trained network (picker.npz), which says where the break-away may be and what the rope does in every bin of time;
decision.py: two looks of it, and what is made of their probabilities; zero.py: what the rope at rest says of the zero;
segments.py: samples without gaps and spikes, block means, phases; peak.py: height and uncertainty of the peak;
noise.py: noise, spikes, stuck converters, mains hum; smoothing.py: the moving average; breakaway.py: the result, and
what a user decides.
"""
