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

// The box around all points over the whole motion.
motion.box = () => {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const add = (k, value) => {
    low[k] = Math.min(low[k], value);
    high[k] = Math.max(high[k], value);
  };
  motion.places.forEach((value, i) => add(i % motion.dimension, value));
  for (const p of motion.points) if (p.at) p.at.forEach((value, k) => add(k, value));
  if (motion.dimension === 2) low[2] = high[2] = 0;
  return {low, high};
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
