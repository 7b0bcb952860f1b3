// Outlines of exact benches.

const GHOST_WIDTH = 1.5; // pixels: width of the lines
const GHOST_SHARE = 0.16; // largest width of the lines over that of a bench
const THINNEST_GHOST = 0.75; // pixels
const RIMMED_BENCH = 10; // pixels: width of a bench from which on the lines have a rim

// Outlines of the benches `chosen` of `ghosts`, on top of the others.
function drawGhosts(painter, ghosts, chosen) {
  const { context, colours, view } = painter;
  const path = new Path2D();
  for (const i of chosen) painter.outline(path, ghosts, i);
  const bench = ghosts.motion.narrowest * view.scale;
  const width = Math.min(GHOST_WIDTH, Math.max(THINNEST_GHOST, GHOST_SHARE * bench));
  if (bench >= RIMMED_BENCH) strokeTwice(context, path, colours.background, colours.motion, width);
  else strokeOnce(context, path, colours.motion, width);
}
