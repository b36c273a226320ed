"""Belts and ropes that carry a pull round a pulley, or from one to another: power, tensions, best speed, creep.

`drive` is the drive and its balance of tensions, `effects` what a scene may leave out. A single pulley is a drum, a
capstan or a band brake. Tensions are per belt and count what keeps the belt on its circle, m v2, which presses nothing.

The tensions that are given close the balance:

- limit: the tight side pulls with the most a belt may bear, T1 = T.
- tensioner: a weight or spring holds the slack side, T2 = T, at rest and at any speed.
- fixed: the centres stay where a pretension T was set, and the belt keeps its unstretched length, that of spans and arcs
  together: ∮ ds/(1 + T/EA), with the tension on each arc as it slips and adheres. Where no span length is given the
  spans are taken for long, T1 + T2 = 2T.
- lever: an effort T at the end of a brake lever pulls the band of a drum tight. About the fulcrum the effort's moment
  is that of both band ends, T l = T1 a1 + T2 a2; an arm is negative where its end helps the effort.

At full pull (T1 - m v2) = (T2 - m v2) e^M on the pulley with the smaller M = mu' wrap, mu' = mu/sin(half the groove
angle) in a wedge groove. At a lower pull the belt slips over part of the arc only, where it leaves the pulley, and
adheres over the rest (Grashof); there it stretches from T2 to T1, so that the driven rim runs slower by
(1 + T2/EA)/(1 + T1/EA): elastic creep, and the power that it loses.
"""
