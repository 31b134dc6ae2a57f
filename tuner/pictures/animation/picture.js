// Draws the mechanism on its canvas.
class Picture {
  static many = 150;  // with more points, marks are small and names are off at first

  constructor(canvas, camera) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
    this.camera = camera;
    this.posture = motion.posture(0);
    this.screen = new Float64Array(2 * motion.points.length);
    this.options = {by: 'group', names: false, paths: false};
    [this.rails, this.onRail] = standingRails();
    this.recolour();
  }

  resize() { this.camera.resize(...fitToScreen(this.canvas)); }

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
    this.groupColour = motion.groups.map(([, level], i) =>
      this.options.by === 'level' ? this.hue(level, this.levels) : this.hue(i, motion.groups.length));
    const colour = group => this.groupColour[group] ?? (group === 'fixed' ? this.faint : this.ink);
    const rank = i => {
      const group = motion.points[i].group;
      return Number.isInteger(group) ? group : ['fixed', 'at rest', 'driven'].indexOf(group) - 3;
    };
    // A link or body between two groups has the colour of the later one.
    const later = points => motion.points[points.reduce((a, b) => rank(b) > rank(a) ? b : a)].group;
    this.pointColour = motion.points.map(p => colour(p.group));
    const wrong = new Set(motion.violated);
    this.linkColour = motion.links.map(([from, to, , name]) =>
      wrong.has(name) ? style('--wrong') : colour(later([from, to])));
    this.bodyColour = motion.bodies.map(([, points]) => colour(later(points)));
    const gather = (colours, keep) => {
      const batches = new Map();
      colours.forEach((c, i) => {
        if (!batches.has(c)) batches.set(c, []);
        if (keep(i)) batches.get(c).push(i);
      });
      return batches;
    };
    this.batches = {};
    for (const kind of ['rod', 'actuator', 'rail', 'relation']) {
      this.batches[kind] = gather(this.linkColour, i => motion.links[i][2] === kind && !this.onRail.has(i));
    }
    this.batches.point = gather(this.pointColour, i => i < motion.moving);
    this.batches.body = gather(this.bodyColour, () => true);
  }

  draw(frame) {
    this.frame = frame;
    motion.posture(frame, this.posture);
    this.camera.projectAll(this.posture, this.screen);
    const c = this.context;
    c.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    c.lineJoin = c.lineCap = 'round';
    c.font = '12px system-ui, sans-serif';
    if (!this.camera.flat) this.drawFloor();
    this.drawRails();
    if (this.options.paths) this.drawPaths();
    this.drawBodies();
    this.drawLinks();
    this.drawPoints();
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

  drawRails() {
    this.stroke(this.faint, 1, [6, 4], c => {
      for (const [p, q] of this.rails) {
        c.moveTo(...this.camera.project(p));
        c.lineTo(...this.camera.project(q));
      }
    });
  }

  drawPaths() {
    this.context.globalAlpha = 0.55;
    const {moving, dimension, places, frames} = motion;
    const point = [0, 0, 0];
    for (const [colour, points] of this.batches.point) {
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

  drawBodies() {
    const c = this.context;
    for (const [colour, bodies] of this.batches.body) {
      const path = this.outline(bodies.flatMap(b => motion.bodies[b][2]));
      c.fillStyle = c.strokeStyle = colour;
      c.lineWidth = motion.points.length > Picture.many ? 1 : 1.5;
      c.globalAlpha = 0.13;
      c.fill(path);
      c.globalAlpha = 1;
      c.stroke(path);
    }
  }

  drawLinks() {
    const thin = motion.links.length > Picture.many ? 0.5 : 1;
    const looks = {relation: [1, [2, 4]], rail: [1, [6, 4]], rod: [3 * thin, []], actuator: [5 * thin, [9, 5]]};
    for (const [kind, [width, dash]] of Object.entries(looks)) {
      for (const [colour, links] of this.batches[kind]) {
        this.stroke(colour, width, dash, c => {
          for (const l of links) {
            const [from, to] = motion.links[l];
            c.moveTo(this.screen[2 * from], this.screen[2 * from + 1]);
            c.lineTo(this.screen[2 * to], this.screen[2 * to + 1]);
          }
        });
      }
    }
  }

  drawPoints() {
    const c = this.context, s = this.screen;
    const small = motion.points.length > Picture.many;
    const r = small ? 2 : 4;
    for (const [colour, points] of this.batches.point) {
      c.fillStyle = colour;
      c.strokeStyle = this.paper;
      c.lineWidth = 1.5;
      for (const i of points) {
        c.beginPath();
        if (motion.points[i].slides) c.rect(s[2 * i] - 1.6 * r, s[2 * i + 1] - 1.2 * r, 3.2 * r, 2.4 * r);
        else c.arc(s[2 * i], s[2 * i + 1], r, 0, 2 * Math.PI);
        c.fill();
        if (!small) c.stroke();
      }
    }
    // Ground points: a triangle with hatching, or a small square if there are many points.
    this.stroke(this.ink, small ? 1 : 1.5, [], () => {
      for (let i = motion.moving; i < motion.points.length; ++i) {
        const x = s[2 * i], y = s[2 * i + 1];
        if (small) {
          c.rect(x - 2, y - 2, 4, 4);
          continue;
        }
        c.moveTo(x, y);
        c.lineTo(x - 6, y + 10);
        c.lineTo(x + 6, y + 10);
        c.closePath();
        for (let k = -6; k <= 6; k += 4) {
          c.moveTo(x + k, y + 10);
          c.lineTo(x + k - 3, y + 14);
        }
      }
    });
  }

  drawNames() {
    const c = this.context;
    c.lineWidth = 3;
    c.strokeStyle = this.paper;
    c.fillStyle = this.ink;
    const taken = new Set();  // occupied places, so that names do not cover each other
    motion.points.forEach(({name}, i) => {
      const x = this.screen[2 * i] + 7, y = this.screen[2 * i + 1] - 7;
      const place = `${Math.round(x / 34)},${Math.round(y / 14)}`;
      if (taken.has(place)) return;
      taken.add(place);
      c.strokeText(name, x, y);
      c.fillText(name, x, y);
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
