// Time, controls and redrawing.
(() => {
  const element = id => document.getElementById(id);
  const canvas = element('picture'), slider = element('frame'), about = element('about');
  const rails = allRails(), camera = new Camera(motion.box(rails), motion.dimension);
  const picture = new Picture(canvas, camera, rails);
  const last = motion.frames - 1, duration = motion.times[last] - motion.times[0];
  let frame = 0, curves = [], playing = false, clock = 0, before = null, waiting = false, pointer = null;

  // ---- drawing, at most once for each frame of the screen

  function draw() {
    picture.draw(frame);
    for (const c of curves) c.draw(frame);
    tell();
  }

  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  }

  const decimals = last > 0 ? Math.max(0, Math.min(9, Math.ceil(-Math.log10(duration / last) - 1e-9))) : 6;
  const moment = t => last > 0 ? t.toFixed(decimals) : digits(t);

  function show(k) {
    frame = Math.max(0, Math.min(last, k));
    slider.value = frame;
    const text = motion.postures ? motion.postures[frame] : `t = ${moment(motion.times[frame])} s`;
    element('clock').textContent = text;
    slider.setAttribute('aria-valuetext', text);
    redraw();
  }

  // The last frame at or before t.
  function frameAt(t) {
    let low = 0, high = last;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (motion.times[middle] <= t + 1e-9 * duration) low = middle; else high = middle - 1;
    }
    return low;
  }

  function seek(t) {
    pause();
    const k = frameAt(t);
    show(k < last && motion.times[k + 1] - t < t - motion.times[k] ? k + 1 : k);
  }

  // ---- playing

  function speeds() {
    const all = [];
    for (let decade = Math.floor(Math.log10(duration / 200)); all.length < 9; ++decade) {
      for (const f of [1, 2, 5]) {
        const speed = f * 10 ** decade, seconds = duration / speed;
        if (seconds <= 200) all.push(speed);
      }
    }
    const best = all.reduce((a, b) => Math.abs(Math.log(duration / b / 8)) < Math.abs(Math.log(duration / a / 8)) ? b : a);
    for (const speed of all) {
      element('speed').add(new Option(speed === 1 ? 'real time' : `× ${digits(speed)}`, speed, false, speed === best));
    }
  }

  function play() {
    if (last === 0) return;
    playing = true;
    before = null;
    if (frame === last) frame = 0;
    clock = motion.times[frame];
    requestAnimationFrame(tick);
    label();
  }

  function pause() {
    playing = false;
    label();
  }

  function label() {
    element('play').textContent = playing ? '❚❚' : '▶';
    element('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  function tick(now) {
    if (!playing) return;
    if (before !== null) clock += (now - before) / 1000 * Number(element('speed').value);
    before = now;
    // Pauses briefly at the end before it starts again.
    const end = motion.times[last];
    if (clock > end + 0.06 * duration) clock = motion.times[0];
    show(frameAt(Math.min(clock, end)));
    requestAnimationFrame(tick);
  }

  // ---- texts

  function tell() {
    const text = pointer && whoIsAt(picture, pointer.x, pointer.y);
    about.hidden = !text;
    if (!text) return;
    about.textContent = text;
    const room = canvas.clientWidth - about.offsetWidth - 4;
    about.style.left = `${Math.max(4, Math.min(pointer.x + 14, room))}px`;
    about.style.top = `${pointer.y > canvas.clientHeight / 2 ? pointer.y - about.offsetHeight - 12 : pointer.y + 14}px`;
  }

  function legend() {
    const list = element('legend');
    list.replaceChildren();
    const add = (colour, text) => {
      const item = list.appendChild(document.createElement('li'));
      if (colour) item.appendChild(document.createElement('i')).style.background = colour;
      item.append(text);
    };
    const most = 12, byLevel = picture.options.by === 'level', byBody = picture.options.by === 'body';
    const count = byBody ? motion.bodies.length : byLevel ? picture.levels : motion.groups.length;
    const drawn = new Set(motion.points.map(p => p.group));  // some groups have vectors only
    const noun = (n, what) => `${n.toLocaleString('en')} ${what}${n === 1 ? '' : 's'}`;
    if (count > most && byBody) {
      add('', `${noun(count, 'body')}: point at one to see its name.`.replace('bodys', 'bodies'));
    } else if (byBody) {
      motion.bodies.forEach(([name], i) => add(picture.bodyColour[i], name));
    } else if (count > most) {
      add('', `${noun(motion.groups.length, 'group')} in ${noun(picture.levels, 'level')}: point at a joint to see its group.`);
    } else {
      for (let i = 0; i < count; ++i) {
        if (byLevel || drawn.has(i)) add(picture.hue(i, count), byLevel ? `level ${i + 1}` : motion.groups[i][0]);
      }
    }
    if (motion.violated) add(style('--wrong'), 'violated');
    const others = ['driven', 'at rest'].filter(g => drawn.has(g));
    if (others.length > 0 && !byBody) add(picture.ink, others.join(', '));
  }

  // What the symbols in the picture mean.
  function key() {
    const list = element('symbols'), drawn = new Set(motion.joints.map(j => j.symbol));
    list.replaceChildren();
    if (picture.isLarge) return;
    const name = {revolute: 'revolute joint', prismatic: 'slider', cylindrical: 'cylindrical joint',
                  spherical: 'ball joint', universal: 'universal joint', planar: 'planar joint'};
    const ways = {revolute: camera.flat ? [] : [[0.8, 0, 0.6]], cylindrical: [[0.8, 0, 0.6]], prismatic: [[1, 0, 0]],
                  universal: [[0.8, 0.6, 0], [-0.6, 0.8, 0]], planar: [[0.3, 0.6, 0.74]]};
    const add = (symbol, text, fill) => {
      const item = list.appendChild(document.createElement('li')), icon = item.appendChild(document.createElement('canvas'));
      icon.className = 'icon';
      item.append(text);
      fitToScreen(icon);
      const c = icon.getContext('2d');
      c.fillStyle = fill;
      c.strokeStyle = picture.ink;
      c.lineWidth = 1.4;
      symbols[symbol](c, [14, 10], ['planar', 'cylindrical'].includes(symbol) ? 3 : 5, v => v, ...(ways[symbol] ?? []));
    };
    for (const symbol of Object.keys(name).filter(s => drawn.has(s))) add(symbol, name[symbol], picture.paper);
    const driven = motion.joints.find(j => j.driven);
    if (driven) add(driven.symbol, 'driven joint', symbols.motor);
  }

  function panels() {
    const output = element('output').value;
    element('panels').replaceChildren();
    curves = motion.outputs.filter(q => q.of === output).map(q => new Curves(q, element('panels'), seek));
    for (const c of curves) {
      c.resize();
      c.draw(frame);
    }
  }

  // ---- events

  slider.max = last;
  for (const id of ['player', 'speeds']) element(id).hidden = last === 0;
  if (motion.postures) element('speeds').hidden = true;
  element('play').addEventListener('click', () => playing ? pause() : play());
  const step = by => {
    pause();
    show(frame + by);
  };
  element('back').addEventListener('click', () => step(-1));
  element('forward').addEventListener('click', () => step(1));
  slider.addEventListener('input', () => step(Number(slider.value) - frame));
  element('fit').addEventListener('click', () => {
    camera.fit();
    redraw();
  });
  element('colour').addEventListener('change', e => {
    picture.options.by = e.target.value;
    picture.recolour();
    legend();
    redraw();
  });
  if (motion.bodies.length > 1) element('colour').add(new Option('by body', 'body'), 0);
  element('colour').value = picture.options.by;
  for (const option of ['names', 'paths']) {
    element(option).addEventListener('change', e => {
      picture.options[option] = e.target.checked;
      redraw();
    });
  }
  for (const of of new Set(motion.outputs.map(q => q.of))) element('output').add(new Option(of, of));
  element('output').addEventListener('change', panels);
  element('curves').hidden = motion.outputs.length === 0;

  followGestures(canvas, camera, redraw);
  canvas.addEventListener('pointermove', e => {
    pointer = {x: e.offsetX, y: e.offsetY};
    redraw();
  });
  canvas.addEventListener('pointerleave', () => {
    pointer = null;
    redraw();
  });

  const zoom = factor => () => camera.zoomAt(canvas.clientWidth / 2, canvas.clientHeight / 2, factor);
  const keys = {
    ' ': () => playing ? pause() : play(),
    ArrowLeft: e => step(e.shiftKey ? -10 : -1), ArrowRight: e => step(e.shiftKey ? 10 : 1),
    Home: () => step(-frame), End: () => step(last - frame),
    '+': zoom(1.25), '=': zoom(1.25), '-': zoom(0.8), 0: () => camera.fit(), f: () => camera.fit(),
    a: () => camera.turn(0.1, 0), d: () => camera.turn(-0.1, 0), w: () => camera.turn(0, 0.1), s: () => camera.turn(0, -0.1),
  };
  window.addEventListener('keydown', e => {
    const own = e.target.closest?.('select, button, input');  // elements that use the key themselves
    if (e.ctrlKey || e.metaKey || e.altKey || !keys[e.key] || (own && (own !== slider || e.key !== ' '))) return;
    e.preventDefault();
    keys[e.key](e);
    redraw();
  });
  element('keys').textContent = (motion.dimension === 3 ? 'Drag: turn (w a s d); with Shift or two fingers: move. ' : 'Drag: move. ') +
    'Wheel, pinch, + and -: zoom; 0: show all. Space: play; arrows, Home, End: step.';

  // Setting the size of a canvas clears it, so it is redrawn at once, before it appears empty on the screen.
  const resize = () => {
    picture.resize();
    for (const c of curves) c.resize();
    draw();
  };
  new ResizeObserver(resize).observe(canvas);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    picture.recolour();
    legend();
    key();
    resize();
  });

  if (last > 0) speeds();
  const few = motion.points.filter(p => !p.name.includes('.')).length <= 30;
  picture.options.names = element('names').checked = few;
  picture.options.paths = element('paths').checked = picture.traced.length <= 40 && last > 0;
  legend();
  key();
  panels();
  resize();
  show(0);
  if (last > 0 && !motion.postures && !matchMedia('(prefers-reduced-motion: reduce)').matches) play(); else label();
})();
