// Reads a replay's data: see reports/replay/pose_tracks.h for the packing.
'use strict';
const FirnReplayData = (() => {
  const CHANNELS = 7, ABSENT = -32768, MICRO = 1e-6;

  const inflated = async (base64) => {
    if (typeof DecompressionStream === 'undefined') {
      throw new Error('This browser cannot unpack the replay (DecompressionStream is missing); ' +
                      'Chromium 80, Firefox 113 and Safari 16.4 can.');
    }
    const text = atob(base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  // [frame][body][channel], so that what a picture needs lies together.
  const unpacked = (bytes, bodies, frames) => {
    const count = CHANNELS * bodies * frames;
    if (bytes.length !== 2 * count) throw new Error('The data of the replay are damaged.');
    const out = new Int16Array(count);
    let at = 0;
    for (let channel = 0; channel < CHANNELS; ++channel) {
      for (let body = 0; body < bodies; ++body) {
        let value = 0;
        for (let frame = 0; frame < frames; ++frame, ++at) {
          const folded = bytes[at] | bytes[count + at] << 8;
          value += folded >> 1 ^ -(folded & 1);
          out[(frame * bodies + body) * CHANNELS + channel] = value;
          value = out[(frame * bodies + body) * CHANNELS + channel];  // modulo 2^16
        }
      }
    }
    return out;
  };

  const seconds = (list) => list.map((t) => t === null ? NaN : t * MICRO);

  const read = async (element) => {
    const bytes = await inflated(element.textContent.trim());
    const length = new DataView(bytes.buffer).getUint32(0, true);
    const facts = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    facts.time = seconds(facts.time);
    facts.came = seconds(facts.came);
    facts.left = seconds(facts.left);
    for (const sensor of facts.sensors) sensor.time = seconds(sensor.time);
    for (const stage of facts.stages) stage.start *= MICRO;
    for (const bond of facts.bonds) {
      bond.broken = bond.broken === null ? Infinity : bond.broken * MICRO;
      if (bond.end) bond.end = bond.end.map((v) => v * MICRO);
    }
    const parts = facts.shapes.flatMap((shape) => shape.parts || []);
    for (const mesh of [...facts.shapes, ...facts.boundaries, ...facts.maps, ...parts]) {
      mesh.vertices = Float32Array.from(mesh.vertices, (v) => v * MICRO);
    }
    const poses = unpacked(bytes.subarray(4 + length), facts.bodies, facts.time.length);
    return new Replay(facts, poses);
  };

  class Replay {
    constructor(facts, poses) {
      Object.assign(this, facts);
      this.poses = poses;
      this.step = [0, 1, 2].map((k) => (this.high[k] - this.low[k]) / 65534);
    }
    get start() { return this.time[0]; }
    get end() { return this.time[this.time.length - 1]; }

    // The last frame at or before a time.
    frameAt(t) {
      let low = 0, high = this.time.length - 1;
      while (low < high) {
        const middle = low + high + 1 >> 1;
        if (this.time[middle] <= t) low = middle; else high = middle - 1;
      }
      return low;
    }
    present(frame, body) { return this.poses[(frame * this.bodies + body) * CHANNELS] !== ABSENT; }
    // World position in m into out[at ...].
    position(frame, body, out, at = 0) {
      const i = (frame * this.bodies + body) * CHANNELS;
      for (let k = 0; k < 3; ++k) out[at + k] = this.low[k] + (this.poses[i + k] + 32767) * this.step[k];
    }
    // Not yet normalized: x y z w.
    orientation(frame, body, out) {
      const i = (frame * this.bodies + body) * CHANNELS;
      for (let k = 0; k < 3; ++k) out[k] = this.poses[i + 4 + k];
      out[3] = this.poses[i + 3];
    }
    // Pose at a time: position and unit quaternion (x y z w) between two frames. False: not there.
    pose(t, frame, body, position, quaternion) {
      if (!this.present(frame, body)) return false;
      this.position(frame, body, position);
      this.orientation(frame, body, quaternion);
      const next = frame + 1;
      if (next < this.time.length && this.present(next, body)) {
        const f = (t - this.time[frame]) / (this.time[next] - this.time[frame]);
        this.position(next, body, p1);
        this.orientation(next, body, q1);
        for (let k = 0; k < 3; ++k) position[k] += f * (p1[k] - position[k]);
        slerp(quaternion, q1, f);
      } else {
        slerp(quaternion, quaternion, 0);
      }
      return true;
    }
    // m/s, mean over the interval between two frames around (NaN: not there).
    speed(frame, body) {
      const next = frame + 1 < this.time.length && this.present(frame + 1, body) ? frame + 1 : frame;
      const before = next === frame ? frame - 1 : frame;
      if (before < 0 || !this.present(frame, body) || !this.present(before, body)) return NaN;
      this.position(before, body, p0);
      this.position(next, body, p1);
      return Math.hypot(p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]) / (this.time[next] - this.time[before]);
    }
  }
  const p0 = [0, 0, 0], p1 = [0, 0, 0], q1 = [0, 0, 0, 0];

  // a becomes what lies between a and b, normalized.
  const slerp = (a, b, f) => {
    const na = Math.hypot(...a), nb = Math.hypot(...b);
    let cosine = 0;
    for (let k = 0; k < 4; ++k) cosine += a[k] * b[k] / (na * nb);
    const side = cosine < 0 ? -1 : 1, angle = Math.acos(Math.min(1, Math.abs(cosine)));
    const near = angle < 1e-3;
    const wa = near ? 1 - f : Math.sin((1 - f) * angle) / Math.sin(angle);
    const wb = near ? f : Math.sin(f * angle) / Math.sin(angle);
    for (let k = 0; k < 4; ++k) a[k] = wa * a[k] / na + side * wb * b[k] / nb;
    const n = Math.hypot(...a);
    for (let k = 0; k < 4; ++k) a[k] /= n;
  };

  return {read};
})();
