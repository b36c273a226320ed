"""One recording -> the break-away force F_A: reading, calibrating, smoothing, picking."""
