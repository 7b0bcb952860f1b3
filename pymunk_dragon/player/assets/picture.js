// Draws a moment of a run, with its overlays.

class RunPainter extends Painter {
  // Draw `benches` at `time` with the overlays in `show` and the bench `pointed` highlighted. The exact benches are drawn
  // at their distances from these times `magnification`.
  draw({ time, benches, show, pointed, exact, magnification }) {
    this.clear();
    const visible = this.visible(benches);
    const touching = this.motion.touchingAt(time);
    const inContact = new Set(touching.flatMap(({ benches: two }) => two));
    if (show.grid && this.payload.grid) drawGrid(this, benches, visible);
    if (show.curve) this.drawCurve();
    this.drawBenches(benches, visible, inContact);
    if (pointed !== null) this.drawPointed(benches, pointed, inContact);
    const ghosts = show.exact && exact?.posesBeside(benches, time, magnification);
    if (ghosts) drawGhosts(this, new Benches(this.motion, ghosts), visible);
    if (show.handles) drawHandles(this, benches, visible);
    if (show.velocities) drawVelocities(this, benches, visible);
    if (show.labels) drawNumbers(this, benches, visible, inContact);
    if (show.contacts) drawContacts(this, time, benches, touching);
  }
}
