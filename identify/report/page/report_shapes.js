'use strict';
// Vectors, normals, and the shapes and colours of what the replay draws.

const add = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => add([0, 0, 0], a, 1 / (Math.hypot(...a) || 1));

// A direction across `axis`.
const across = (axis) => unit(cross(axis, Math.abs(axis[0]) < 0.9 * Math.hypot(...axis) ? [1, 0, 0] : [0, 1, 0]));

// Vertex normals, weighted by area.
function normalsOf(positions, faces) {
  const normals = new Float32Array(positions.length);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1],
      uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1],
      vz = positions[c + 2] - positions[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
  return normals;
}

// Points [distance from the axis, height] of an arc, from one angle to another.
function arcProfile(distance, height, radius, from, to, cells) {
  return Array.from({length: cells + 1}, (_, i) => {
    const angle = from + (to - from) * i / cells;
    return [distance + radius * Math.cos(angle), height + radius * Math.sin(angle)];
  });
}

// A profile turned about an axis, its outer side to the right of its way. A point given twice is a sharp rim.
function revolvedShape(origin, axis, profile) {
  const u = across(axis), v = cross(axis, u), sectors = 36, positions = [], indices = [];
  profile.forEach(([distance, height], ring) => {
    for (let sector = 0; sector <= sectors; ++sector) {
      const turn = 2 * Math.PI * sector / sectors;
      const side = add(add([0, 0, 0], u, Math.cos(turn)), v, Math.sin(turn));
      positions.push(...add(add(origin, axis, height), side, distance));
      if (ring === profile.length - 1 || sector === sectors) continue;
      const i = ring * (sectors + 1) + sector, above = i + sectors + 1;
      indices.push(i, i + 1, above, i + 1, above + 1, above);
    }
  });
  return {positions: Float32Array.from(positions), indices: Int32Array.from(indices)};
}

// With from = to a sphere.
function capsuleShape(from, to, radius) {
  const along = add(to, from, -1), length = Math.hypot(...along);
  return revolvedShape(from, length > 0 ? unit(along) : [0, 0, 1],
    [...arcProfile(0, 0, radius, -Math.PI / 2, 0, 12), ...arcProfile(0, length, radius, 0, Math.PI / 2, 12)]);
}

function cylinderShape({from, to, radius}) {
  const along = add(to, from, -1), length = Math.hypot(...along), rims = [[radius, 0], [radius, length]];
  return revolvedShape(from, unit(along), [[0, 0], rims[0], rims[0], rims[1], rims[1], [0, length]]);
}

function torusShape({center, axis, radius, tube_radius: tube}) {
  return revolvedShape(center, axis, arcProfile(radius, 0, tube, -Math.PI, Math.PI, 24));
}

// The outside from the bottom up, around the rim, and the inside down again.
function bowlShape({center, axis, radius, angle, thickness}) {
  const rim = angle - Math.PI / 2, half = 0.5 * thickness, middle = radius + half;
  return revolvedShape(center, axis, [
    ...arcProfile(0, 0, radius + thickness, -Math.PI / 2, rim, 16),
    ...arcProfile(middle * Math.cos(rim), middle * Math.sin(rim), half, rim, rim + Math.PI, 8),
    ...arcProfile(0, 0, radius, rim, -Math.PI / 2, 16)]);
}

// A box, its edges round with a radius >= 0: eighths of a sphere moved to the corners, with faces between them.
function boxShape({center, axes, size, radius}) {
  const core = size.map((length) => 0.5 * length - radius), cells = radius > 0 ? 6 : 1, positions = [], indices = [];
  const signs = [[1, 1], [-1, 1], [-1, -1], [1, -1]], sectors = 4 * (cells + 1), rings = 2 * (cells + 1);
  const place = (local) => positions.push(...local.reduce((point, value, k) => add(point, axes[k], value), center));
  for (let ring = 0; ring < rings; ++ring) {
    const top = ring > cells ? 1 : -1, height = Math.PI / 2 * ((ring % (cells + 1)) / cells - (top > 0 ? 0 : 1));
    for (let sector = 0; sector < sectors; ++sector) {
      const quadrant = Math.floor(sector / (cells + 1)), [right, far] = signs[quadrant];
      const turn = Math.PI / 2 * (quadrant + (sector % (cells + 1)) / cells), flat = radius * Math.cos(height);
      place([right * core[0] + flat * Math.cos(turn), far * core[1] + flat * Math.sin(turn),
        top * core[2] + radius * Math.sin(height)]);
      if (ring === rings - 1) continue;
      const i = ring * sectors + sector, next = ring * sectors + (sector + 1) % sectors;
      indices.push(i, next, i + sectors, next, next + sectors, i + sectors);
    }
  }
  for (const top of [-1, 1]) {
    const first = positions.length / 3;
    for (const [right, far] of signs) place([right * core[0], far * core[1], 0.5 * top * size[2]]);
    for (const [j, k] of top > 0 ? [[1, 2], [2, 3]] : [[2, 1], [3, 2]]) indices.push(first, first + j, first + k);
  }
  return {positions: Float32Array.from(positions), indices: Int32Array.from(indices)};
}

