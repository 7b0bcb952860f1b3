// Numbers and times as text.

const LENGTH_DIGITS = 3; // significant digits of a length
const DECIMALS_MM = 3; // most decimals of a length in mm
const DECIMALS_M = 2; // decimals of a length in m
const SMALL_ERROR = 1e-4; // m
const NEAR_MISS_TIME = 0.05; // s: a time this close to a near miss counts as the near miss
const MAX_EVENTS = 3; // most events in a description

// Known decimals of a number with an error: the last one is worth no less than the error.
/** @type {(error: number) => number} */
const decimals = (error) => Math.max(0, Math.floor(-Math.log10(error)));

// A length in m with an error in m.
/** @type {(metres: number, error: number) => string} */
function formatLength(metres, error) {
  if (metres >= 1) return `${metres.toFixed(Math.min(DECIMALS_M, decimals(error)))} m`;
  const length = 1000 * metres;
  const significant = Math.min(
    DECIMALS_MM,
    Math.max(0, LENGTH_DIGITS - 1 - Math.floor(Math.log10(length))),
  );
  return `${length.toFixed(Math.min(significant, decimals(1000 * error)))} mm`;
}

// Units of length and their sizes in m, the largest first.
/** @type {[string, number][]} */
const LENGTHS = [
  ["km", 1e3],
  ["m", 1],
  ["mm", 1e-3],
  ["μm", 1e-6],
  ["nm", 1e-9],
];

// A length of any size with few digits, in a unit that fits.
/** @type {(length: number, units: string) => string} */
function roundLength(length, units) {
  const known = units === "m" ? LENGTHS : [];
  const [unit, size] = known.find((each) => length >= each[1]) ?? [units, 1];
  return `${Number((length / size).toPrecision(LENGTH_DIGITS))} ${unit}`;
}

// A position error in m with an error in m: in micrometres
// if it is small and known to a micrometre.
/** @type {(metres: number, error: number) => string} */
function formatError(metres, error) {
  if (metres >= SMALL_ERROR || error >= 1e-6) return formatLength(metres, error);
  return `${(1e6 * metres).toFixed(decimals(1e6 * error))} μm`;
}

// Numbers of one bench: velocity and speed in m/s, angle in degrees, gap and its error in m.
/**
 * @type {(
 *   benches: Benches<Recording, Poses & Rates>,
 *   bench: number,
 *   time: number,
 * ) => BenchNumbers}
 */
function benchNumbers(benches, bench, time) {
  const { model, poses } = benches;
  const velocities = model.velocitiesOf(poses);
  const degrees = (360 * poses.angle[bench]) / TURN;
  const other = benches.nearest(bench);
  return {
    bench,
    part:
      bench === 0
        ? localized("head")
        : bench === model.benches - 1
          ? localized("tail")
          : localized("body"),
    velocity: velocities && velocities[bench],
    speed: velocities && Math.hypot(...velocities[bench]),
    angle: degrees - 360 * Math.ceil((degrees - 180) / 360),
    gap: other && other.gap,
    nearest: other && other.bench,
    error: other && model.errorAt(time, bench) + model.errorAt(time, other.bench),
  };
}

/** @type {(numbers: BenchNumbers) => Texts} */
function formatNumbers({ part, speed, angle, gap, nearest, error }) {
  return {
    part,
    speed: speed === null ? "–" : `${speed.toFixed(3)} m/s`,
    angle: `${angle.toFixed(1).replace("-", "−")}°`,
    gap:
      gap === null
        ? "–"
        : gap <= 0
          ? localized("touches {i}", { i: nearest })
          : localized("{gap} to {i}", { gap: formatLength(gap, error ?? 0), i: nearest }),
  };
}

// A speed in simulated over real time: whole numbers, and below 1 the next larger of 1/2, 1/4,
// 1/8, ...
/** @type {(rate: number) => string} */
function formatRate(rate) {
  return rate >= 1 ? `${Math.round(rate)}×` : `1/${2 ** Math.floor(-Math.log2(rate) + 1e-9)}×`;
}

/** @type {(time: number, events: RunEvent[]) => string} */
function describeTime(time, events) {
  const now = events.filter((event) =>
    event.kind === "contact"
      ? event.time <= time && time <= event.end
      : Math.abs(event.time - time) < NEAR_MISS_TIME,
  );
  return [`t = ${time.toFixed(2)} s`, ...now.slice(0, MAX_EVENTS).map((event) => event.text)].join(
    ". ",
  );
}
