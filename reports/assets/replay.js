// The replay's controls: time, colors, boundaries, particles, links to a state.
'use strict';
const FirnReplay = (() => {
  const {make, round, clamp, SCALE_CSS, modesOf} = FirnReplayColors;

  class Player {
    // `name`: name of this replay in links, for pages with several replays.
    constructor(root, replay, name) {
      this.root = root;
      this.r = replay;
      this.name = name;
      this.listeners = new AbortController();  // removes the event listeners outside the root
      this.t = replay.start;
      this.playing = false;
      this.modes = modesOf(replay);
      this.chosen = -1;  // boundary
      this.mode = ['batch', 'tag', 'shape'].find((key) => !this.modes[key].swatches || this.modes[key].swatches.length > 1) ||
          'tag';
      // Pixels of the picture for each pixel of the page, while paused and while playing.
      this.pixelRatio = this.playingPixelRatio = Math.min(2, devicePixelRatio || 1);
      this.build();
      this.view = new FirnReplayScene.Scene(this.canvas, replay);
      if (!replay.setup) this.t = this.view.stillTime();
      this.playFromStart = this.t > replay.start;  // until a time is chosen
      if (this.view.slow) [this.pixelRatio, this.playingPixelRatio] = [1, 0.75];
      this.listBoundaries();
      this.listMarkers();
      this.maps = new FirnReplayMaps.Maps(replay, this.view, () => this.ask(), (b, wanted) => this.want(b, wanted));
      if (this.maps.there) this.boundaryList.parentElement.after(this.maps.panel);
      this.bindInput();
      matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.ask(), {signal: this.listeners.signal});
      // At once, before the browser paints: it would stretch the old picture for a frame.
      this.resized = new ResizeObserver(() => this.draw());
      this.resized.observe(this.canvas);
      this.setMode(this.mode);
      this.draw();
    }

    // Empties the root and releases the WebGL context.
    dispose() {
      this.stop();
      this.listeners.abort();
      this.resized.disconnect();
      this.view.dispose();
      for (const part of this.parts) part.remove();
    }

    build() {
      const r = this.r, length = r.end - r.start;
      const few = r.particles === 1 ? '1 particle' : `${r.particles} particles`;
      this.canvas = make('canvas', {tabindex: '0', role: 'application', 'aria-describedby': `${this.root.id}-hint`,
          'aria-label': `Three-dimensional replay: ${few}, ${r.boundaries.length} boundaries, ` +
              `${round(r.start)} to ${round(r.end)} s`});
      this.play = make('button', {type: 'button', click: () => this.toggle()}, 'Play');
      this.scrub = make('input', {type: 'range', min: r.start, max: r.end, step: 'any', value: r.start,
          'aria-label': 'Time', input: () => { this.stop(); this.seek(Number(this.scrub.value)); }});
      this.clock = make('output', {class: 'replay-clock'});
      const speeds = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
      const wanted = clamp(length / 8, 0, 1);
      const usual = speeds.reduce((a, b) => Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted)) ? b : a, 1);
      this.speed = make('select', {}, ...speeds.map((s) => make('option', {value: s, selected: s === usual && ''},
          s === 1 ? 'as it is' : s < 1 ? `${round(1 / s)} times slower` : `${s} times faster`)));
      const step = (label, by, text) =>
          make('button', {type: 'button', 'aria-label': label, title: label, click: () => this.step(by)}, text);
      const bar = make('div', {class: 'replay-bar'}, this.play, step('One frame back', -1, '\u25c2'),
          step('One frame on', 1, '\u25b8'), this.scrub, this.clock, make('label', {}, 'Speed ', this.speed));

      this.color = make('select', {change: () => this.setMode(this.color.value)},
          ...Object.entries(this.modes).map(([key, mode]) => make('option', {value: key}, mode.name)));
      this.legend = make('div', {class: 'replay-legend'});
      this.opacity = make('input', {type: 'range', min: '0.05', max: '1', step: '0.05', value: '0.25',
          input: () => { this.view.setOpacity(Number(this.opacity.value)); this.ask(); }});
      this.labels = make('div', {class: 'replay-labels', 'aria-hidden': 'true'});
      this.boundaryList = make('div', {class: 'replay-list'});
      this.boundaryHere = make('output', {class: 'replay-here'});
      this.names = make('input', {type: 'checkbox', change: () => this.ask()});
      this.particleInput = make('input', {type: 'number', min: '0', max: r.particles - 1, step: '1',
          change: () => this.select(this.particleInput.value === '' ? -1 : Number(this.particleInput.value))});
      this.facts = make('dl', {'aria-live': 'polite'});
      const act = (text, does) => make('button', {type: 'button', click: does}, text);
      const side = make('div', {class: 'replay-side'},
          make('fieldset', {class: 'replay-colors'}, make('legend', {}, 'Colors'), make('label', {}, 'by ', this.color), this.legend),
          make('fieldset', {}, make('legend', {}, 'Boundaries'), this.boundaryList,
               this.boundaryHere, make('label', {class: 'replay-names'}, this.names, ' names in the picture'),
               make('label', {class: 'replay-opacity'}, 'opacity ', this.opacity)),
          make('fieldset', {}, make('legend', {}, 'One particle'),
               make('label', {}, 'number ', this.particleInput), this.facts),
          make('div', {class: 'replay-actions'}, act('Whole scene', () => { this.view.frame(); this.ask(); }),
               act('Copy a link to this view', (event) => this.copyLink(event.target))));
      const hint = make('p', {class: 'replay-hint', id: `${this.root.id}-hint`},
          matchMedia('(pointer: coarse)').matches
              ? 'Tap the picture, then turn it with one finger, move it with two, pinch to come near; tap a particle ' +
                'for its facts and its path, a boundary for its name. Tap outside the picture to scroll over it again. '
              : 'Drag to turn, with Shift or two fingers to move; wheel (after a click) or pinch to come near; click ' +
                'a particle for its facts and its path, a boundary for its name. ',
          'Keys: arrows turn, with Shift they move, + and \u2212 zoom, space ' +
          'plays, comma and full stop step, N shows the names of boundaries, Home the whole scene.');
      this.parts = [make('div', {class: 'replay-stage'}, this.canvas, this.labels), bar, side, hint];
      this.root.append(...this.parts);
    }

    listBoundaries() {
      this.boxes = this.view.boundaries.map((boundary, b) => {
        const box = make('input', {type: 'checkbox', checked: '',
            change: () => this.want(b, box.checked)});
        const on = () => this.highlight(b), off = () => this.highlight(this.chosen);
        this.boundaryList.append(make('label', {mouseenter: on, mouseleave: off, focusin: on, focusout: off}, box,
            make('span', {class: 'replay-swatch', style: `background: ${boundary.color}`}), ' ', this.r.boundaries[b].name));
        return box;
      });
      if (this.boxes.length) return;
      this.boundaryList.append('none');
      this.names.parentElement.hidden = true;
    }

    // A boundary in the picture and in the list, while it is pointed at or has the focus; -1: none.
    highlight(b) {
      this.view.highlight(b);
      this.boxes.forEach((box, i) => box.parentElement.classList.toggle('replay-strong', i === b));
      this.ask();
    }
    // The same until another one is chosen.
    choose(b) {
      this.chosen = b;
      this.boundaryHere.value = b < 0 ? '' : `Here: ${this.r.boundaries[b].name}`;
      this.highlight(b);
    }
    boundaryLabels() {
      return this.r.boundaries
          .map(({name}, b) => ({text: name, at: this.view.middleOf(b), strong: b === this.view.highlighted}))
          .filter(({at, strong}) => at && (strong || this.names.checked));
    }

    // Lists fills, inlets, sensors, outlets and axes by kind. Shown ones have labels in the picture.
    listMarkers() {
      const markers = this.view.markers, panel = make('fieldset', {class: 'replay-marks'},
          make('legend', {}, 'Setup')), list = make('div', {class: 'replay-list'});
      this.markBoxes = new Map();
      for (const [kind, {color, count}] of markers.kinds) {
        const box = make('input', {type: 'checkbox', change: () => { markers.show(kind, box.checked); this.ask(); }});
        box.checked = Boolean(this.r.setup);
        markers.show(kind, box.checked);
        this.markBoxes.set(kind, box);
        list.append(make('label', {}, box, make('span', {class: 'replay-swatch', style: `background: ${color}`}),
            ` ${kind} (${count})`));
      }
      if (this.view.hasParts) {
        const box = make('input', {type: 'checkbox', change: () => { this.view.showParts(box.checked); this.ask(); }});
        this.partsBox = box;
        list.append(make('label', {}, box, ' contact parts, drawn apart'));
      }
      if (!list.childNodes.length) return;
      panel.append(list);
      this.boundaryList.parentElement.after(panel);
    }

    want(b, wanted) {
      const boundary = this.view.boundaries[b];
      boundary.wanted = this.boxes[b].checked = wanted;
      boundary.mesh.visible = wanted;  // the next picture sets it again
      this.ask();
    }

    setMode(key) {
      this.mode = key;
      this.color.value = key;
      const mode = this.modes[key];
      this.legend.replaceChildren();
      if (mode.swatches) {
        // One kind needs no legend.
        for (const [color, text] of mode.swatches.length > 1 ? mode.swatches : []) {
          this.legend.append(make('span', {class: 'replay-kind'},
              make('span', {class: 'replay-swatch', style: `background: ${color}`}), ' ', text));
        }
      } else if (!(mode.high > mode.low)) {
        this.legend.append(`the same for all: ${round(mode.low)}${mode.unit ? ` ${mode.unit}` : ''}`);
      } else {
        const unit = mode.unit ? ` ${mode.unit}` : '';
        this.legend.append(make('div', {class: 'replay-scale', style: `background: ${SCALE_CSS}`}),
            make('div', {class: 'replay-numbers'}, ...[0, 0.5, 1].map((share) => make('span', {},
                (share === 1 && mode.over ? '\u2265 ' : share === 0 && mode.under ? '\u2264 ' : '') + round(mode.at(share)) +
                (share === 1 ? unit : '')))));
      }
      this.ask();
    }

    // Time
    toggle() { if (this.playing) this.stop(); else this.start(); }
    start() {
      if (this.playFromStart || this.t >= this.r.end) this.t = this.r.start;
      this.playFromStart = false;
      this.playing = true;
      this.play.textContent = 'Pause';
      this.last = 0;
      this.ask();
    }
    stop() {
      this.playing = false;
      this.play.textContent = 'Play';
      this.ask();
    }
    seek(t) {
      this.t = clamp(t, this.r.start, this.r.end);
      this.playFromStart = false;
      this.ask();
    }
    step(by) {
      this.stop();
      const frame = this.r.frameAt(this.t);
      this.seek(this.r.time[clamp(by < 0 && this.t > this.r.time[frame] ? frame : frame + by, 0, this.r.time.length - 1)]);
    }

    // Requests one picture; while the replay plays, one after another.
    ask() {
      if (this.asked || this.listeners.signal.aborted) return;
      this.asked = true;
      requestAnimationFrame((now) => {
        this.asked = false;
        if (this.listeners.signal.aborted) return;
        if (this.playing) this.advance(now);
        this.draw();
        if (this.playing) this.ask();
      });
    }
    advance(now) {
      if (this.last) {
        // Time follows the clock, but does not jump after the page was suspended.
        this.t += Number(this.speed.value) * Math.min(0.5, (now - this.last) / 1000);
        this.spare(now - this.last);
        if (this.t >= this.r.end) {
          this.t = this.r.end;
          this.stop();
        }
      }
      this.last = now;
    }
    // Draws fewer pixels where pictures take long, as on machines without a graphics processor.
    spare(milliseconds) {
      this.pace = 0.9 * (this.pace || 16) + 0.1 * milliseconds;
      if (this.pace > 45 && this.playingPixelRatio > 0.5) {
        this.playingPixelRatio = Math.max(0.5, 0.75 * this.playingPixelRatio);
        this.pace = 25;
      }
    }
    draw() {
      const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
      if (!width || !height) return;
      this.view.show(this.t, this.modes[this.mode].write);
      this.view.render(width, height, this.playing ? this.playingPixelRatio : this.pixelRatio,
                       getComputedStyle(this.root).getPropertyValue('--stage').trim());
      FirnReplayMarkers.placeLabels(this.labels, [...this.boundaryLabels(), ...this.view.markers.labels()],
                                    this.view.camera, width, height);
      const stage = this.r.stages.filter((s) => s.start <= this.t).pop();
      const text = `${this.t.toFixed(this.r.end - this.r.start < 5 ? 3 : 2)} s` + (stage ? ` \u00b7 ${stage.name}` : '');
      if (this.clock.value !== text) this.clock.value = text;
      this.scrub.value = this.t;
      this.scrub.setAttribute('aria-valuetext', text);
      if (this.view.selected >= 0) this.updateSpeed();
      this.root.dataset.shown = this.view.groups.reduce((n, g) => n + g.shown.length, 0);
    }

    // One particle
    select(id) {
      const known = Number.isInteger(id) && id >= 0 && id < this.r.particles ? id : -1;
      this.view.select(known);
      this.particleInput.value = known >= 0 ? known : '';
      this.facts.replaceChildren();
      this.ask();
      if (known < 0) return;
      const r = this.r, addFact = (name, value) => {
        const dd = make('dd', {}, value);
        this.facts.append(make('dt', {}, name), dd);
        return dd;
      };
      addFact('shape', r.shapes[r.shape[id]].name);
      addFact('tag', String(r.tag[id]));
      if (r.batch[id] >= 0) addFact('batch', String(r.batch[id]));
      addFact('inserted at', Number.isNaN(r.came[id]) ? 'not yet' : `${round(r.came[id], 4)} s`);
      for (const sensor of r.sensors) {
        if (!Number.isNaN(sensor.time[id])) addFact(`in "${sensor.name}"`, `${round(sensor.time[id], 4)} s`);
      }
      if (!Number.isNaN(r.left[id])) {
        const by = r.outlet[id] >= 0 ? `, by "${r.outlets[r.outlet[id]]}"` : '';
        addFact('left at', `${round(r.left[id], 4)} s${by}`);
      }
      addFact('largest contact force', `${round(r.peak_force[id])} N`);
      this.speedNow = addFact('speed now', '');
      this.speedNow.setAttribute('aria-live', 'off');
    }
    updateSpeed() {
      const speed = this.r.speed(this.r.frameAt(this.t), this.view.selected);
      this.speedNow.textContent = Number.isNaN(speed) ? 'not there' : `${speed.toFixed(3)} m/s`;
    }

    // Mouse, fingers and keys
    bindInput() {
      const c = this.canvas, down = new Map();
      let moved = 0;
      const spread = () => {
        const [a, b] = [...down.values()];
        return Math.hypot(a.x - b.x, a.y - b.y);
      };
      c.addEventListener('pointerdown', (e) => {
        c.setPointerCapture(e.pointerId);
        down.set(e.pointerId, {x: e.clientX, y: e.clientY});
        moved = down.size > 1 ? Infinity : 0;
      });
      c.addEventListener('pointermove', (e) => {
        const before = down.get(e.pointerId);
        if (!before) return;
        const dx = e.clientX - before.x, dy = e.clientY - before.y, height = c.clientHeight, orbit = this.view.orbit;
        moved += Math.abs(dx) + Math.abs(dy);
        const apart = down.size === 2 ? spread() : 0;
        down.set(e.pointerId, {x: e.clientX, y: e.clientY});
        if (down.size === 2) {
          orbit.pan(0.5 * dx / height, -0.5 * dy / height);
          if (spread() > 0) orbit.zoom(apart / spread());
        } else if (e.shiftKey || e.buttons & 6) {
          orbit.pan(dx / height, -dy / height);
        } else {
          const scrolls = e.pointerType === 'touch' && document.activeElement !== c;  // up and down: replay.css
          orbit.turn(4 * dx / height, scrolls ? 0 : 4 * dy / height);
        }
        this.ask();
      });
      const up = (e) => {
        if (!down.delete(e.pointerId) || e.type !== 'pointerup') return;
        c.focus({preventScroll: true});  // a finger that scrolls the page ends in pointercancel
        if (moved < 5 && e.button === 0) {
          const box = c.getBoundingClientRect();
          this.point(2 * (e.clientX - box.left) / box.width - 1, 1 - 2 * (e.clientY - box.top) / box.height);
        }
      };
      c.addEventListener('pointerup', up);
      c.addEventListener('pointercancel', up);
      c.addEventListener('contextmenu', (e) => e.preventDefault());
      // The wheel scrolls the page until the picture has the focus.
      c.addEventListener('wheel', (e) => {
        if (document.activeElement !== c && !e.ctrlKey) return;
        e.preventDefault();
        this.view.orbit.zoom(Math.exp(clamp(e.deltaY, -100, 100) * 0.002));
        this.ask();
      }, {passive: false});
      c.addEventListener('keydown', (e) => { if (this.key(e)) e.preventDefault(); });
    }
    // Selects the nearest object under the pointer: a triangle of a map, a particle, or nothing.
    point(x, y) {
      const triangle = this.maps.under(x, y);
      if (this.view.shape) {
        if (triangle) this.maps.show(triangle);
        return;
      }
      const {particle, distance} = this.view.pick(x, y);
      if (triangle && triangle.distance < distance) {
        this.maps.show(triangle);
      } else {
        this.select(particle);
        this.choose(particle < 0 ? this.view.pickBoundary(x, y) : -1);
      }
    }
    key(e) {
      const orbit = this.view.orbit, arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
      if (e.ctrlKey || e.altKey || e.metaKey) return false;
      if (arrows[e.key]) {
        const [right, up] = arrows[e.key];
        if (e.shiftKey) orbit.pan(0.05 * right, 0.05 * up); else orbit.turn(0.1 * right, 0.1 * up);
      } else if (e.key === '+' || e.key === '=') orbit.zoom(1 / 1.15);
      else if (e.key === '-') orbit.zoom(1.15);
      else if (e.key === ' ') this.toggle();
      else if (e.key === ',') this.step(-1);
      else if (e.key === '.') this.step(1);
      else if (e.key === 'Home') this.view.frame();
      else if (e.key === 'n' || e.key === 'N') this.names.checked = !this.names.checked;
      else if (e.key === 'Escape') { this.select(-1); this.choose(-1); }
      else return false;
      this.ask();
      return true;
    }

    // Reads the parameters that hash() writes.
    apply(given) {
      const number = (key) => Number(given.get(key));
      if (given.has('t') && Number.isFinite(number('t'))) { this.stop(); this.seek(number('t')); }
      const color = given.get('color') || given.get('colour');  // the word of addresses up to version 0.1
      if (color in this.modes) this.setMode(color);
      if (given.has('hide')) {
        const hidden = given.get('hide').split(',');
        this.view.boundaries.forEach((boundary, b) => {
          boundary.wanted = !hidden.includes(this.r.boundaries[b].name);
          this.boxes[b].checked = boundary.wanted;
        });
      }
      if (given.has('names')) this.names.checked = given.get('names') === '1';
      if (number('opacity') > 0) {
        this.opacity.value = number('opacity');
        this.view.setOpacity(Number(this.opacity.value));
      }
      if (given.has('marks')) {
        const shown = given.get('marks').split(',');
        for (const [kind, box] of this.markBoxes || []) {
          box.checked = shown.includes(kind);
          this.view.markers.show(kind, box.checked);
        }
      }
      if (given.has('parts') && this.partsBox) {
        this.partsBox.checked = given.get('parts') === '1';
        this.view.showParts(this.partsBox.checked);
      }
      if (given.has('particle')) this.select(number('particle'));
      this.maps.apply(given);
      const view = (given.get('view') || '').split(',').map(Number), orbit = this.view.orbit;
      if (view.length === 6 && view.every(Number.isFinite)) {
        [orbit.azimuth, orbit.elevation, orbit.distance] = view;
        orbit.target.set(...view.slice(3));
      }
      // For stills and slides: the picture fills the window.
      this.root.classList.toggle('replay-alone', given.has('still'));
      if (given.has('play')) this.start();
      this.ask();
    }
    // #t=12.5&color=batch&hide=bucket,flap&particle=7&opacity=0.2&map=peak_stress&log=1&shape=cube
    // &alone=1&view=AZIMUTH,ELEVATION,DISTANCE,X,Y,Z, and replay=NAME in front where a page has several
    hash() {
      const o = this.view.orbit, parts = this.name ? {replay: this.name} : {};
      Object.assign(parts, {t: round(this.t, 6), color: this.mode}, this.maps.state());
      const hidden = this.r.boundaries.filter((_, b) => !this.boxes[b].checked).map((b) => b.name);
      if (hidden.length) parts.hide = hidden.join(',');
      if (this.markBoxes && this.markBoxes.size)
        parts.marks = [...this.markBoxes].filter(([, box]) => box.checked).map(([kind]) => kind).join(',');
      if (this.partsBox && this.partsBox.checked) parts.parts = 1;
      if (this.names.checked) parts.names = 1;
      if (this.view.selected >= 0) parts.particle = this.view.selected;
      parts.opacity = round(this.view.opacity);
      parts.view = [o.azimuth, o.elevation, o.distance, o.target.x, o.target.y, o.target.z].map((v) => round(v, 4)).join(',');
      return '#' + new URLSearchParams(parts).toString().replaceAll('%2C', ',');
    }
    async copyLink(button) {
      history.replaceState(null, '', this.hash());
      try {
        await navigator.clipboard.writeText(location.href);
        button.textContent = 'Copied';
      } catch {
        button.textContent = 'The link is in the address bar';
      }
      setTimeout(() => { button.textContent = 'Copy a link to this view'; }, 2000);
    }
  }

  return {Player};
})();
