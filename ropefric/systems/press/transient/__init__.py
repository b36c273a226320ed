"""The start-up of a belt press: elastic belts, prescribed drivers, slip and slack.

`drives` is what moves the press from outside: ways to run up and the inputs they make. `motion` turns the machine into
arrays and writes one mode of it (what sticks, slips, is slack) as rows, with powers, energies and places of rest.
`exact` solves it: matrix exponentials between the changes of contacts and spans, which are met inside the steps of a
grid. `start_up` is the whole: machine and drive in, histories and what they amount to out.
"""
