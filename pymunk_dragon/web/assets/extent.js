// The area of what is drawn now, which "whole field" shows.

// Area of all calls {centre, size}; null where they have no size. A dot's radius is in pixels.
/** @type {(calls: Call[]) => Field | null} */
function extentOf(calls) {
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  for (const { points, radius, outline } of calls) {
    const reach = outline ? radius : 0;
    for (const point of points) {
      if (!Number.isFinite(point[0] + point[1] + reach)) continue;
      for (const axis of [0, 1]) {
        low[axis] = Math.min(low[axis], point[axis] - reach);
        high[axis] = Math.max(high[axis], point[axis] + reach);
      }
    }
  }
  const size = Math.max(high[0] - low[0], high[1] - low[1]);
  if (!(size > 0)) return null;
  return {
    centre: [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2],
    size: [high[0] - low[0], high[1] - low[1]],
  };
}
