// Outlines of exact benches.

const GHOST_WIDTH = 1.5; // pixels

// Outlines of the benches `chosen` of `ghosts`, on top of the others.
function drawGhosts(painter, ghosts, chosen) {
  const path = new Path2D();
  for (const i of chosen) painter.outline(path, ghosts, i);
  strokeTwice(painter.context, path, painter.colours.background, painter.colours.motion, GHOST_WIDTH);
}
