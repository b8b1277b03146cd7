// A mesh by a few hundred faces: vertices that share a cell of a grid become their mean (Rossignac and Borrel 1993).
import * as THREE from 'three';

const CELLS = 12;  // along the longest side

export function coarseGeometry(geometry) {
  geometry.computeBoundingBox();
  const {min, max} = geometry.boundingBox;
  const cell = Math.max(1e-6, max.x - min.x, max.y - min.y, max.z - min.z) / CELLS;
  const positions = geometry.attributes.position;
  const colours = geometry.attributes.color;
  const clusters = new Map();
  const clusterOf = [];
  for (let v = 0; v < positions.count; ++v) {
    const place = [positions.getX(v), positions.getY(v), positions.getZ(v)];
    const key = ['x', 'y', 'z'].map((axis, c) => Math.floor((place[c] - min[axis]) / cell)).join();
    if (!clusters.has(key)) clusters.set(key, {index: clusters.size, count: 0, sum: [0, 0, 0, 0, 0, 0]});
    const cluster = clusters.get(key);
    const colour = colours ? [colours.getX(v), colours.getY(v), colours.getZ(v)] : [0, 0, 0];
    [...place, ...colour].forEach((value, c) => { cluster.sum[c] += value; });
    ++cluster.count;
    clusterOf.push(cluster.index);
  }
  const faces = new Map();  // by their corners in turn from the least, so that none is there twice
  for (let i = 0; i + 2 < geometry.index.count; i += 3) {
    const [a, b, c] = [0, 1, 2].map((n) => clusterOf[geometry.index.getX(i + n)]);
    if (a === b || b === c || c === a) continue;
    const face = a < b && a < c ? [a, b, c] : b < c ? [b, c, a] : [c, a, b];
    faces.set(face.join(), face);
  }
  const made = new THREE.BufferGeometry();
  const means = [...clusters.values()].map(({sum, count}) => sum.map((value) => value / count));
  made.setAttribute('position', new THREE.Float32BufferAttribute(means.flatMap((mean) => mean.slice(0, 3)), 3));
  if (colours) made.setAttribute('color', new THREE.Float32BufferAttribute(means.flatMap((mean) => mean.slice(3)), 3));
  made.setIndex([...faces.values()].flat());
  made.computeVertexNormals();
  return made;
}
