// Rails at rest, each as long as the path of its slider, and the links that they replace.
function standingRails() {
  const rails = [];
  const onRail = new Set();
  const minus = (p, q) => p.map((v, k) => v - q[k]), length = p => Math.hypot(...p);
  motion.links.forEach(([from, to, kind], link) => {
    if (kind !== 'rail' || from < motion.moving || to >= motion.moving) return;
    const at = frame => [0, 1, 2].map(k =>
      k < motion.dimension ? motion.places[(frame * motion.moving + to) * motion.dimension + k] : 0);
    const farthestFrom = p => {
      let best = p;
      for (let frame = 0; frame < motion.frames; ++frame) {
        if (length(minus(at(frame), p)) > length(minus(best, p))) best = at(frame);
      }
      return best;
    };
    const one = farthestFrom(at(0)), other = farthestFrom(one);
    const way = minus(other, one);
    const isBeside = p => {
      const q = minus(p, one);
      const area = [0, 1, 2].map(k => way[(k + 1) % 3] * q[(k + 2) % 3] - way[(k + 2) % 3] * q[(k + 1) % 3]);
      return length(area) > 1e-4 * length(way) ** 2;
    };
    // No rail at rest if its direction turns, or if the point slides on a plane.
    if (length(way) === 0 || isBeside(motion.points[from].at)) return;
    for (let frame = 0; frame < motion.frames; ++frame) if (isBeside(at(frame))) return;
    rails.push([one.map((v, k) => v - 0.15 * way[k]), other.map((v, k) => v + 0.15 * way[k])]);
    onRail.add(link);
  });
  return [rails, onRail];
}
