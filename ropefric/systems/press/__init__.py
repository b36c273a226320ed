"""A belt filter press, or any machine of rollers and closed belts: its tensions, its slip, its start-up.

`machine` is the graph of rollers, belts and tensioners with the matrices of its balances, and the torques of pressing
and dewatering. `statics` solves the balances once, with a closure where belts share a pull that no balance divides, and
from that gives tensions over any grid of preloads, speeds and loads, and how fast each roller runs; `slip` how near each
is to slipping, over any axis, and what has to change until one slips. `answer` is a press as assembled, `effects` what a
scene may leave out and what that may cost. `transient` is the start-up.
"""
