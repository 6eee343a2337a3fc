// Follows the server that this page comes from: a newer version is loaded in place of this one.
'use strict';
(() => {
  const root = document.getElementById('live'), version = Number(root.dataset.version), key = 'firn-view-scroll';
  const say = (text) => {
    root.textContent = text;
    root.hidden = !text;
  };

  const kept = sessionStorage.getItem(key);
  if (kept !== null) requestAnimationFrame(() => scrollTo(0, Number(kept)));
  sessionStorage.removeItem(key);

  const load = () => {
    sessionStorage.setItem(key, scrollY);
    const [state] = typeof FirnReplayViews === 'undefined' ? [] : FirnReplayViews.states();
    if (state) history.replaceState(null, '', `#${state}&stay=1`);
    location.reload();
  };

  let failures = 0;
  const ask = async () => {
    try {
      const answer = await fetch('version', {cache: 'no-store'});
      if (!answer.ok) throw new Error(answer.statusText);
      const now = await answer.json();
      failures = 0;
      if (now.version !== version) return load();
      say(now.busy ? 'A change is being read \u2026' : '');
    } catch {
      if (++failures === 3) say('firn view has ended: start it again to follow changes.');
      if (failures >= 3) return setTimeout(ask, 2000);
    }
    return setTimeout(ask, 300);
  };
  ask();
})();
