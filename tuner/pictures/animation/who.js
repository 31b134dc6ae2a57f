// Describes the point, link or body at (x, y); null if there is none.
function whoIsAt(picture, x, y) {
  const s = picture.screen;
  const groupOf = group => Number.isInteger(group)
    ? `group ${motion.groups[group][0]}, level ${motion.groups[group][1] + 1}` : group;
  const closest = (count, distance, reach) => {
    let best = -1, least = reach;
    for (let i = 0; i < count; ++i) {
      const d = distance(i);
      if (d <= least) [best, least] = [i, d];
    }
    return best;
  };
  const point = closest(motion.points.length, i => Math.hypot(s[2 * i] - x, s[2 * i + 1] - y), 12);
  if (point >= 0) {
    const place = [...picture.posture.subarray(3 * point, 3 * point + motion.dimension)].map(v => digits(v)).join(', ');
    const joint = picture.jointAt[point];
    const what = joint ? `${joint.driven ? 'driven ' : ''}${joint.symbol} joint${joint.name === motion.points[point].name ? '' : ` ${joint.name}`}` +
      `${joint.of.length > 0 ? ` of ${joint.of.join(' and ')}` : ''}\n` : '';
    return `${motion.points[point].name} (${place}) m\n${what}${groupOf(motion.points[point].group)}`;
  }
  const link = closest(motion.links.length, l => {
    const [a, b, , , inside] = motion.links[l];
    if (inside) return Infinity;
    const [dx, dy] = [s[2 * b] - s[2 * a], s[2 * b + 1] - s[2 * a + 1]];
    const share = ((x - s[2 * a]) * dx + (y - s[2 * a + 1]) * dy) / (dx * dx + dy * dy || 1);
    const f = Math.max(0, Math.min(1, share));
    return Math.hypot(s[2 * a] + f * dx - x, s[2 * a + 1] + f * dy - y);
  }, 6);
  if (link >= 0) {
    const [a, b, kind, name] = motion.links[link], p = picture.posture;
    const length = Math.hypot(p[3 * a] - p[3 * b], p[3 * a + 1] - p[3 * b + 1], p[3 * a + 2] - p[3 * b + 2]);
    return `${name}: ${motion.points[a].name}–${motion.points[b].name}\n${kind}, ${digits(length)} m`;
  }
  const ratio = window.devicePixelRatio || 1;
  const body = motion.bodies.findIndex(([, , faces]) => {
    const path = picture.outline(faces);
    picture.context.lineWidth = 8;  // a bar has no inside
    return picture.context.isPointInPath(path, x * ratio, y * ratio) ||
      picture.context.isPointInStroke(path, x * ratio, y * ratio);
  });
  return body < 0 ? null : `body ${motion.bodies[body][0]}`;
}
