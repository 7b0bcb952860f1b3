// Numbers and moments as people read or hear them.

// Digits of a length that are worth reading, and those after the point at most, in mm and in m.
const LENGTH_DIGITS = 3, DECIMALS_MM = 3, DECIMALS_M = 2;
// Seconds around a near miss that count as its moment, and events that are told at once.
const MOMENT = 0.05, EVENTS_TOLD = 3;

// Digits after the point that are known where a number may be off by `blur`: the last one is worth no less than that.
const decimals = (blur) => Math.max(0, Math.floor(-Math.log10(blur)));

// A length in m that is known to within `blur` m.
function inLength(metres, blur) {
  if (metres >= 1) return `${metres.toFixed(Math.min(DECIMALS_M, decimals(blur)))} m`;
  const length = 1000 * metres;
  const worth = Math.min(DECIMALS_MM, Math.max(0, LENGTH_DIGITS - 1 - Math.floor(Math.log10(length))));
  return `${length.toFixed(Math.min(worth, decimals(1000 * blur)))} mm`;
}

// What there is to say about one bench.
function numbersOf(benches, bench, time) {
  const { motion, poses } = benches;
  const velocities = motion.velocitiesOf(poses);
  const degrees = (360 * poses.angle[bench]) / TURN;
  const other = benches.nearest(bench);
  return {
    bench,
    part: bench === 0 ? "head" : bench === motion.benches - 1 ? "tail" : "body",
    velocity: velocities && velocities[bench],
    speed: velocities && Math.hypot(...velocities[bench]),
    angle: degrees - 360 * Math.ceil((degrees - 180) / 360),
    gap: other && other.gap,
    nearest: other && other.bench,
    blur: other && motion.blurAt(time, bench) + motion.blurAt(time, other.bench),
  };
}

function numbersInWords({ part, speed, angle, gap, nearest, blur }) {
  return {
    part,
    speed: speed === null ? "–" : `${speed.toFixed(3)} m/s`,
    angle: `${angle.toFixed(1).replace("-", "−")}°`,
    gap: gap === null ? "–" : gap === 0 ? `touches ${nearest}` : `${inLength(gap, blur)} to ${nearest}`,
  };
}

function momentInWords(time, events) {
  const now = events.filter((event) => event.kind === "contact"
    ? event.time <= time && time <= event.end
    : Math.abs(event.time - time) < MOMENT);
  return [`t = ${time.toFixed(2)} s`, ...now.slice(0, EVENTS_TOLD).map(({ words }) => words)].join(". ");
}
