// Sorts and copies tables, copies commands, opens folds for the printer. The page is readable without it.
'use strict';
(() => {
  const button = (text, label, act) => {
    const b = document.createElement('button');
    b.type = 'button';
    b.className = 'small';
    b.textContent = text;
    b.setAttribute('aria-label', label);
    b.addEventListener('click', () => act(b));
    return b;
  };

  // Pages opened from a file may not have the clipboard's newer interface.
  const copy = async (text, b) => {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      const area = document.createElement('textarea');
      area.value = text;
      document.body.append(area);
      area.select();
      document.execCommand('copy');
      area.remove();
    }
    const old = b.textContent;
    b.textContent = 'Copied';
    setTimeout(() => { b.textContent = old; }, 1500);
  };

  const order = (cell) => 'v' in cell.dataset ? Number(cell.dataset.v) : cell.textContent.trim();
  const compare = (a, b) => {
    const numbers = typeof a === 'number' && typeof b === 'number';
    if (numbers) return a - b;
    if (typeof a !== typeof b) return typeof a === 'number' ? -1 : 1;  // numbers before words
    return a.localeCompare(b, 'en', {numeric: true});
  };

  const sortBy = (table, column) => {
    const head = table.tHead.rows[0].cells[column];
    const down = head.getAttribute('aria-sort') === 'ascending';
    for (const th of table.tHead.rows[0].cells) th.removeAttribute('aria-sort');
    head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row, i) => ({row, i, key: order(row.cells[column])}));
    rows.sort((a, b) => (down ? -1 : 1) * compare(a.key, b.key) || a.i - b.i);
    body.append(...rows.map((r) => r.row));
  };

  // Full digits; an uncertainty gets a separate column.
  const tsv = (table) => {
    const heads = [...table.tHead.rows[0].cells], rows = [...table.tBodies[0].rows];
    const clean = (text) => text.replace(/\s+/g, ' ').trim();
    const unsure = heads.map((_, i) => rows.some((r) => 'u' in r.cells[i].dataset));
    const lines = [heads.flatMap((th, i) => {
      const title = clean((th.querySelector('button') || th).firstChild.textContent);
      const unit = th.dataset.unit ? ` [${th.dataset.unit}]` : '';
      return unsure[i] ? [title + unit, `${title} standard deviation${unit}`] : [title + unit];
    })];
    for (const row of rows) {
      lines.push([...row.cells].flatMap((cell, i) => {
        const value = 'v' in cell.dataset ? cell.dataset.v : clean(cell.textContent);
        return unsure[i] ? [value, cell.dataset.u || ''] : [value];
      }));
    }
    return lines.map((l) => l.join('\t')).join('\n') + '\n';
  };

  for (const table of document.querySelectorAll('.table > table')) {
    [...table.tHead.rows[0].cells].forEach((th, column) => {
      const b = document.createElement('button');
      b.type = 'button';
      b.title = 'Sort';
      b.append(...th.childNodes);
      b.addEventListener('click', () => sortBy(table, column));
      th.append(b);
    });
    const holder = table.parentElement;
    holder.tabIndex = 0;  // so that the keyboard can scroll it
    holder.setAttribute('role', 'region');
    holder.setAttribute('aria-label', table.getAttribute('aria-label') || 'table');
    const tools = document.createElement('div');
    tools.className = 'tabletools';
    tools.append(button('Copy table', 'Copy this table as tab-separated values',
                        (b) => copy(tsv(table), b)));
    const caption = holder.previousElementSibling;
    holder.before(tools);
    if (caption && caption.className === 'tablecaption') tools.prepend(caption);
  }
  for (const code of document.querySelectorAll('.code')) {
    code.append(button('Copy', 'Copy these commands',
                       (b) => copy(code.querySelector('pre').textContent, b)));
  }

  let closed = [];
  addEventListener('beforeprint', () => {
    closed = [...document.querySelectorAll('details:not([open])')];
    for (const d of closed) d.open = true;
  });
  addEventListener('afterprint', () => { for (const d of closed) d.open = false; });
})();
