// The run as a CSV table, as from `pymunk-dragon positions`: a row for each handle at each time.

// Decimals of a speed, which is known to some 0.01 mm/s.
const SPEED_DIGITS = 4;
const COLUMNS = "time_s,handle,x_m,y_m,speed_m_s\n";

function tableOf(motion, times) {
  const parts = [COLUMNS];
  for (const time of times) {
    const poses = motion.posesAt(time);
    const handles = handlesOf(motion.spacings, poses);
    const velocities = motion.velocitiesOf(poses);
    const digits = decimals(Math.max(...handles.map((_, i) => motion.errorAt(time, Math.min(i, motion.benches - 1)))));
    parts.push(handles.map(([x, y], i) => {
      const speed = velocities ? Math.hypot(...velocities[i]).toFixed(SPEED_DIGITS) : "";
      return `${time},${i},${x.toFixed(digits)},${y.toFixed(digits)},${speed}\n`;
    }).join(""));
  }
  return new Blob(parts, { type: "text/csv" });
}
