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

// A wall, an opening, a floor or a ceiling, by the extras of its node.
export function describePart(name, extras) {
  const table = element('table');
  const metres = (value) => `${value.toFixed(2)} m`;
  if (extras.length_m !== undefined) row(table, 'length', metres(extras.length_m));
  if (extras.width_m !== undefined) row(table, 'width', metres(extras.width_m));
  if (extras.area_m2 !== undefined) row(table, 'area', `${extras.area_m2.toFixed(1)} m²`);
  if (extras.height_m !== undefined) row(table, extras.area_m2 === undefined ? 'height' : 'at', metres(extras.height_m));
  if (extras.rooms && extras.rooms.length) row(table, 'room', extras.rooms.map((room) => `Room ${room}`).join(', '));
  if (extras.wall !== undefined) row(table, 'in', `wall ${extras.wall}`);
  if (extras.seen_share !== undefined) row(table, 'seen', percent(extras.seen_share));
  if (extras.confidence !== undefined) row(table, 'confidence', extras.confidence.toFixed(2));
  return [element('h3', name), table];
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
