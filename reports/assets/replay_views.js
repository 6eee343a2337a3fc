// The replays of a page: the only one starts by itself; of several each when it is asked for, so that
// a page opens fast, and no more than a browser has contexts for.
'use strict';
const FirnReplayViews = (() => {
  const {make} = FirnReplayColors;
  const MOST = 3;  // contexts at a time; browsers end the oldest beyond 8 to 16, phones sooner
  const live = [];

  const webgl = () => {
    const context = document.createElement('canvas').getContext('webgl');
    const able = context && context.getExtension('ANGLE_instanced_arrays');
    const end = context && context.getExtension('WEBGL_lose_context');
    if (end) end.loseContext();
    return Boolean(able);
  };

  class View {
    constructor(root, several) {
      this.root = root;
      this.several = several;
      this.source = document.getElementById(root.dataset.source);
      this.message = root.querySelector('.replay-message');
      this.kept = '';  // the state in which it was put away
      if (several) this.offer();
    }

    // A button in place of the replay.
    offer() {
      const megabytes = Math.max(0.1, this.source.textContent.length / 1e6).toFixed(1);
      this.message.hidden = true;
      this.button = make('button', {type: 'button', class: 'replay-open', click: () => this.open()},
          `${this.kept ? 'Show again' : 'Show'} the replay of ${this.root.dataset.title} (${megabytes} MB)`);
      this.root.append(this.button);
      this.root.dataset.ready = 'closed';
    }

    // True once it is there; asked for twice meanwhile, it is made once.
    open() {
      this.opening = this.opening || this.make();
      return this.opening;
    }
    async make() {
      const asked = this.button;
      if (asked) asked.remove();
      this.button = null;
      if (!webgl()) {
        return this.fail('This browser offers no WebGL, which the replay needs: everything else on this page works ' +
                         'without it, and firn export RUN.h5 --to vtk writes the same scene for ParaView.');
      }
      try {
        this.say('The replay is being unpacked \u2026');
        const replay = await FirnReplayData.read(this.source);
        if (!this.several) this.source.remove();
        while (live.length >= MOST) live.shift().putAway();
        this.message.hidden = true;
        this.player = new FirnReplay.Player(this.root, replay, this.several ? this.root.dataset.name : '');
        live.push(this);
        if (this.kept) this.player.apply(new URLSearchParams(this.kept.slice(1)));
        if (asked) this.player.canvas.focus({preventScroll: true});
        this.root.dataset.frames = replay.time.length;
        this.root.dataset.ready = 'yes';
        return true;
      } catch (error) {
        console.error(error);
        return this.fail(error.message);
      }
    }
    putAway() {
      this.kept = this.player.hash();
      this.player.dispose();
      this.player = this.opening = null;
      this.offer();
    }

    say(text) {
      this.message.textContent = text;
      this.message.hidden = false;
    }
    fail(text) {
      this.say(text);
      for (const part of [...this.root.children]) if (part !== this.message) part.remove();
      this.root.dataset.ready = 'no';
      return false;
    }
  }

  const roots = [...document.querySelectorAll('.replay')];
  const views = roots.map((root) => new View(root, roots.length > 1));

  // A state by the address, of the only replay or of the one that it names.
  const fromHash = async () => {
    if (!location.hash.includes('=')) return;
    const given = new URLSearchParams(location.hash.slice(1));
    const view = views.length === 1 ? views[0] : views.find((v) => v.root.dataset.name === given.get('replay'));
    if (!view || !await view.open()) return;
    view.player.apply(given);
    if (!given.has('stay')) (view.several ? view.root : view.root.closest('section')).scrollIntoView();
  };
  addEventListener('hashchange', fromHash);
  if (views.length === 1) views[0].open();
  fromHash();

  // Links to the states of the views that are open, without the '#'. A run at its first or last
  // frame continues at the end of the next version.
  const states = () => live.map((view) => {
    const state = new URLSearchParams(view.player.hash().slice(1));
    const {t, r} = view.player;
    if (!r.setup && (t >= r.end || t === r.start)) state.set('t', '1e9');
    return state.toString();
  });
  return {states};
})();
