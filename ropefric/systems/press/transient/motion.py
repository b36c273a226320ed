"""The equations of motion in one mode, as rows: every quantity is a row times w = (q, dq/dt, u).

The coordinates q are the rims' ways s = Rθ of the driven rollers relative to the first driver, the tensioners' ways ξ
from their place at rest and, where slip is allowed, how far the belt on each roller has run ahead of it, δ. With
e = −Dᵀ (s + δ) − Pᵀ ξ and T = T_0 + k (e + η de/dt) the balances are, where belt and roller stick together,

    (J/R² + ρARα) dv/dt = D T − M/R,        m ξ'' + C1 ξ' + k1 ξ = P (T − T_0 − ρAv²),

eqs. (10)-(22) less the state at rest. Where a belt slips forward, friction and the belt's mass on the arc m share
what the tensions leave, F = T_out − T_in − m b'', and the element dT/dφ = ρAR²θ'' − F integrated over the wrap gives

    F = (1 − κ) T'_out + (κ e^M − 1) T'_in,      κ = m / (m + m ∫(e^(M(α) − M(s)) − 1) ds/α),

for constant μ κ = M/(e^M − 1); where it slips backward, with the sides exchanged and the other sign.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.inputs import (
    ACCELERATION,
    FIRST_DRIVER,
    LOAD,
    ONE,
    SPEED,
    SPEED_SQUARED,
)
from ropefric.systems.press.transient.mode import STICK, Mode
from ropefric.systems.press.transient.model import ElasticPress


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionLimit:
    """What gross slip on each roller is governed by."""

    growth: FloatArray
    share: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """One mode of a press as rows over w = (q, dq/dt, u)."""

    model: ElasticPress
    mode: Mode
    limit: FrictionLimit | None = None

    @cached_property
    def n_rollers(self) -> int:
        """Return the number of rollers."""
        return len(self.model.load_N)

    @cached_property
    def n_coordinates(self) -> int:
        """Return the number of coordinates q."""
        slips = self.n_rollers if self.limit is not None else 0
        return len(self.model.driven) + len(self.model.spring_N_m) + slips

    @cached_property
    def n_inputs(self) -> int:
        """Return the number of inputs u."""
        return FIRST_DRIVER + 3 * len(self.model.drivers)

    def input(self, place: int) -> FloatArray:
        """Return the row of one input, shape (n_w,)."""
        row = np.zeros(2 * self.n_coordinates + self.n_inputs)
        row[2 * self.n_coordinates + place] = 1.0
        return row

    @cached_property
    def _roller_place(self) -> FloatArray:
        """Return which coordinate is whose way, shape (n_rollers, n_q); a driver has none."""
        place = np.zeros((self.n_rollers, self.n_coordinates))
        place[self.model.driven, np.arange(len(self.model.driven))] = 1.0
        return place

    @cached_property
    def _slip_place(self) -> FloatArray:
        place = np.zeros((self.n_rollers, self.n_coordinates))
        if self.limit is not None:
            place[:, -self.n_rollers :] = np.eye(self.n_rollers)
        return place

    def _rows(self, place: FloatArray, order: int, driver_part: int | None = None) -> FloatArray:
        """Return coordinates (order 0) or their speeds (1) as rows, with what is prescribed for the drivers."""
        n_q = self.n_coordinates
        rows = np.zeros((len(place), 2 * n_q + self.n_inputs))
        rows[:, order * n_q : (order + 1) * n_q] = place
        if driver_part is not None:
            for i, driver in enumerate(self.model.drivers):
                rows[driver, 2 * n_q + FIRST_DRIVER + 3 * i + driver_part] = 1.0
        return rows

    @cached_property
    def travel_m(self) -> FloatArray:
        """Return ξ, shape (n_tensioners, n_w)."""
        return self._rows(self._tensioner_place, 0)

    @cached_property
    def travel_speed_m_s(self) -> FloatArray:
        """Return dξ/dt, shape (n_tensioners, n_w)."""
        return self._rows(self._tensioner_place, 1)

    @cached_property
    def _tensioner_place(self) -> FloatArray:
        n_driven, n_tensioners = len(self.model.driven), len(self.model.spring_N_m)
        place = np.zeros((n_tensioners, self.n_coordinates))
        place[:, n_driven : n_driven + n_tensioners] = np.eye(n_tensioners)
        return place

    @cached_property
    def relative_way_m(self) -> FloatArray:
        """Return Rθ of every roller less that of the first driver, shape (n_rollers, n_w)."""
        return self._rows(self._roller_place, 0, 0)

    @cached_property
    def rim_speed_m_s(self) -> FloatArray:
        """Return Rθ' of every roller, shape (n_rollers, n_w)."""
        return self._rows(self._roller_place, 1, 1) + self.input(SPEED)

    @cached_property
    def slip_m(self) -> FloatArray:
        """Return δ of every roller, shape (n_rollers, n_w)."""
        return self._rows(self._slip_place, 0)

    @cached_property
    def slip_speed_m_s(self) -> FloatArray:
        """Return dδ/dt of every roller, shape (n_rollers, n_w)."""
        return self._rows(self._slip_place, 1)

    @cached_property
    def stretch_speed_m_s(self) -> FloatArray:
        """Return de/dt of every span, shape (n_spans, n_w)."""
        speeds = self.rim_speed_m_s - self.input(SPEED) + self.slip_speed_m_s
        return -self.model.incidence.T @ speeds - self.model.pull.T @ self.travel_speed_m_s

    @cached_property
    def spring_N(self) -> FloatArray:
        """Return T_0 + k e of every span, as if it could push, shape (n_spans, n_w)."""
        model = self.model
        stretch = -model.incidence.T @ (self.relative_way_m + self.slip_m) - model.pull.T @ self.travel_m
        return model.stiffness_N_m[:, None] * stretch + np.outer(model.preload_N, self.input(ONE))

    @cached_property
    def unclipped_N(self) -> FloatArray:
        """Return T_0 + k (e + η de/dt) of every span, as if it could push, shape (n_spans, n_w)."""
        return self.spring_N + self.model.damping_N_s_m[:, None] * self.stretch_speed_m_s

    @cached_property
    def tension_N(self) -> FloatArray:
        """Return T of every span, shape (n_spans, n_w)."""
        return np.array(self.mode.taut, dtype=np.float64)[:, None] * self.unclipped_N

    @cached_property
    def pressing_N(self) -> FloatArray:
        """Return T − ρAv² of every span, as if it could push, shape (n_spans, n_w)."""
        return self.unclipped_N - np.outer(self.model.density_kg_m, self.input(SPEED_SQUARED))

    @cached_property
    def net_pull_N(self) -> FloatArray:
        """Return D T, the belts' pull on every roller and on what lies on it, shape (n_rollers, n_w)."""
        return self.model.incidence @ self.tension_N

    @cached_property
    def limit_N(self) -> tuple[FloatArray, FloatArray]:
        """Return the friction of gross slip, forward and backward, each of shape (n_rollers, n_w)."""
        if self.limit is None:
            nothing = np.zeros_like(self.net_pull_N)
            return nothing, nothing
        pressing = np.array(self.mode.pressed, dtype=np.float64)[:, None] * self.pressing_N
        upstream = np.maximum(-self.model.incidence, 0.0) @ pressing
        downstream = np.maximum(self.model.incidence, 0.0) @ pressing
        tight, slack = (
            (1.0 - self.limit.share)[:, None],
            (self.limit.share * self.limit.growth - 1.0)[:, None],
        )
        return tight * downstream + slack * upstream, tight * upstream + slack * downstream

    @cached_property
    def load_N(self) -> FloatArray:
        """Return M/R of every roller against forward motion, shape (n_rollers, n_w); nil of one that is held."""
        return np.outer(self.model.load_N * np.array(self.mode.turning), self.input(LOAD))

    @cached_property
    def _driver_acceleration(self) -> FloatArray:
        return self._rows(np.zeros_like(self._roller_place), 0, 2) + self.input(ACCELERATION)

    @cached_property
    def rim_acceleration_m_s2(self) -> FloatArray:
        """Return Rθ'' of every roller, shape (n_rollers, n_w)."""
        rows = self._driver_acceleration.copy()
        model, mode = self.model, self.mode
        for i in model.driven:
            if mode.turning[i] == 0:
                rows[i] = 0.0
            elif mode.contact[i] == STICK:
                mass = model.roller_mass_kg[i] + model.arc_mass_kg[i]
                rows[i] = (self.net_pull_N[i] - self.load_N[i]) / mass
            else:
                rows[i] = (self.friction_N[i] - self.load_N[i]) / model.roller_mass_kg[i]
        return rows

    @cached_property
    def friction_N(self) -> FloatArray:
        """Return the friction that the belt drives each rim with, shape (n_rollers, n_w); negative on a driver."""
        model, rows = self.model, np.zeros_like(self.net_pull_N)
        for i, contact in enumerate(self.mode.contact):
            if contact != STICK:
                rows[i] = contact * self.limit_N[contact < 0][i]
            elif i in model.drivers:
                rows[i] = self.net_pull_N[i] - model.arc_mass_kg[i] * self._driver_acceleration[i]
            elif self.mode.turning[i] == 0:
                rows[i] = self.net_pull_N[i]
            else:
                share = model.arc_mass_kg[i] / (model.roller_mass_kg[i] + model.arc_mass_kg[i])
                rows[i] = self.net_pull_N[i] - share * (self.net_pull_N[i] - self.load_N[i])
        return rows

    @cached_property
    def belt_acceleration_m_s2(self) -> FloatArray:
        """Return the acceleration of the belt on every roller, shape (n_rollers, n_w)."""
        rows = self.rim_acceleration_m_s2.copy()
        for i, contact in enumerate(self.mode.contact):
            if contact != STICK:
                rows[i] = (self.net_pull_N[i] - self.friction_N[i]) / self.model.arc_mass_kg[i]
        return rows

    @cached_property
    def travel_acceleration_m_s2(self) -> FloatArray:
        """Return ξ'' of every tensioner, shape (n_tensioners, n_w)."""
        model = self.model
        rest = np.outer(model.preload_N, self.input(ONE)) + np.outer(
            model.density_kg_m, self.input(SPEED_SQUARED)
        )
        force = model.pull @ (self.tension_N - rest)
        force -= model.spring_N_m[:, None] * self.travel_m
        force -= model.tensioner_damping_N_s_m[:, None] * self.travel_speed_m_s
        return force / model.tensioner_mass_kg[:, None]

    @cached_property
    def derivative(self) -> FloatArray:
        """Return d(q, dq/dt)/dt, shape (2 n_q, n_w)."""
        driven = self.model.driven
        rows = [
            self._rows(np.eye(self.n_coordinates), 1),
            self.rim_acceleration_m_s2[driven] - self.input(ACCELERATION),
            self.travel_acceleration_m_s2,
        ]
        if self.limit is not None:
            rows.append(self.belt_acceleration_m_s2 - self.rim_acceleration_m_s2)
        return np.vstack(rows)
