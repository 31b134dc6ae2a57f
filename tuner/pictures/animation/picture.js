// Draws the mechanism on its canvas.
class Picture {
  static many = 150;  // with more points, marks are small and names are off at first

  constructor(canvas, camera, rails) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
    this.camera = camera;
    this.posture = motion.posture(0);
    this.screen = new Float64Array(2 * motion.points.length);
    this.isLarge = motion.points.length > Picture.many;
    this.options = {by: motion.joints.some(j => j.of.length > 0) ? 'body' : 'group', names: false, paths: false};
    this.rails = rails;
    this.jointAt = motion.points.map(() => null);
    for (const joint of [...motion.joints].reverse()) this.jointAt[joint.point] = joint;
    // Points on two bodies or more, and points whose names the program made, are no points to look at.
    const own = motion.points.map((p, i) => i).filter(i => i < motion.moving && !motion.points[i].name.includes('.'));
    const asked = new Set(motion.outputs.map(q => q.of)), wanted = own.filter(i => asked.has(motion.points[i].name));
    this.traced = wanted.length > 0 ? wanted : own;
    this.recolour();
  }

  resize() {
    const [width, height] = fitToScreen(this.canvas);
    this.camera.resize(width, height);
    // The size of symbols: a share of the picture, but small beside typical links.
    const lengths = [];
    this.camera.projectAll(motion.posture(0), this.screen);
    const add = (a, b) => lengths.push(this.distance(a, b) * this.camera.fitted / this.camera.zoom);
    for (const [a, b, , , inside] of motion.links) if (!inside) add(a, b);
    for (const [, , faces] of motion.bodies) for (const face of faces) face.forEach((a, k) => k && add(a, face[k - 1]));
    lengths.sort((a, b) => a - b);
    const typical = lengths.length > 0 ? lengths[Math.floor(0.6 * lengths.length)] : Infinity;
    this.size = Math.max(3.5, Math.min(7, 0.013 * Math.min(width, 1.6 * height), 0.12 * typical));
  }

  distance(a, b) {
    const s = this.screen;
    return Math.hypot(s[2 * a] - s[2 * b], s[2 * a + 1] - s[2 * b + 1]);
  }

  // ---- colours

  // The colour of group or level i of `count`.
  hue(i, count) {
    if (count <= 6) return style(`--c${i}`);
    return `hsl(${(i * 137.508 + 205) % 360} 60% ${this.isDark ? 66 : 40}%)`;  // the golden angle, so that neighbours differ
  }

  recolour() {
    this.isDark = matchMedia('(prefers-color-scheme: dark)').matches;
    for (const name of ['ink', 'paper', 'faint', 'rule']) this[name] = style(`--${name}`);
    this.levels = motion.groups.reduce((most, [, level]) => Math.max(most, level + 1), 0);
    const byBody = this.options.by === 'body';
    this.groupColour = motion.groups.map(([, level], i) =>
      this.options.by === 'level' ? this.hue(level, this.levels) : this.hue(i, motion.groups.length));
    const colour = group => byBody ? this.ink : this.groupColour[group] ?? (group === 'fixed' ? this.faint : this.ink);
    const rank = i => {
      const group = motion.points[i].group;
      return Number.isInteger(group) ? group : ['fixed', 'at rest', 'driven'].indexOf(group) - 3;
    };
    // A link or body between two groups has the colour of the later one.
    const later = points => motion.points[points.reduce((a, b) => rank(b) > rank(a) ? b : a)].group;
    this.pointColour = motion.points.map(p => colour(p.group));
    const wrong = new Set(motion.violated);
    this.linkColour = motion.links.map(([from, to, , name]) =>
      wrong.has(name) ? style('--wrong') : byBody ? this.faint : colour(later([from, to])));
    this.bodyColour = motion.bodies.map(([, points], i) =>
      byBody ? this.hue(i, motion.bodies.length) : colour(later(points)));
    this.bodyNamed = new Map(motion.bodies.map(([name], i) => [name, i]));
    // A rod within a body is a part of its outline.
    this.links = motion.links.map((l, i) => i).filter(i => !motion.links[i][4] || wrong.has(motion.links[i][3]));
    this.dots = motion.points.map((p, i) => i).filter(i => !this.jointAt[i] && !motion.points[i].name.includes('.'));
    const gather = (colours, indices) => {
      const batches = new Map();
      for (const i of indices) {
        if (!batches.has(colours[i])) batches.set(colours[i], []);
        batches.get(colours[i]).push(i);
      }
      return batches;
    };
    this.batches = {traced: gather(this.pointColour, this.traced)};
    if (!this.isLarge) return;
    for (const kind of ['rod', 'actuator', 'relation']) {
      this.batches[kind] = gather(this.linkColour, this.links.filter(i => motion.links[i][2] === kind));
    }
    this.batches.point = gather(this.pointColour, motion.points.map((p, i) => i));
    this.batches.body = gather(this.bodyColour, motion.bodies.map((b, i) => i));
  }

  draw(frame) {
    this.frame = frame;
    motion.posture(frame, this.posture);
    this.camera.projectAll(this.posture, this.screen);
    this.r = this.size * Math.max(0.7, Math.min(2.5, Math.sqrt(this.camera.zoom / this.camera.fitted)));
    const c = this.context;
    c.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    c.lineJoin = c.lineCap = 'round';
    c.font = '12px system-ui, sans-serif';
    if (!this.camera.flat) this.drawFloor();
    this.drawRails();
    if (this.options.paths) this.drawPaths();
    if (this.isLarge) this.drawMany(); else this.drawParts();
    if (this.options.names) this.drawNames();
    this.drawScale();
    if (!this.camera.flat) this.drawAxes();
  }

  stroke(colour, width, dash, path) {
    const c = this.context;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.beginPath();
    path(c);
    c.stroke();
    c.setLineDash([]);
  }

  // The grid in the background.
  drawFloor() {
    const {low, high} = this.camera.box;
    const step = roundUp(2 * this.camera.radius / 12);
    const lines = k => {
      const places = [low[k], high[k]];
      for (let i = Math.ceil(low[k] / step); i * step < high[k]; ++i) places.push(i * step);
      return places;
    };
    this.stroke(this.rule, 1, [], c => {
      const line = (p, q) => {
        c.moveTo(...this.camera.project(p));
        c.lineTo(...this.camera.project(q));
      };
      for (const x of lines(0)) line([x, low[1], low[2]], [x, high[1], low[2]]);
      for (const y of lines(1)) line([low[0], y, low[2]], [high[0], y, low[2]]);
    });
  }

  // Lines of sliders: hatched on the ground, else a bar of their body.
  drawRails() {
    const c = this.context, least = 4 * this.r / this.camera.zoom;
    for (const rail of this.rails) {
      const [p, q] = railEnds(rail, this.frame, this.posture, least).map(end => this.camera.project(end));
      if (rail.standing) {
        c.strokeStyle = this.ink;
        c.lineWidth = 1.2;
        symbols.hatched(c, p[0] > q[0] ? q : p, p[0] > q[0] ? p : q, this.r);
      } else {
        const body = this.bodyNamed.get(rail.joint.of[0]);
        this.bar(p, q, body === undefined ? this.faint : this.bodyColour[body], 0.7 * this.r);
      }
    }
  }

  drawPaths() {
    this.context.globalAlpha = 0.6;
    const {moving, dimension, places, frames} = motion;
    const point = [0, 0, 0];
    for (const [colour, points] of this.batches.traced) {
      this.stroke(colour, 1, [], c => {
        for (const i of points.slice(0, Picture.many)) {
          for (let frame = 0; frame < frames; ++frame) {
            for (let k = 0; k < dimension; ++k) point[k] = places[(frame * moving + i) * dimension + k];
            const [x, y] = this.camera.project(point);
            if (frame === 0) c.moveTo(x, y); else c.lineTo(x, y);
          }
        }
      });
    }
    this.context.globalAlpha = 1;
  }

  // ---- parts: bodies, links, joints and single points

  // In space, far parts come first.
  drawParts() {
    const eye = this.camera.toEye, p = this.posture;
    const depth = i => eye[0] * p[3 * i] + eye[1] * p[3 * i + 1] + eye[2] * p[3 * i + 2];
    const mean = points => points.reduce((sum, i) => sum + depth(i), 0) / points.length;
    const near = 1e-3 * this.camera.radius;  // joints lie before the parts that meet in them
    const parts = [
      ...motion.bodies.map(([, points], i) => [mean(points), () => this.drawBody(i)]),
      ...this.links.map(i => [mean(motion.links[i].slice(0, 2)), () => this.drawLink(i)]),
      ...motion.joints.map(j => [depth(j.point) + near, () => this.drawJoint(j)]),
      ...this.dots.map(i => [depth(i) + near, () => this.drawDot(i)]),
    ];
    if (!this.camera.flat) parts.sort(([a], [b]) => a - b);
    for (const [, draw] of parts) draw();
  }

  at(i) { return [this.screen[2 * i], this.screen[2 * i + 1]]; }

  // A line with a margin, so that crossing bars are seen one before the other.
  bar(from, to, colour, width, dash = []) {
    for (const [c, w, d] of [[this.paper, width + 3, []], [colour, width, dash]]) {
      this.stroke(c, w, d, path => {
        path.moveTo(...from);
        path.lineTo(...to);
      });
    }
  }

  drawBody(i) {
    const [, points, faces] = motion.bodies[i], c = this.context, colour = this.bodyColour[i];
    if (faces.every(face => face.length === 2)) {
      for (const [a, b] of faces) this.bar(this.at(a), this.at(b), colour, 1.1 * this.r);
      return;
    }
    const path = this.outline(faces);
    c.fillStyle = this.paper;
    c.globalAlpha = 0.55;
    c.fill(path);
    c.fillStyle = c.strokeStyle = colour;
    c.globalAlpha = 0.25;
    c.fill(path);
    c.globalAlpha = 1;
    c.lineWidth = faces.length > 1 ? 0.3 * this.r : 0.7 * this.r;
    c.stroke(path);
  }

  drawLink(i) {
    const [from, to, kind] = motion.links[i], colour = this.linkColour[i];
    if (kind === 'relation') {
      this.stroke(colour, 1, [2, 4], c => {
        c.moveTo(...this.at(from));
        c.lineTo(...this.at(to));
      });
      return;
    }
    if (kind === 'rod') return this.bar(this.at(from), this.at(to), colour, 0.9 * this.r);
    // An actuator: a thin rod that leaves a cylinder.
    const [p, q] = [this.at(from), this.at(to)], share = s => p.map((v, k) => v + s * (q[k] - v));
    this.bar(p, q, colour, 0.5 * this.r);
    this.bar(share(0.08), share(0.55), colour, 1.7 * this.r);
    this.stroke(this.paper, 0.8 * this.r, [], c => {
      c.moveTo(...share(0.08));
      c.lineTo(...share(0.55));
    });
  }

  drawJoint({symbol, point, axes, driven}) {
    const c = this.context, at = this.at(point);
    const ways = axes.map(a => motion.axis(a, this.frame, this.posture));
    c.fillStyle = this.paper;
    c.strokeStyle = point < motion.moving ? this.pointColour[point] : this.ink;
    c.lineWidth = Math.max(1.2, 0.28 * this.r);
    if (point >= motion.moving) symbols.ground(c, at, this.r);
    if (driven) c.fillStyle = symbols.motor;
    symbols[symbol](c, at, this.r, v => this.camera.view(v), ...ways);
  }

  // A point that is no joint: a dot, and at rest a small cross.
  drawDot(i) {
    const c = this.context, [x, y] = this.at(i), r = 0.6 * this.r;
    if (i < motion.moving) {
      c.fillStyle = this.pointColour[i];
      c.beginPath();
      c.arc(x, y, r, 0, 2 * Math.PI);
      c.fill();
      return;
    }
    this.stroke(this.faint, 1, [], path => {
      for (const side of [1, -1]) {
        path.moveTo(x - r, y - side * r);
        path.lineTo(x + r, y + side * r);
      }
    });
  }

  // All faces form one shape with the same orientation, so that overlapping ones are filled only once.
  outline(faces) {
    const path = new Path2D(), s = this.screen;
    for (const face of faces) {
      const area = face.reduce((sum, i, k) => {
        const j = face[(k + 1) % face.length];
        return sum + s[2 * i] * s[2 * j + 1] - s[2 * j] * s[2 * i + 1];
      }, 0);
      (area < 0 ? [...face].reverse() : face).forEach((i, k) => path[k ? 'lineTo' : 'moveTo'](s[2 * i], s[2 * i + 1]));
      path.closePath();
    }
    return path;
  }

  // ---- many points: lines of one colour are drawn together

  drawMany() {
    const c = this.context, s = this.screen;
    for (const [colour, bodies] of this.batches.body) {
      const path = this.outline(bodies.flatMap(b => motion.bodies[b][2]));
      c.fillStyle = c.strokeStyle = colour;
      c.lineWidth = 1;
      c.globalAlpha = 0.13;
      c.fill(path);
      c.globalAlpha = 1;
      c.stroke(path);
    }
    const looks = {relation: [1, [2, 4]], rod: [1.5, []], actuator: [2.5, [9, 5]]};
    for (const [kind, [width, dash]] of Object.entries(looks)) {
      for (const [colour, links] of this.batches[kind]) {
        this.stroke(colour, width, dash, path => {
          for (const l of links) {
            path.moveTo(...this.at(motion.links[l][0]));
            path.lineTo(...this.at(motion.links[l][1]));
          }
        });
      }
    }
    for (const [colour, points] of this.batches.point) {
      c.fillStyle = colour;
      for (const i of points) {
        if (motion.points[i].name.includes('.')) continue;
        c.beginPath();
        if (i < motion.moving) c.arc(s[2 * i], s[2 * i + 1], 2, 0, 2 * Math.PI);
        else c.rect(s[2 * i] - 2, s[2 * i + 1] - 2, 4, 4);
        c.fill();
      }
    }
  }

  // ---- texts

  // Each name stands at the first free place beside its point.
  drawNames() {
    const c = this.context, r = this.r, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    c.lineWidth = 3;
    c.strokeStyle = this.paper;
    c.fillStyle = this.ink;
    const taken = motion.points.map(({name}, i) => name.includes('.') ? null : this.at(i)).filter(Boolean)
      .map(([x, y]) => [x - r, y - r, x + r, y + r]);
    const isFree = ([left, top, right, bottom]) => left > 2 && right < width - 2 && top > 2 && bottom < height - 2 &&
      taken.every(([l, t, rr, b]) => right < l || left > rr || bottom < t || top > b);
    motion.points.forEach(({name}, i) => {
      if (name.includes('.')) return;
      const [x, y] = this.at(i), w = c.measureText(name).width, off = r + 4;
      const places = [[off, -off], [-off - w, -off], [off, off + 9], [-off - w, off + 9], [-w / 2, -off - 4],
                      [off + 2, 4], [-off - w - 2, 4], [-w / 2, off + 12 + 2 * r]];
      for (const [dx, dy] of places) {
        const [left, base] = [x + dx, y + dy], box = [left - 1, base - 10, left + w + 1, base + 3];
        if (!isFree(box)) continue;
        taken.push(box);
        c.strokeText(name, left, base);
        c.fillText(name, left, base);
        return;
      }
    });
  }

  drawScale() {
    const metres = roundUp(60 / this.camera.zoom), pixels = metres * this.camera.zoom;
    const y = this.canvas.clientHeight - 14;
    this.stroke(this.faint, 1.5, [], c => {
      c.moveTo(14, y - 4);
      c.lineTo(14, y);
      c.lineTo(14 + pixels, y);
      c.lineTo(14 + pixels, y - 4);
    });
    this.context.fillStyle = this.faint;
    this.context.fillText(`${digits(metres)} m`, 20 + pixels, y);
  }

  drawAxes() {
    const c = this.context, x0 = this.canvas.clientWidth - 44, y0 = this.canvas.clientHeight - 40;
    for (let k = 0; k < 3; ++k) {
      const dx = 26 * this.camera.right[k], dy = -26 * this.camera.up[k];
      this.stroke(this.faint, 1.5, [], () => {
        c.moveTo(x0, y0);
        c.lineTo(x0 + dx, y0 + dy);
      });
      c.fillStyle = this.faint;
      c.fillText('xyz'[k], x0 + 1.3 * dx - 3, y0 + 1.3 * dy + 4);
    }
  }
}
