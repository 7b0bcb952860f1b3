"""Equations of motion of a chain of rigid benches whose first hole is moved along a given path.

Bench i has mass m, moment of inertia I, spacing d, the unit vector u along it and n to its left,
and the angular rate w. Its velocities decay at the rate c, as by viscous drag. With F_i the force
on it in its front hole, and F_(i+1) the force on the next bench in the hole that both share,

    m (v' + c v) = F_i - F_(i+1)        I (w' + c w) = d/2 n . (F_i + F_(i+1)).

A hole at the distance x = d/2 or -d/2 from the centre has the velocity V = v + x w n, so

    V' + c V = (v' + c v) + x (w' + c w) n - x w^2 u.

Both benches of a joint have the same value there: one vector equation a joint, in the forces of
three joints. The matrix of these equations is symmetric and positive definite with three bands
beside the diagonal (D. Baraff, "Linear-time dynamics using Lagrange multipliers", SIGGRAPH 1996).
The drag appears only on the right-hand side, in V' + c V of the first hole.
"""

from __future__ import annotations

import numpy as np

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._extras import library

# Per metre: ground drag, as in `EngineSettings`.
DRAG = 11.5
# Per metre: largest drag, as in `EngineSettings`.
MAX_DRAG = 1e4
# Rows of a symmetric matrix in LAPACK's form for bands: the diagonal and three bands below it.
_BANDS = 4


class PulledChain:
    """Benches behind a hole that moves along a given path.

    Parameters
    ----------
    spacings, masses, moments : ndarray, shape (N,)
        Of the benches, from the pulled one on: m, kg, kg m^2.
    drag_rate : float
        Rate at which velocities decay, 1/s.
    """

    def __init__(self, spacings: Array, masses: Array, moments: Array, drag_rate: float) -> None:
        self.spacings = spacings
        self.drag_rate = drag_rate
        self._half = spacings / 2
        self._lightness = 1 / masses
        self._lever = self._half / moments
        self._turning = self._lever * self._half
        # Both masses of a joint.
        self._shared = self._lightness.copy()
        self._shared[1:] += self._lightness[:-1]
        # Columns of the banded matrix: one for x and one for y of each joint.
        self._matrix = np.zeros((spacings.size, 2, _BANDS))
        self._solve = library("scipy.linalg.lapack").dpbsv

    def forces(self, angles: Array, spins: Array, lead: complex) -> Complex:
        """Forces (N,) on the benches in their front holes, N, as complex numbers.

        `angles` and `spins` (N,) are those of the benches, rad and rad/s, and `lead` is V' + c V of
        the first hole, m/s^2.
        """
        return self._forces(np.cos(angles), np.sin(angles), spins, lead)

    def _forces(self, cosines: Array, sines: Array, spins: Array, lead: complex) -> Complex:
        xx = self._turning * sines * sines
        xy = -self._turning * sines * cosines
        yy = self._turning - xx

        matrix = self._matrix
        x_column = matrix[:, 0]
        y_column = matrix[:, 1]
        x_column[:, 0] = self._shared + xx
        x_column[1:, 0] += xx[:-1]
        x_column[:, 1] = xy
        x_column[1:, 1] += xy[:-1]
        x_column[:, 2] = xx - self._lightness
        x_column[:, 3] = xy
        y_column[:, 0] = self._shared + yy
        y_column[1:, 0] += yy[:-1]
        y_column[:, 1] = xy
        y_column[:, 2] = yy - self._lightness

        inward = np.empty(spins.size, dtype=complex)
        centripetal = self._half * spins * spins
        inward.real = centripetal * cosines
        inward.imag = centripetal * sines
        right = inward.copy()
        right[1:] += inward[:-1]
        right[0] += lead
        bands = matrix.reshape(-1, _BANDS).T
        _, found, _ = self._solve(bands, right.view(float), lower=1, overwrite_b=1)
        return np.asarray(found.view(complex))

    def rates(self, state: Array, lead: complex) -> Array:
        """Rates of change (2 N,) of angles and angular rates, which are one array (2 N,)."""
        angles, spins = state.reshape(2, -1)
        cosines = np.cos(angles)
        sines = np.sin(angles)
        around = self._forces(cosines, sines, spins, lead)
        around[:-1] += around[1:]
        across = cosines * around.imag - sines * around.real
        return np.concatenate([spins, self._lever * across - self.drag_rate * spins])
