"""The march in many digits, by the paper's formulas alone, without the package.

The head's angle is the root of the arc length. Each next handle is found by walking outward from
the one before in small steps of the angle until the straight distance first passes the spacing, and
then by shrinking that bracket. Velocities are central differences of positions in 50 digits.
Nothing here is clever, so that nothing can be wrong in the same way as in the package.
"""

import mpmath as mp
from exact_curves import UnplaceableError, arc_length, exact, walked_chain

DIGITS = 50
# Radians. Far below the half turn over which the distance first rises and falls.
STEP = 0.01
# Seconds. The central difference is off by its square, and 50 digits leave 30 after dividing by it.
TIME_STEP = mp.mpf("1e-18")


def spiral_point(theta, pitch):
    radius = pitch / (2 * mp.pi) * theta
    return radius * mp.cos(theta), radius * mp.sin(theta)


def head_angle(time, pitch, turns, speed):
    left = arc_length(2 * mp.pi * turns, pitch) - speed * time
    if left < 0:
        raise UnplaceableError(0)
    ends = (0, 1.01 * mp.sqrt(4 * mp.pi * left / pitch + mp.mpf("1e-40")))
    return mp.findroot(
        lambda p: arc_length(p, pitch) - left, ends, solver="anderson", tol=1e-80, verify=False
    )


def angles(time, *, spacings, pitch, turns, speed):
    head = head_angle(time, pitch, turns, speed)
    return walked_chain(lambda theta: spiral_point(theta, pitch), head, spacings, STEP)


def solve(time, *, benches, head_spacing, body_spacing, pitch, turns, speed, difference=True):
    """Positions and velocities of all handles, as pairs of mpf; without `difference`, positions."""
    with mp.workdps(DIGITS):
        spacings = [exact(head_spacing)] + [exact(body_spacing)] * (benches - 1)
        given = {
            "spacings": spacings,
            "pitch": exact(pitch),
            "turns": exact(turns),
            "speed": exact(speed),
        }
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
    """Gap of two benches along the widest of the four axes; right where an edge faces the other.

    `sizes` are width, overhang, head_spacing, body_spacing and pitch; the march starts on turn 16
    at 1 m/s.
    """
    spacings = [sizes["head_spacing"]] + [sizes["body_spacing"]] * pair[1]
    turned = angles(
        time, spacings=spacings, pitch=sizes["pitch"], turns=mp.mpf(16), speed=mp.mpf(1)
    )
    holes = [mp.mpc(*spiral_point(angle, sizes["pitch"])) for angle in turned]
    corners, axes = [], []
    for bench in pair:
        front, rear = holes[bench], holes[bench + 1]
        along = (front - rear) / abs(front - rear)
        ahead, aside = along * sizes["overhang"], 1j * along * sizes["width"] / 2
        corners.append(
            [
                front + ahead + aside,
                front + ahead - aside,
                rear - ahead + aside,
                rear - ahead - aside,
            ]
        )
        axes += [along, 1j * along, -along, -1j * along]
    shadows = [[[mp.re(z * mp.conj(axis)) for z in each] for each in corners] for axis in axes]
    return max(min(second) - max(first) for first, second in shadows)


def grazing(pair, time, sizes):
    """Time and pitch at which two benches just touch, by Newton's method from those given."""
    with mp.workdps(DIGITS):
        t = mp.mpf(time)
        p = mp.mpf(sizes["pitch"])
        step = mp.mpf("1e-12")

        def at(time, pitch):
            return gap(time, pair, sizes | {"pitch": pitch})

        for _ in range(2):
            before = at(t - step, p)
            now = at(t, p)
            after = at(t + step, p)
            t -= (after - before) / 2 * step / (after - 2 * now + before)
            least = at(t, p)
            p -= least * step / (at(t, p + step) - least)
        return t, p


def touching(pair, time, sizes):
    """Time at which two benches come to touch, by the secant method from one close to it."""
    with mp.workdps(DIGITS):
        return mp.findroot(
            lambda t: gap(t, pair, sizes), (mp.mpf(time), mp.mpf(time) + mp.mpf("1e-6")), tol=1e-60
        )
