"""What is uncertain, and how uncertain it makes an answer: one engine for forces, fits and scenes.

`quantity`: single quantities, and quantities known together with their covariance, with draws from both, in.
`budget`: a measurement equation, its budget by the law of propagation of uncertainty (JCGM 100), the check by draws
(JCGM 101) and what would make it smaller, out.
"""
