"""A lift's traction sheave after EN 81-50, 5.11: its ropes must hold while loading and braking, and slip when stalled.

`sheave` is the lift and the balance of its ropes, T1/T2 against e^(f α), in four load cases, `effects` what a scene
may leave out. This is an engineer's check of one clause and no certificate.

Roping is 1:1, g = 9.81 m/s2. The load cases, with the masses of car P, rated load Q, counterweight M, ropes m per metre
over the travel H and the length above it, and a deflector pulley m_D reduced to its rim on either side:

- loading: 125 % of Q in the car at the lowest stop, at rest.
- braking-up: the empty car stopped on its way up at the highest stop, T1 = (M + m(H + h_M))(g + a) + m_D a over
  T2 = (P + m h_P)(g - a) - m_D a.
- braking-down: the car with Q stopped on its way down at the lowest stop, the same the other way round.
- stalled: the counterweight rests on its buffer, the empty car hangs at the highest stop, and the sheave must slip.

A published example (Q 630, P 700, M 1015 kg, 4 ropes of 0.336 kg/m, H 18 m) prints 14856/9991 N for loading and
10760/6542 N for braking-up. The car's side of both gives a = 0.5 m/s2 and 2 m of rope above the car; 0.8 m/s2 gives
neither. It does not state the rope on the counterweight's side: 33.9 N at rest are 2.57 m above it, and the rest
of 10760 N while braking is the inertia of a deflector pulley of 21 kg there. With these all four agree.
"""
