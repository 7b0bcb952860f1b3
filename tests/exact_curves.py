"""Curves in many digits, from their definitions alone: it imports nothing of the package.

Each is a function of arc length that gives x, y, the direction's x and y, and the signed curvature,
as mpf.
"""

import mpmath as mp
import numpy as np
from scipy.interpolate import CubicSpline

DIGITS = 34
# m. Steps of the walk back, in which no distance here passes a bench's length and falls below it
# again.
STEP = 0.05


def line(start, stop):
    start, stop = mp.mpc(*start), mp.mpc(*stop)
    direction = (stop - start) / abs(stop - start)
    return lambda s: _numbers(start + s * direction, direction, mp.mpf(0))


def arc(centre, radius, begin_angle, sweep):
    centre = mp.mpc(*centre)
    radius = mp.mpf(radius)
    side = mp.sign(sweep)

    def at(s):
        out = mp.expj(begin_angle + side * s / radius)
        return _numbers(centre + radius * out, side * mp.j * out, side / radius)

    return at


def arc_length(theta, pitch):
    """Arc length of r = k theta from its centre: the integral of k sqrt(theta^2 + 1)."""
    return pitch / (4 * mp.pi) * (theta * mp.sqrt(theta**2 + 1) + mp.asinh(theta))


def spiral(pitch, rotation=0, outward=False):
    """The path r = k theta by its arc length from the centre, negative on the way in."""
    pitch = mp.mpf(pitch)
    k = pitch / (2 * mp.pi)

    def at(s):
        length = s if outward else -s
        theta = mp.findroot(
            lambda theta: arc_length(theta, pitch) - length,
            mp.sqrt(2 * length / k) + mp.mpf("1e-9"),
        )
        return _of_parameter(lambda p: k * p * mp.expj(p + rotation), theta, 1 if outward else -1)

    return at


def _numbers(point, direction, curvature):
    return point.real, point.imag, direction.real, direction.imag, curvature


def _of_parameter(path, p, side=1):
    """Five numbers at parameter p of a complex path, travelled forward (side 1) or back (-1)."""
    first, second = mp.diff(path, p), mp.diff(path, p, 2)
    return _numbers(
        path(p), side * first / abs(first), side * (mp.conj(first) * second).imag / abs(first) ** 3
    )


def s_turn(pitch, radius, ratio):
    """Radii, centres, sweeps and length of question 4's turn, from what it has to be tangent to."""
    k = mp.mpf(pitch) / (2 * mp.pi)
    theta = radius / k
    entry = radius * mp.expj(theta)
    inward = -mp.diff(lambda p: k * p * mp.expj(p), theta)
    right = -mp.j * inward / abs(inward)

    def centres(second):
        return entry + ratio * second * right, -entry - second * right

    # The arcs meet: their centres are as far apart as both radii together.
    second = mp.findroot(lambda r: abs(mp.fsub(*centres(r))) - (1 + ratio) * r, radius / 3)
    (one, two), radii = centres(second), (ratio * second, second)
    middle = one + (two - one) * ratio / (1 + ratio)
    # How far round each centre, clockwise about the first and counter-clockwise about the second.
    sweeps = [
        -(mp.arg((entry - one) / (middle - one)) % (2 * mp.pi)),
        mp.arg((-entry - two) / (middle - two)) % (2 * mp.pi),
    ]
    length = sum(r * abs(sweep) for r, sweep in zip(radii, sweeps, strict=True))
    return radii, (one, two), sweeps, (entry, middle, -entry), length


