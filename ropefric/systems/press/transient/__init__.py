"""The start-up of a belt press: elastic belts, prescribed drivers, slip and slack.

`drives` is what moves the press from outside: ways to run up and the inputs they make. `motion` turns the machine into
arrays and writes one mode of it (what sticks, slips, is slack) as rows, with powers, energies and places of rest.
`exact` solves it, with slip and slack or without: matrix exponentials between events; `capture` puts the events on a
grid, which is ten times as fast and as accurate as most questions are. `integrators` are other ways to solve the
linear problem, which the study of accuracy compares with it. `start_up` is the whole: machine and drive in, histories
and what they amount to out.
"""
