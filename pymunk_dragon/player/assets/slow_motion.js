// Slow motion near events: the speed falls in proportion to the time to the nearest event, down to a lowest one.

const SLOWEST = 1 / 8; // simulated over real time
const APPROACH = 2; // 1/s: speed over the time to the event
// s: a contact that begins so soon after another one has no slow motion of its own, as in a pile-up.
const APART = 2;

// Times of the events that playing slows down at: near misses, and contacts after a time without one.
function slowTimes(events) {
  const begins = events.filter(({ kind }) => kind === "contact").map(({ time }) => time);
  return [
    ...events.filter(({ kind }) => kind === "near-miss").map(({ time }) => time),
    ...begins.filter((time, k) => k === 0 || time - begins[k - 1] > APART),
  ];
}

// The speed at a time, no higher than the chosen `rate`.
function slowedRate(rate, time, times) {
  const distance = times.reduce((least, each) => Math.min(least, Math.abs(each - time)), Infinity);
  return Math.min(rate, Math.max(SLOWEST, APPROACH * distance));
}