def u_turn(pitch=1.7, radius=4.5, ratio=2):
    """The path of question 4, by what it is made of."""
    pitch = exact(pitch)
    radius = mp.mpf(radius)
    ratio = mp.mpf(ratio)
    radii, centres, sweeps, points, _ = s_turn(pitch, radius, ratio)
    entry = arc_length(2 * mp.pi * radius / pitch, pitch)
    first, second = (
        arc((centre.real, centre.imag), r, mp.arg(point - centre), sweep)
        for centre, r, point, sweep in zip(centres, radii, points[:2], sweeps, strict=True)
    )
    inward, outward = spiral(pitch), spiral(pitch, mp.pi, outward=True)
    middle = radii[0] * abs(sweeps[0])
    end = middle + radii[1] * abs(sweeps[1])

    def at(s):
        if s < 0:
            return inward(s - entry)
        if s < middle:
            return first(s)
        return second(s - middle) if s < end else outward(s - end + entry)

    return at


def exact(number):
    """A parameter as the decimal number that its user wrote; an mpf as it is."""
    return number if isinstance(number, mp.mpf) else mp.mpf(repr(float(number)))


class UnplaceableError(Exception):
    """The handle of this number has no place."""


def walked_chain(truth, begin, spacings, step=-STEP):
    """Parameters of the handles from that of the head on, walking in steps of the parameter."""
    places = [mp.mpf(begin)]
    for i, spacing in enumerate(spacings):
        place = _walked(truth, places[-1], exact(spacing), step)
        if place is None:
            raise UnplaceableError(i + 1)
        places.append(place)
    return places


def _walked(truth, begin, chord, step):
    """Parameter at which the distance from `begin` first passes `chord`; None if it falls first."""
    here = mp.mpc(*truth(begin)[:2])

    def away(place):
        return abs(mp.mpc(*truth(place)[:2]) - here)

    with mp.workdps(15):
        place = begin
        reached = mp.mpf(0)
        further = mp.mpf(0)
        while reached <= further < chord:
            place, reached = place + step, further
            further = away(place)
        first, last = place - step, place
        if further < chord:
            # A step may have passed a top that reaches the chord: it is looked up.
            first = place - 2 * step
            low, high = first, place
            for _ in range(80):
                left, right = low + (high - low) / 3, high - (high - low) / 3
                low, high = (left, high) if away(left) < away(right) else (low, right)
            last = low
            if away(last) < chord:
                return None
    return mp.findroot(
        lambda place: away(place) - chord, (first, last), solver="anderson", tol=1e-84, verify=False
    )


def spline(points):
    """The not-a-knot cubic spline by chord length through points, and its length."""
    h = np.hypot(*np.diff(points, axis=0).T).tolist()
    coefficients = CubicSpline(np.cumsum([0, *h]), np.asarray(points) @ [1, 1j]).c[::-1].T
    cubics, n = [[mp.mpc(each) for each in cubic] for cubic in coefficients.tolist()], len(points)

    def path(i, p):
        zero, one, two, three = cubics[i]
        return zero + p * (one + p * (two + p * three))

    def speed(i, p):
        _, one, two, three = cubics[i]
        return abs(one + p * (2 * two + 3 * p * three))

    def length(i, p):
        return mp.quad(lambda q: speed(i, q), mp.linspace(0, p, 7))

    with mp.workdps(DIGITS):
        lengths = [length(i, h[i]) for i in range(n - 1)]

    def at(s):
        i = 0
        while i < n - 2 and s > lengths[i]:
            s, i = s - lengths[i], i + 1
        p = h[i] * s / lengths[i]
        for _ in range(7):
            p -= (length(i, p) - s) / speed(i, p)
        return _of_parameter(lambda q: path(i, q), p)

    return at, sum(lengths)


def worst_errors(curve, truth, places):
    """Largest errors of points (m), tangents and curvatures (1/m) of a curve, against the truth."""
    with mp.workdps(DIGITS):
        off = [0.0, 0.0, 0.0]
        for place in places:
            exact = truth(mp.mpf(float(place)))
            found = [*curve.point(place), *curve.tangent(place), curve.curvature(place)]
            misses = [abs(float(mp.mpf(float(a)) - b)) for a, b in zip(found, exact, strict=True)]
            off = [
                max(a, b)
                for a, b in zip(off, (max(misses[:2]), max(misses[2:4]), misses[4]), strict=True)
            ]
        return off
