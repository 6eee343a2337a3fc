// What the parts of a replay share: elements, numbers, colors of particles.
'use strict';
const FirnReplayColors = (() => {
  // Elements by one call: text children are plain, functions among the attributes are listeners.
  const make = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) {
      if (typeof value === 'function') element.addEventListener(key, value);
      else if (value !== false) element.setAttribute(key, value);
    }
    element.append(...children);
    return element;
  };
  const round = (value, digits = 3) => Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : 'none';
  const clamp = (value, low, high) => Math.max(low, Math.min(high, value));

  // viridis (van der Walt and Smith 2015) but for its darkest end: ascending in lightness, safe for
  // color-blind readers.
  const SCALE = [[70, 50, 127], [54, 92, 141], [39, 127, 142], [31, 161, 135], [74, 194, 109], [159, 218, 58],
                 [253, 231, 37]].map((c) => c.map((v) => v / 255));
  // Okabe and Ito's, for a few kinds, in the order of hues that plots have; black is dark gray.
  const KINDS = ['#56b4e9', '#e69f00', '#009e73', '#cc79a7', '#f0e442', '#0072b2', '#d55e00', '#444444'];
  // Boundaries are dull, so that the ice stands out.
  const WALLS = ['#8c9bad', '#b3a48f', '#93a792', '#a993a8', '#a9a58c', '#8fa5a8', '#b09a94', '#9a9a9a'];
  const GRAY = [0.62, 0.66, 0.7];
  const onScale = (share, out, at) => {
    const x = clamp(share, 0, 1) * (SCALE.length - 1), i = Math.min(Math.floor(x), SCALE.length - 2);
    for (let k = 0; k < 3; ++k) out[at + k] = SCALE[i][k] + (x - i) * (SCALE[i + 1][k] - SCALE[i][k]);
  };
  const css = (c) => `rgb(${c.map((v) => Math.round(255 * v)).join(' ')})`;
  const hex = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
  const SCALE_CSS = `linear-gradient(to right, ${SCALE.map(css).join(', ')})`;

  // Whole numbers that mark kinds: few get a color each, many a scale.
  const kinds = (name, values, none, words = []) => {
    const known = [...new Set(values)].filter((v) => v !== none).sort((a, b) => a - b);
    if (known.length <= KINDS.length) {
      const colors = new Map(known.map((v, i) => [v, hex(KINDS[i])]));
      return {
        name, swatches: known.map((v, i) => [KINDS[i], words[v] || String(v)]),
        write: (id, t, frame, out, at) => out.set(colors.get(values[id]) || GRAY, at),
      };
    }
    return scale(name, '', known[0], known[known.length - 1], (id) => values[id] === none ? NaN : values[id]);
  };
  const scale = (name, unit, low, high, value) => ({
    name, unit, low, high, write: (id, t, frame, out, at) => {
      const v = value(id, t, frame);
      if (Number.isNaN(v)) out.set(GRAY, at);
      else onScale(high > low ? (v - low) / (high - low) : 0, out, at);
    },
    at: (share) => low + share * (high - low),
  });
  // Three powers of ten: slow and fast particles both differ in color from particles at rest.
  const logScale = (name, unit, high, value) => {
    const decades = 3, low = high / 10 ** decades;
    return {
      name, unit, low, high, under: true, write: (id, t, frame, out, at) => {
        const v = value(id, t, frame);
        if (Number.isNaN(v)) out.set(GRAY, at);
        else onScale(v > low ? Math.log10(v / low) / decades : 0, out, at);
      },
      at: (share) => low * 10 ** (decades * share),
    };
  };

  const modesOf = (r) => {
    const inside = (id, t) => t - r.came[id];
    let longest = 0;
    const speeds = [];
    for (let i = 0; i < r.particles; ++i) {
      longest = Math.max(longest, (Number.isNaN(r.left[i]) ? r.end : r.left[i]) - r.came[i] || 0);
    }
    const every = Math.ceil(r.time.length * r.particles / 2e5);
    for (let n = 0; n < r.time.length * r.particles; n += every) {
      const speed = r.speed(Math.floor(n / r.particles), n % r.particles);
      if (speed > 0) speeds.push(speed);
    }
    speeds.sort((a, b) => a - b);
    // Falling bodies would leave all others one color.
    const fast = speeds.length ? speeds[Math.floor(0.95 * (speeds.length - 1))] : 1;
    return {
      batch: kinds('batch', r.batch, -1),
      tag: kinds('tag', r.tag, null),
      time: scale('time inside', 's', 0, longest, inside),
      shape: kinds('shape', r.shape, null, r.shapes.map((shape) => shape.name)),
      speed: Object.assign(logScale('speed', 'm/s', fast, (id, t, frame) => r.speed(frame, id)), {over: true}),
      force: scale('largest contact force of the run', 'N', 0, Math.max(0, ...r.peak_force),
                   (id) => r.peak_force[id]),
    };
  };

  return {make, round, clamp, onScale, SCALE_CSS, WALLS, modesOf};
})();
