// The side panel: what is known of one object, and why its shape won.
function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function row(table, name, value) {
  const line = table.insertRow();
  line.append(element('th', name), element('td', value));
}

const percent = (share) => `${Math.round(100 * share)} %`;

function candidateItem(object, candidate, index) {
  const item = element('li', undefined, candidate.chosen ? 'chosen' : '');
  // The thumbnail stands in the page once; the panel borrows its data.
  const picture = document.getElementById(`candidate-${object.index}-${index}`);
  if (picture) {
    const copy = element('img');
    copy.src = picture.src;
    copy.alt = '';
    item.append(copy);
  }
  const text = element('div');
  text.append(element('b', candidate.score.toFixed(3)), ` ${candidate.model}`, element('br'),
              element('span', `${candidate.source}; depth on model ${percent(candidate.surface)}, ` +
                              `model seen ${percent(candidate.coverage)}, ` +
                              `through solid ${percent(candidate.free)}`, 'quiet'));
  item.append(text);
  return item;
}

export function describeObject(object) {
  const table = element('table');
  row(table, 'class', object.class);
  row(table, 'confidence', object.confidence.toFixed(2));
  row(table, 'size', `${object.size_m.map((side) => side.toFixed(2)).join(' x ')} m (front, side, height)`);
  row(table, 'views', String(object.views));
  row(table, 'shape from', object.source);
  if (object.note) row(table, 'notes', object.note);
  if (object.credit) row(table, 'model by', object.credit);
  const parts = [element('h3', object.name), table];
  if (object.why) parts.push(element('p', object.why));
  if (object.candidates.length) {
    const list = element('ol', undefined, 'viewer-candidates');
    object.candidates.forEach((candidate, index) => list.append(candidateItem(object, candidate, index)));
    parts.push(element('h4', 'Candidates, best first'), list);
  }
  return parts;
}
