// The lines of sliders: as long as the motion needs. `standing`: the line is at rest.
function allRails() {
  const sliders = motion.joints.filter(j => ['prismatic', 'cylindrical'].includes(j.symbol) && j.axes.length > 0);
  return sliders.map(joint => {
    const {point, origin, axes} = joint, standing = (origin < 0 || origin >= motion.moving) && motion.rests(axes[0]);
    const posture = new Float64Array(3 * motion.points.length);
    const place = i => [posture[3 * i], posture[3 * i + 1], posture[3 * i + 2]];
    const start = origin < 0 ? Array.from(motion.posture(0).subarray(3 * point, 3 * point + 3)) : null;
    let [low, high] = [Infinity, -Infinity];
    for (let frame = 0; frame < motion.frames; ++frame) {
      motion.posture(frame, posture);
      const axis = motion.axis(axes[0], frame, posture), from = start ?? place(origin), to = place(point);
      const along = axis.reduce((sum, a, k) => sum + a * (to[k] - from[k]), 0);
      [low, high] = [Math.min(low, along), Math.max(high, along)];
    }
    const more = 0.12 * (high - low);
    return {joint, standing, start, low: low - more, high: high + more};
  });
}

// Both ends of a rail in a posture, each longer by `more`.
function railEnds({joint, start, low, high}, frame, posture, more = 0) {
  const axis = motion.axis(joint.axes[0], frame, posture), {origin} = joint;
  const from = start ?? Array.from(posture.subarray(3 * origin, 3 * origin + 3));
  return [low - more, high + more].map(s => from.map((v, k) => v + s * axis[k]));
}
