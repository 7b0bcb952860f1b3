"""The march solved anew in many digits, from the formulas of the paper alone: it imports nothing of the package.

The head's angle is the root of the arc length. Each next handle is found by walking outward from the one before in
small steps of the angle until the straight distance first passes the spacing, and then by shrinking that bracket.
Velocities are central differences of positions in 50 digits. Nothing here is clever, so that nothing can be wrong in
the same way as in the package.
"""

import math

import mpmath as mp

DIGITS = 50
# Radians. Far below the half turn over which the distance first rises and falls.
SCAN_STEP = 0.004
# Seconds. The central difference is off by its square, and 50 digits leave 30 after dividing by it.
TIME_STEP = mp.mpf("1e-18")


class UnplaceableError(Exception):
    """The handle of this number has no place."""


def spiral_point(theta, pitch):
    radius = pitch / (2 * mp.pi) * theta
    return radius * mp.cos(theta), radius * mp.sin(theta)


def arc_length(theta, pitch):
    """From the centre, as the closed form of the integral of k sqrt(theta^2 + 1)."""
    return pitch / (4 * mp.pi) * (theta * mp.sqrt(theta**2 + 1) + mp.asinh(theta))


def head_angle(time, pitch, turns, speed):
    left = arc_length(2 * mp.pi * turns, pitch) - speed * time
    if left < 0:
        raise UnplaceableError(0)
    guess = mp.sqrt(4 * mp.pi * left / pitch + mp.mpf("1e-40"))
    return mp.findroot(
        lambda theta: arc_length(theta, pitch) - left, (0, 1.01 * guess), solver="anderson", tol=1e-80, verify=False
    )


def distance(theta, phi, pitch):
    x0, y0 = spiral_point(theta, pitch)
    x1, y1 = spiral_point(theta + phi, pitch)
    return mp.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2)


def first_bracket(theta, pitch, chord):
    """Walk outward in doubles: an interval of phi in which the distance first passes the chord; None if it turns back.

    Where it turns back the scan may have stepped over a top that reaches the chord, so the top is looked up.
    """
    k = pitch / (2 * math.pi)
    x0, y0 = k * theta * math.cos(theta), k * theta * math.sin(theta)

    def reach(phi):
        angle = theta + phi
        return math.hypot(k * angle * math.cos(angle) - x0, k * angle * math.sin(angle) - y0)

    phi, before = 0.0, 0.0
    while phi < 2 * math.pi:
        phi += SCAN_STEP
        now = reach(phi)
        if now >= chord:
            return phi - SCAN_STEP, phi
        if now < before:
            low, high = max(phi - 2 * SCAN_STEP, 0.0), phi
            for _ in range(80):
                left, right = low + (high - low) / 3, high - (high - low) / 3
                low, high = (left, high) if reach(left) < reach(right) else (low, right)
            return (phi - 2 * SCAN_STEP, low) if reach(low) >= chord else None
        before = now
    return None


def next_angle(theta, pitch, chord):
    """Angle of the handle behind the one at `theta`."""
    bracket = first_bracket(float(theta), float(pitch), float(chord))
    if bracket is None:
        raise UnplaceableError
    low, high = mp.mpf(bracket[0]), mp.mpf(bracket[1])

    def miss(phi):
        return distance(theta, phi, pitch) - chord

    return theta + mp.findroot(miss, (low, high), solver="anderson", tol=1e-84, verify=False)


def angles(time, *, spacings, pitch, turns, speed):
    theta = [head_angle(time, pitch, turns, speed)]
    for i, spacing in enumerate(spacings):
        try:
            theta.append(next_angle(theta[-1], pitch, spacing))
        except UnplaceableError:
            raise UnplaceableError(i + 1) from None
    return theta


def exact(number):
    """A parameter as the decimal number that its user wrote."""
    return mp.mpf(repr(float(number)))


def solve(time, *, benches, head_spacing, body_spacing, pitch, turns, speed, difference=True):
    """Positions and velocities of all handles, as lists of pairs of mpf; no velocities without `difference`."""
    with mp.workdps(DIGITS):
        spacings = [exact(head_spacing)] + [exact(body_spacing)] * (benches - 1)
        given = {"spacings": spacings, "pitch": exact(pitch), "turns": exact(turns), "speed": exact(speed)}
        t = exact(time)
        positions = [spiral_point(theta, given["pitch"]) for theta in angles(t, **given)]
        if not difference:
            return positions, None
        before = [spiral_point(theta, given["pitch"]) for theta in angles(t - TIME_STEP, **given)]
        after = [spiral_point(theta, given["pitch"]) for theta in angles(t + TIME_STEP, **given)]
        velocities = [
            ((x1 - x0) / (2 * TIME_STEP), (y1 - y0) / (2 * TIME_STEP))
            for (x0, y0), (x1, y1) in zip(before, after, strict=True)
        ]
        return positions, velocities


def gap(time, pair, sizes):
    """Gap of two benches along the widest of the four axes, in many digits: right where an edge faces the other.

    `sizes` are width, overhang, head_spacing, body_spacing and pitch; the march starts on turn 16 at 1 m/s.
    """
    spacings = [sizes["head_spacing"]] + [sizes["body_spacing"]] * pair[1]
    turned = angles(time, spacings=spacings, pitch=sizes["pitch"], turns=mp.mpf(16), speed=mp.mpf(1))
    holes = [mp.mpc(*spiral_point(angle, sizes["pitch"])) for angle in turned]
    corners, axes = [], []
    for bench in pair:
        front, rear = holes[bench], holes[bench + 1]
        along = (front - rear) / abs(front - rear)
        ahead, aside = along * sizes["overhang"], 1j * along * sizes["width"] / 2
        corners.append([front + ahead + aside, front + ahead - aside, rear - ahead + aside, rear - ahead - aside])
        axes += [along, 1j * along, -along, -1j * along]
    shadows = [[[mp.re(z * mp.conj(axis)) for z in each] for each in corners] for axis in axes]
    return max(min(second) - max(first) for first, second in shadows)


def grazing(pair, time, sizes):
    """Time and pitch at which the smallest gap of two benches is zero, by Newton's method from those that are given."""
    with mp.workdps(DIGITS):
        t, p, step = mp.mpf(time), mp.mpf(sizes["pitch"]), mp.mpf("1e-12")

        def at(time, pitch):
            return gap(time, pair, sizes | {"pitch": pitch})

        for _ in range(2):
            before, now, after = at(t - step, p), at(t, p), at(t + step, p)
            t -= (after - before) / 2 * step / (after - 2 * now + before)
            least = at(t, p)
            p -= least * step / (at(t, p + step) - least)
        return t, p


def touching(pair, time, sizes):
    """Time at which two benches come to touch, by the secant method from one close to it."""
    with mp.workdps(DIGITS):
        return mp.findroot(lambda t: gap(t, pair, sizes), (mp.mpf(time), mp.mpf(time) + mp.mpf("1e-6")), tol=1e-60)
