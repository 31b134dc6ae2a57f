// Symbols of joints, as engineers draw them. `at` is the place on the screen, `r` the size in pixels, and `view` turns
// a vector into its picture: to the right, upwards and to the eye, in shares of its length.
const symbols = {
  motor: '#ffb300',  // fills driven joints

  // A pin that leads to the eye; a hinge from the side is a short cylinder along its axis.
  revolute(c, at, r, view, axis) {
    if (axis) return symbols.cylinder(c, at, r, view(axis), 1.8);
    c.beginPath();
    c.arc(at[0], at[1], r, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
  },

  // A sleeve on a rod.
  cylindrical(c, at, r, view, axis) {
    const [x, y] = view(axis);
    c.beginPath();
    c.moveTo(at[0] - 5 * r * x, at[1] + 5 * r * y);
    c.lineTo(at[0] + 5 * r * x, at[1] - 5 * r * y);
    c.stroke();
    symbols.cylinder(c, at, r, view(axis), 2.6);
  },

  cylinder(c, at, r, [x, y, z], half) {
    const sign = z < 0 ? -1 : 1, angle = Math.atan2(-y, x), dx = sign * half * r * x, dy = -sign * half * r * y;
    const across = Math.hypot(x, y) || 1, sx = r * y / across, sy = r * x / across;
    const disc = (px, py, size) => {
      c.beginPath();
      c.ellipse(px, py, size * r * Math.abs(z), size * r, angle, 0, 2 * Math.PI);
    };
    disc(at[0] - dx, at[1] - dy, 1);
    c.fill();
    c.stroke();
    c.beginPath();
    c.moveTo(at[0] - dx + sx, at[1] - dy + sy);
    c.lineTo(at[0] + dx + sx, at[1] + dy + sy);
    c.lineTo(at[0] + dx - sx, at[1] + dy - sy);
    c.lineTo(at[0] - dx - sx, at[1] - dy - sy);
    c.fill();
    for (const side of [1, -1]) {
      c.beginPath();
      c.moveTo(at[0] - dx + side * sx, at[1] - dy + side * sy);
      c.lineTo(at[0] + dx + side * sx, at[1] + dy + side * sy);
      c.stroke();
    }
    disc(at[0] + dx, at[1] + dy, 1);
    c.fill();
    c.stroke();
    disc(at[0] + dx, at[1] + dy, 0.35);
    c.stroke();
  },

  // A block on its line.
  prismatic(c, at, r, view, axis) {
    const [b, n] = acrossTo(axis);
    symbols.box(c, at, view, [[axis, 2 * r], [b, 1.25 * r], [n, 1.25 * r]]);
  },

  // A plate in its plane.
  planar(c, at, r, view, axis, other) {
    const normal = other ? cross(axis, other) : axis, [b, n] = acrossTo(normal);
    symbols.box(c, at, view, [[b, 3 * r], [n, 3 * r], [normal, 0.3 * r]]);
  },

  // A box: half its edges, as directions with their lengths. Only the faces that look at the eye are visible.
  box(c, at, view, edges) {
    const seen = edges.map(([way, length]) => {
      const [x, y, z] = view(way);
      return [length * x, -length * y, z];
    });
    seen.forEach((normal, k) => {
      const sign = normal[2] < 0 ? -1 : 1, [a, b] = [seen[(k + 1) % 3], seen[(k + 2) % 3]];
      if (Math.abs(normal[2]) < 1e-6) return;
      c.beginPath();
      for (const [i, j] of [[1, 1], [1, -1], [-1, -1], [-1, 1]]) {
        c.lineTo(at[0] + sign * normal[0] + i * a[0] + j * b[0], at[1] + sign * normal[1] + i * a[1] + j * b[1]);
      }
      c.closePath();
      c.fill();
      c.stroke();
    });
  },

  // A ball, with the light on its upper left.
  spherical(c, at, r) {
    c.beginPath();
    c.arc(at[0], at[1], 1.1 * r, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
    c.beginPath();
    c.arc(at[0], at[1], 0.65 * r, 1.05 * Math.PI, 1.45 * Math.PI);
    c.stroke();
  },

  // A cross of two axes.
  universal(c, at, r, view, first, second) {
    for (const axis of [first, second]) {
      const [x, y] = view(axis);
      c.beginPath();
      for (const side of [2, -2]) {
        c.moveTo(at[0], at[1]);
        c.lineTo(at[0] + side * r * x, at[1] - side * r * y);
      }
      c.lineWidth *= 2;
      c.stroke();
      c.lineWidth /= 2;
    }
    c.beginPath();
    c.arc(at[0], at[1], 0.6 * r, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
  },

  // The ground below a joint: a triangle on a hatched line.
  ground(c, at, r) {
    const [x, y] = at, down = y + 2.3 * r;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x - 1.5 * r, down);
    c.lineTo(x + 1.5 * r, down);
    c.closePath();
    c.fill();
    c.stroke();
    symbols.hatched(c, [x - 2.3 * r, down], [x + 2.3 * r, down], r);
  },

  // A line with hatching on its right, seen along it.
  hatched(c, from, to, r) {
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(dx, dy);
    const count = Math.min(200, Math.max(2, Math.round(length / (1.1 * r)))), size = 0.9 * r;
    if (!(length > 0)) return;
    c.beginPath();
    c.moveTo(...from);
    c.lineTo(...to);
    for (let k = 1; k <= count; ++k) {
      const x = from[0] + dx * k / count, y = from[1] + dy * k / count;
      c.moveTo(x, y);
      c.lineTo(x - size * (dx + dy) / length, y - size * (dy - dx) / length);
    }
    c.stroke();
  },
};

const cross = (a, b) => [0, 1, 2].map(k => a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
const unit = a => {
  const length = Math.hypot(...a) || 1;
  return a.map(v => v / length);
};
// Two directions at right angles to one and to each other; the second is the normal of the plane if the first is in it.
const acrossTo = axis => {
  const other = Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], b = unit(cross(other, axis));
  return [b, unit(cross(axis, b))];
};
