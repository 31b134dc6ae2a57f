'use strict';
// The data of the page, unpacked: points, links, bodies, and their positions in each frame.
const motion = JSON.parse(document.getElementById('motion').textContent);

// Four letters hold 24 bits: a share of the range of the column, or not finite if all bits are set.
motion.unpack = ({low, span, text}) => {
  const code = new Uint8Array(128);
  [...'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'].forEach((letter, i) => {
    code[letter.charCodeAt(0)] = i;
  });
  const steps = 2 ** 24 - 2;
  const numbers = new Float64Array(text.length / 4);
  for (let i = 0; i < numbers.length; ++i) {
    let bits = 0;
    for (let k = 0; k < 4; ++k) bits = bits * 64 + code[text.charCodeAt(4 * i + k)];
    const column = i % low.length;
    numbers[i] = bits > steps ? NaN : low[column] + span[column] * bits / steps;
  }
  return numbers;
};

motion.frames = motion.times.length;
motion.moving = motion.points.filter(p => !p.at).length;
motion.places = motion.unpack(motion.places);  // frames x moving x dimension
let ways = 0;
motion.directions = motion.directions.map(at => at ? {at} : {column: ways++});
motion.ways = motion.unpack(motion.ways);  // frames x moving directions x dimension
motion.width = motion.values.low.length;
motion.values = motion.unpack(motion.values);  // frames x width

// x, y, z of every point in a frame.
motion.posture = (frame, out = new Float64Array(3 * motion.points.length)) => {
  const {moving, dimension} = motion;
  let from = frame * moving * dimension;
  for (let i = 0; i < moving; ++i) {
    for (let k = 0; k < dimension; ++k) out[3 * i + k] = motion.places[from++];
  }
  for (let i = moving; i < motion.points.length; ++i) out.set(motion.points[i].at, 3 * i);
  return out;
};

// True if an axis never turns.
motion.rests = ([first, second]) => second === undefined ? Boolean(motion.directions[first].at)
                                                         : first >= motion.moving && second >= motion.moving;

// The unit vector of an axis: [direction], or [from, to].
motion.axis = ([first, second], frame, posture) => {
  if (second !== undefined) return unit([0, 1, 2].map(k => posture[3 * second + k] - posture[3 * first + k]));
  const {at, column} = motion.directions[first], {dimension} = motion;
  if (at) return unit(at);
  return unit([0, 1, 2].map(k => k < dimension ? motion.ways[(frame * ways + column) * dimension + k] : 0));
};

// The box around all points and rails over the whole motion, and some of their places.
motion.box = rails => {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], some = [];
  const add = place => place.forEach((value, k) => {
    low[k] = Math.min(low[k], value);
    high[k] = Math.max(high[k], value);
  });
  const few = Math.ceil(motion.frames / 40);
  for (let frame = 0; frame < motion.frames; ++frame) {
    const posture = motion.posture(frame), places = rails.flatMap(rail => railEnds(rail, frame, posture));
    for (let i = 0; i < posture.length; i += 3) places.push(Array.from(posture.subarray(i, i + 3)));
    places.forEach(add);
    if (frame % few === 0 && some.length < 20000) some.push(...places);
  }
  return {low, high, some};
};

// Six digits without trailing zeros.
const digits = (value, count = 6) => {
  if (!Number.isFinite(value)) return '–';
  const short = Number(value.toPrecision(count));
  return Math.abs(short) < 1e6 ? String(short) : short.toExponential();
};

// Rounds up to 1, 2 or 5 times a power of ten.
const roundUp = least => {
  const power = 10 ** Math.floor(Math.log10(least) + 1e-9);
  return [1, 2, 5, 10].map(f => f * power).find(step => step >= least * (1 - 1e-9));
};

// A variable of the page's style, such as a colour.
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Sets the resolution of a canvas to that of the screen, which clears it. Returns its size in the page.
const fitToScreen = (shown, ...canvases) => {
  const ratio = window.devicePixelRatio || 1, {clientWidth, clientHeight} = shown;
  for (const canvas of [shown, ...canvases]) {
    canvas.width = Math.round(clientWidth * ratio);
    canvas.height = Math.round(clientHeight * ratio);
    canvas.getContext('2d').setTransform(ratio, 0, 0, ratio, 0, 0);
  }
  return [clientWidth, clientHeight];
};
