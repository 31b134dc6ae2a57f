// Projects metres to pixels: parallel in the plane, with a mild perspective in space.
class Camera {
  constructor(box, dimension) {
    this.flat = dimension === 2;
    this.box = box;
    this.centre = box.low.map((low, k) => (low + box.high[k]) / 2);
    this.radius = Math.hypot(...box.low.map((low, k) => box.high[k] - low)) / 2 || 1;
    this.width = this.height = 1;
    this.turnTo(-0.9, 0.45);
    if (!this.flat) this.lookAround();
    this.fit();
  }

  // Chooses a view in which a mechanism in a plane is not seen from its edge: the picture is widest in its narrow way.
  lookAround() {
    const spread = () => {
      const seen = this.box.some.map(p => this.view(p.map((v, k) => v - this.centre[k])));
      const sum = f => seen.reduce((all, p) => all + f(p), 0) / seen.length;
      const [x, y] = [sum(p => p[0]), sum(p => p[1])];
      const [xx, xy, yy] = [sum(p => (p[0] - x) ** 2), sum(p => (p[0] - x) * (p[1] - y)), sum(p => (p[1] - y) ** 2)];
      return Math.sqrt(Math.max(0, (xx + yy) / 2 - Math.hypot((xx - yy) / 2, xy)));
    };
    let [best, most] = [[-0.9, 0.45], 1.5 * spread()];  // another view must be clearly better
    for (let k = 0; k < 12; ++k) {
      for (const pitch of [0.25, 0.45, 0.65, 0.9]) {
        const yaw = -0.9 + k * Math.PI / 6;
        this.turnTo(yaw, pitch);
        if (spread() > most * 1.0001) [best, most] = [[yaw, pitch], spread()];
      }
    }
    this.turnTo(...best);
  }

  // Azimuth and elevation of the eye, rad.
  turnTo(yaw, pitch) {
    this.yaw = yaw;
    this.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, pitch));
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    this.right = this.flat ? [1, 0, 0] : [-sy, cy, 0];
    this.up = this.flat ? [0, 1, 0] : [-cy * sp, -sy * sp, cp];
    this.toEye = this.flat ? [0, 0, 1] : [cy * cp, sy * cp, sp];
  }

  turn(dx, dy) { this.turnTo(this.yaw - dx, this.pitch + dy); }

  pan(dx, dy) {
    this.x += dx;
    this.y += dy;
  }

  // Zooms by a factor around the pixel (x, y).
  zoomAt(x, y, factor) {
    const zoom = Math.max(this.fitted / 50, Math.min(this.fitted * 5000, this.zoom * factor)), f = zoom / this.zoom;
    this.x = x - this.width / 2 - (x - this.width / 2 - this.x) * f;
    this.y = y - this.height / 2 - (y - this.height / 2 - this.y) * f;
    this.zoom = zoom;
  }

  resize(width, height) {
    const untouched = this.zoom === this.fitted;
    const factor = Math.min(width / this.width, height / this.height);
    [this.width, this.height] = [width, height];
    if (untouched) this.fit(); else this.zoom *= factor;
  }

  // Shows the whole motion.
  fit() {
    this.zoom = 1;
    this.x = this.y = 0;
    let [left, right, top, bottom] = [Infinity, -Infinity, Infinity, -Infinity];
    const floor = [0, 1, 2, 3].map(i => [0, 1, 2].map(k => (i >> k & 1 ? this.box.high : this.box.low)[k]));
    for (const p of [...floor, ...this.box.some]) {
      const [x, y] = this.project(p);
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
    const margin = 40, least = this.radius / 1e3;
    this.zoom = Math.min(Math.max(this.width - 2 * margin, 50) / Math.max(right - left, least),
                         Math.max(this.height - 2 * margin, 50) / Math.max(bottom - top, least));
    this.x = this.zoom * (this.width / 2 - (left + right) / 2);
    this.y = this.zoom * (this.height / 2 - (top + bottom) / 2);
    this.fitted = this.zoom;
  }

  // A vector to the right, upwards and to the eye, without perspective.
  view(v) {
    return [this.right, this.up, this.toEye].map(axis => axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]);
  }

  // x and y of all points, in pixels.
  projectAll(posture, out) {
    for (let i = 0; 3 * i < posture.length; ++i) {
      const [x, y] = this.project([posture[3 * i], posture[3 * i + 1], posture[3 * i + 2]]);
      out[2 * i] = x;
      out[2 * i + 1] = y;
    }
    return out;
  }

  project(p) {
    const [dx, dy, dz] = [p[0] - this.centre[0], p[1] - this.centre[1], p[2] - this.centre[2]];
    const along = axis => axis[0] * dx + axis[1] * dy + axis[2] * dz;
    const distance = 5 * this.radius;  // of the eye
    const scale = this.flat ? this.zoom : this.zoom * distance / Math.max(distance - along(this.toEye), distance / 20);
    return [this.width / 2 + this.x + scale * along(this.right), this.height / 2 + this.y - scale * along(this.up)];
  }
}

// Dragging turns the view, or moves it in the plane and with Shift or two fingers; wheel and pinch zoom.
function followGestures(canvas, camera, changed) {
  const fingers = new Map();
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) || 1};
  };
  canvas.addEventListener('pointerdown', e => {
    canvas.setPointerCapture(e.pointerId);
    fingers.set(e.pointerId, {x: e.offsetX, y: e.offsetY});
  });
  canvas.addEventListener('pointermove', e => {
    const finger = fingers.get(e.pointerId);
    if (!finger) return;
    const before = fingers.size === 2 ? spread() : finger;
    const now = {x: e.offsetX, y: e.offsetY};
    fingers.set(e.pointerId, now);
    if (fingers.size === 2) {
      const after = spread();
      camera.pan(after.x - before.x, after.y - before.y);
      camera.zoomAt(after.x, after.y, after.size / before.size);
    } else if (camera.flat || e.shiftKey) {
      camera.pan(now.x - before.x, now.y - before.y);
    } else {
      camera.turn((now.x - before.x) * 0.008, (now.y - before.y) * 0.008);
    }
    changed();
  });
  for (const type of ['pointerup', 'pointercancel']) canvas.addEventListener(type, e => fingers.delete(e.pointerId));
  canvas.addEventListener('wheel', e => {
    e.preventDefault();
    camera.zoomAt(e.offsetX, e.offsetY, Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)));
    changed();
  }, {passive: false});
}
