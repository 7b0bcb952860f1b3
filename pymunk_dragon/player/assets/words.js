// Numbers and moments as people read or hear them.

// Metres below which tenths of a millimetre are worth reading, and how well they have to be known for that.
const SMALL_LENGTH = 0.01, KNOWN_TO = 0.0001;
// Seconds around a near miss that count as its moment, and events that are told at once.
const MOMENT = 0.05, EVENTS_TOLD = 3;

// A length in m that is known to within `blur` m.
function inLength(metres, blur) {
  if (metres >= 1) return `${metres.toFixed(2)} m`;
  return `${(1000 * metres).toFixed(metres < SMALL_LENGTH && blur < KNOWN_TO ? 1 : 0)} mm`;
}

// What there is to say about one bench.
function numbersOf(benches, bench, time) {
  const { motion, poses } = benches;
  const velocities = motion.velocitiesAt(time);
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
    blur: other && Math.max(motion.blurAt(time, bench), motion.blurAt(time, other.bench)),
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
