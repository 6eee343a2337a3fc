// Where boundaries and shapes are hit: fields on triangles, their scales, and values that are pointed at.
'use strict';
const FirnReplayMaps = (() => {
  const {make, round, onScale, SCALE_CSS} = FirnReplayColors;
  const UNTOUCHED = [0.74, 0.76, 0.79];
  const PREFIXES = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, '\u00b5'], [1e-9, 'n']];

  // The prefix is chosen for `reference`, so that all numbers of one scale have the same.
  const prefix = (reference, unit) =>
      unit && PREFIXES.find(([factor]) => Math.abs(reference) >= 0.9995 * factor) || [1, ''];
  const quantity = (value, unit, reference = value) => {
    const [factor, letter] = prefix(reference, unit);
    return round(value / factor) + (unit ? ` ${letter}${unit.replace('^2', '\u00b2')}` : '');
  };

  // From 0, or from the lowest hundredth; to the largest, or to the highest hundredth where a few
  // triangles would leave all others one color.
  const rangeOf = (lists, logarithmic) => {
    const all = Float64Array.from(lists.flatMap((list) => list.filter((v) => v > 0))).sort();
    if (!all.length) return null;
    const at = (share) => all[Math.floor(share * (all.length - 1))], largest = at(1);
    const over = largest > 2 * at(0.99), high = over ? at(0.99) : largest;
    const low = logarithmic ? Math.min(Math.max(at(0.01), 1e-4 * high), 0.1 * high) : 0;
    const share = (v) => logarithmic ? Math.log(v / low) / Math.log(high / low) : v / high;
    const value = (s) => logarithmic ? low * (high / low) ** s : s * high;
    return {share, value, largest, over, under: logarithmic && all[0] < low, touched: all.length};
  };
  const colorsOf = (values, range) => {
    const out = new Float32Array(3 * values.length);
    values.forEach((v, i) => {
      if (v > 0 && range) onScale(range.share(v), out, 3 * i);
      else out.set(UNTOUCHED, 3 * i);
    });
    return out;
  };

  class Maps {
    // `ask` redraws; `want(body, wanted)` shows or hides a boundary.
    constructor(replay, view, ask, want) {
      this.r = replay;
      this.view = view;
      this.ask = ask;
      this.want = want;
      this.shape = -1;  // the scene
      this.key = '';
      this.boundaries = replay.boundaries.map((b, body) => ({...b, body})).filter((b) => b.map);
      this.there = this.boundaries.length + replay.maps.length > 0;
      if (this.there) this.build();
    }

    build() {
      this.what = make('select', {change: () => this.set(Number(this.what.value), null)},
          make('option', {value: -1}, 'the scene'),
          ...this.r.maps.map((m, k) => make('option', {value: k}, `the surface of "${m.name}"`)));
      this.field = make('select', {change: () => this.set(this.shape, this.field.value)});
      this.log = make('input', {type: 'checkbox', change: () => this.set(this.shape, this.key)});
      this.particles = make('input', {type: 'checkbox', checked: '', change: () => this.set(this.shape, this.key)});
      this.legend = make('div', {class: 'replay-legend'});
      this.note = make('p', {class: 'replay-note'});
      this.here = make('output', {class: 'replay-note'});
      this.largest = make('button', {type: 'button', click: () => this.goToLargest()}, 'Go to the largest');
      this.panel = make('fieldset', {class: 'replay-map'}, make('legend', {}, 'Where it is hit'),
          this.r.maps.length ? make('label', {}, 'show ', this.what) : '',
          make('label', {}, 'by ', this.field), make('label', {}, this.log, 'logarithmic'),
          this.boundaries.length ? make('label', {}, this.particles, 'particles, too') : '',
          this.legend, this.note, this.largest, this.here);
      this.set(-1, '');
    }

    // What is colored with one scale: all monitored boundaries, or one shape.
    targets() { return this.shape < 0 ? this.boundaries : [this.r.maps[this.shape]]; }
    fieldsOf(target) { return target.map.fields; }

    // `key` null: the first field of a shape, none of the boundaries.
    set(shape, key) {
      this.shape = this.r.maps[shape] ? shape : -1;
      const targets = this.targets(), fields = targets.length ? this.fieldsOf(targets[0]) : [];
      const none = this.shape < 0 ? [make('option', {value: ''}, 'boundaries as they are')] : [];
      this.field.replaceChildren(...none, ...fields.map((f) => make('option', {value: f.key}, f.name)));
      this.key = fields.some((f) => f.key === key) ? key : this.shape < 0 ? '' : fields[0].key;
      this.field.value = this.key;
      this.what.value = this.shape;
      this.here.value = '';
      this.view.showShape(this.shape);
      this.view.alone = !this.particles.checked;
      this.paint();
      this.updateScale();
      this.ask();
    }

    valuesOf(target) {
      const field = this.fieldsOf(target).find((f) => f.key === this.key);
      return field ? field.values : null;
    }
    paint() {
      const lists = this.targets().map((t) => this.valuesOf(t) || []);
      this.range = this.key ? rangeOf(lists, this.log.checked) : null;
      for (const b of this.boundaries) {
        const values = this.shape < 0 && this.key && this.valuesOf(b);
        this.view.paintBoundary(b.body, values ? colorsOf(values, this.range) : null);
      }
      if (this.shape >= 0) this.view.paintShape(this.shape, colorsOf(lists[0], this.range));
    }

    updateScale() {
      this.legend.replaceChildren();
      this.note.textContent = '';
      this.largest.hidden = !this.range;
      this.panel.classList.toggle('replay-idle', !this.key);
      if (!this.key) return;
      const targets = this.targets(), field = this.fieldsOf(targets[0]).find((f) => f.key === this.key);
      const triangles = targets.reduce((n, t) => n + t.map.fields[0].values.length, 0);
      if (!this.range) {
        this.note.textContent = `None of the ${triangles} triangles was touched in this way.`;
        return;
      }
      const {value, largest, over, under, touched} = this.range, each = field.per_triangle ? ' per triangle' : '';
      const marks = [0, 0.5, 1].map((share) => {
        const sign = share === 1 && over ? '\u2265 ' : share === 0 && under ? '\u2264 ' : '';
        return make('span', {}, sign + quantity(value(share), field.unit, this.log.checked ? value(share) : value(1)));
      });
      this.legend.append(make('div', {class: 'replay-scale', style: `background: ${SCALE_CSS}`}),
          make('div', {class: 'replay-numbers'}, ...marks));
      const where = this.placeOfLargest().target;
      const coarse = targets.filter((t) => t.map.computed > t.map.fields[0].values.length)
          .map((t) => `"${t.name}" is drawn with ${t.map.fields[0].values.length} of ${t.map.computed} triangles`);
      this.note.textContent = `Of the whole run${each}: largest ${quantity(largest, field.unit)}` +
          (targets.length > 1 ? ` on "${where.name}"` : '') + `; ${touched} of ${triangles} triangles touched, ` +
          `the others gray.` + coarse.map((text) => ` ${text}.`).join('') + ' Click or tap one for its value.';
    }

    placeOfLargest() {
      for (const target of this.targets()) {
        const triangle = (this.valuesOf(target) || []).indexOf(this.range.largest);
        if (triangle >= 0) return {target, index: target.body, triangle};
      }
      return null;
    }
    goToLargest() {
      const place = this.placeOfLargest();
      if (this.shape < 0) this.want(place.index, true);
      this.view.face(place.index, place.triangle);
      // Opaque ones in front of it, such as the bucket around an auger, go.
      for (let hit = this.view.probe(0, 0); this.shape < 0 && hit && hit.index !== place.index; hit = this.view.probe(0, 0)) {
        this.want(hit.index, false);
      }
      this.show(place);
      this.ask();
    }

    // What is drawn under a point of the picture (-1 ... 1 each way); null: no map.
    under(x, y) {
      if (!this.there || !this.key) return null;
      return this.view.probe(x, y);
    }
    show({index, triangle}) {
      const target = this.shape < 0 ? this.boundaries.find((b) => b.body === index) : this.r.maps[this.shape];
      const field = this.fieldsOf(target).find((f) => f.key === this.key), value = field.values[triangle];
      this.here.value = `Here, on "${target.name}": ` + (value > 0 ? quantity(value, field.unit) : 'never touched');
    }

    apply(given) {
      if (!this.there) return;
      this.log.checked = given.has('log');
      this.particles.checked = !given.has('alone');
      this.set(this.r.maps.findIndex((m) => m.name === given.get('shape')), given.get('map'));
    }
    state() {
      const parts = {};
      if (!this.there) return parts;
      if (this.shape >= 0) parts.shape = this.r.maps[this.shape].name;
      if (this.key) parts.map = this.key;
      if (this.key && this.log.checked) parts.log = 1;
      if (!this.particles.checked) parts.alone = 1;
      return parts;
    }
  }

  return {Maps};
})();
