// Plots one quantity over time, with a cursor at the current frame.
class Curves {
  constructor(quantity, panels, seek) {
    this.quantity = quantity;
    this.figure = panels.appendChild(document.createElement('figure'));
    this.caption = this.figure.appendChild(document.createElement('figcaption'));
    this.canvas = this.figure.appendChild(document.createElement('canvas'));
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', `${quantity.title} over time`);
    this.background = document.createElement('canvas');
    const follow = e => {
      if (e.type === 'pointermove' && !e.buttons) return;
      const share = (e.offsetX - this.left) / (this.right - this.left);
      seek(motion.times[0] + share * (motion.times[motion.frames - 1] - motion.times[0]));
    };
    this.canvas.addEventListener('pointerdown', follow);
    this.canvas.addEventListener('pointermove', follow);
    this.caption.append(quantity.title + (quantity.unit ? `, ${quantity.unit}` : ''));
    this.readings = quantity.columns.map((column, i) => {
      const reading = this.caption.appendChild(document.createElement('span'));
      reading.style.color = quantity.columns.length > 1 ? `var(--c${i})` : '';
      return reading;
    });
  }

  value(frame, column) { return motion.values[frame * motion.width + column]; }

  resize() { this.drawBackground(this.background.getContext('2d'), ...fitToScreen(this.canvas, this.background)); }

  range() {
    let [low, high] = [Infinity, -Infinity];
    for (const column of this.quantity.columns) {
      for (let frame = 0; frame < motion.frames; ++frame) {
        const value = this.value(frame, column);
        if (Number.isNaN(value)) continue;
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
    }
    if (low > high) [low, high] = [0, 1];
    // A constant quantity is a line in the middle, even with rounding errors.
    const size = Math.max(Math.abs(low), Math.abs(high)), room = 0.1 * size || 1;
    return high - low > 1e-6 * size ? [low, high] : [low - room, high + room];
  }

  drawBackground(c, width, height) {
    const [low, high] = this.range();
    const step = roundUp((high - low) / 4);
    const bottom = Math.floor(low / step + 1e-9) * step, top = Math.ceil(high / step - 1e-9) * step;
    const name = value => digits(Math.abs(value) < step / 1e3 ? 0 : value, 8);
    const ticks = [];
    for (let k = 0; bottom + k * step <= top + step / 2; ++k) ticks.push(bottom + k * step);
    c.font = '12px system-ui, sans-serif';
    this.left = Math.max(...ticks.map(t => c.measureText(name(t)).width)) + 8;
    this.right = width - 10;
    this.top = 8;
    this.bottom = height - 22;
    this.y = value => this.bottom - (value - bottom) / (top - bottom) * (this.bottom - this.top);
    const t0 = motion.times[0], t1 = motion.times[motion.frames - 1];
    this.x = t => t1 > t0 ? this.left + (t - t0) / (t1 - t0) * (this.right - this.left) : (this.left + this.right) / 2;

    c.lineWidth = 1;
    c.strokeStyle = style('--rule');
    c.fillStyle = style('--faint');
    c.textAlign = 'right';
    const line = (x0, y0, x1, y1) => {
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1, y1);
      c.stroke();
    };
    for (const t of ticks) {
      line(this.left, this.y(t), this.right, this.y(t));
      c.fillText(name(t), this.left - 6, this.y(t) + 4);
    }
    c.textAlign = 'center';
    const every = t1 > t0 ? roundUp((t1 - t0) / Math.max(2, Math.floor(width / 60))) : 1;
    for (let k = Math.ceil(t0 / every - 1e-9); k * every <= t1 + every * 1e-9; ++k) {
      const x = this.x(k * every);
      line(x, this.top, x, this.bottom);
      const text = digits(k * every) + ((k + 1) * every > t1 + every * 1e-9 ? ' s' : '');
      c.fillText(text, Math.min(x, width - c.measureText(text).width / 2), height - 6);
    }
    this.quantity.columns.forEach((column, i) => {
      c.strokeStyle = style(`--c${i}`);
      c.lineWidth = 1.75;
      c.beginPath();
      for (let frame = 0; frame < motion.frames; ++frame) {
        c.lineTo(this.x(motion.times[frame]), this.y(this.value(frame, column)));
      }
      c.stroke();
    });
    this.ink = style('--ink');
    this.colours = this.quantity.columns.map((column, i) => style(`--c${i}`));
  }

  draw(frame) {
    if (this.canvas.width === 0 || this.canvas.height === 0) return;  // in a frame that has no size yet
    const c = this.canvas.getContext('2d');
    c.save();
    c.resetTransform();  // to pixels
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.drawImage(this.background, 0, 0);
    c.restore();
    const x = this.x(motion.times[frame]);
    c.strokeStyle = this.ink;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(x, this.top);
    c.lineTo(x, this.bottom);
    c.stroke();
    this.quantity.columns.forEach((column, i) => {
      const value = this.value(frame, column);
      c.fillStyle = this.colours[i];
      c.beginPath();
      if (!Number.isNaN(value)) c.arc(x, this.y(value), 4, 0, 2 * Math.PI);
      c.fill();
      const label = this.quantity.columns.length > 1 ? `${'xyz'[i]} ` : '';
      this.readings[i].textContent = label + digits(value);
    });
  }
}