// What to draw of an obstacle; null of a plane, which has no end.
function obstacleShape(obstacle) {
  switch (obstacle.type) {
    case 'sphere': return capsuleShape(obstacle.center, obstacle.center, obstacle.radius);
    case 'capsule': return capsuleShape(obstacle.from, obstacle.to, obstacle.radius);
    case 'cylinder': return cylinderShape(obstacle);
    case 'torus': return torusShape(obstacle);
    case 'bowl': return bowlShape(obstacle);
    case 'box': return boxShape(obstacle);
    case 'mesh': return obstacle;
    default: return null;
  }
}

// A point of a body at a pose [x, y, z, qx, qy, qz, qw]; without one, where it is.
function posed(point, pose) {
  if (!pose) return point;
  const axis = pose.slice(3, 6), twice = add([0, 0, 0], cross(axis, point), 2);
  return add(add(add(pose.slice(0, 3), point), twice, pose[6]), cross(axis, twice));
}

function posedAll(positions, pose) {
  if (!pose) return positions;
  const made = new Float32Array(positions.length);
  for (let i = 0; i < positions.length; i += 3) made.set(posed([...positions.subarray(i, i + 3)], pose), i);
  return made;
}

// How far an obstacle of one middle reaches from it; null of the others.
function obstacleReach({type, radius, size, thickness, tube_radius: tube}) {
  switch (type) {
    case 'sphere': return radius;
    case 'torus': return radius + tube;
    case 'bowl': return radius + thickness;
    case 'box': return 0.5 * Math.hypot(...size);
    default: return null;
  }
}

// A cone from a disk around `from` to its tip.
function coneShape(from, tip, radius) {
  const axis = unit(add(tip, from, -1)), u = across(axis), v = cross(axis, u), sectors = 24;
  const positions = [...tip, ...from], indices = [];
  for (let sector = 0; sector < sectors; ++sector) {
    const turn = 2 * Math.PI * sector / sectors, next = 2 + (sector + 1) % sectors;
    positions.push(...add(add(from, u, radius * Math.cos(turn)), v, radius * Math.sin(turn)));
    indices.push(0, 2 + sector, next, 1, next, 2 + sector);
  }
  return {positions: Float32Array.from(positions), indices: Int32Array.from(indices)};
}

// The wind of a frame as a cone around `middle`, the strongest of them `length` long; null without any.
function windShape({wind}, frame, middle, length) {
  const velocities = [wind.x, wind.y, wind.z], speed = (i) => Math.hypot(...velocities.map((values) => values[i]));
  const strongest = wind.x.reduce((most, _, i) => Math.max(most, speed(i)), 0);
  if (!(speed(frame) > 0)) return null;
  const half = velocities.map((values) => 0.5 * length * values[frame] / strongest);
  return coneShape(add(middle, half, -1), add(middle, half), 0.2 * Math.hypot(...half));
}

// A piece of a plane below `center`, as large as the scene, with lines on it.
function planeShape(plane, center, size) {
  const normal = plane.normal, height = dot(add(center, plane.point, -1), normal);
  const middle = add(center, normal, -height), u = across(normal), v = cross(normal, u), cells = 10, lines = [];
  const corner = (i, j) => add(add(middle, u, size * (2 * i / cells - 1)), v, size * (2 * j / cells - 1));
  for (let i = 0; i <= cells; ++i) lines.push(...corner(i, 0), ...corner(i, cells), ...corner(0, i), ...corner(cells, i));
  return {positions: Float32Array.from([corner(0, 0), corner(cells, 0), corner(cells, cells), corner(0, cells)].flat()),
    indices: Int32Array.from([0, 1, 2, 0, 2, 3]), lines: Float32Array.from(lines)};
}

// From small to large errors.
const SCALE = [[59, 111, 182], [127, 194, 201], [244, 226, 133], [240, 140, 58], [192, 38, 45]];
function errorColour(share) {
  if (Number.isNaN(share)) return [0.72, 0.74, 0.77];
  const x = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1), i = Math.min(Math.floor(x), SCALE.length - 2);
  return [0, 1, 2].map((k) => (SCALE[i][k] + (x - i) * (SCALE[i + 1][k] - SCALE[i][k])) / 255);
}

function coloursOf(values, count, frame, largest) {
  const colours = new Float32Array(3 * count);
  for (let p = 0; p < count; ++p) colours.set(errorColour(values[frame * count + p] / (largest || 1)), 3 * p);
  return colours;
}

const errorColours = (replay, frame) => coloursOf(replay.errors, replay.points, frame, replay.largest_error);
const forceColours = (replay, frame) =>
  coloursOf(replay.missingForce, replay.node_count, frame, replay.largest_force);

function uniformColours(count, colour) {
  const colours = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) colours.set(colour, 3 * i);
  return colours;
}
