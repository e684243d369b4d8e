'use strict';
// Unpacks the arrays of identify/report/packed_array.h: positions, errors and meshes of a replay.

const UNSEEN = 65535;

async function unpackBytes(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// [frames x rows] of 16 bits; UNSEEN where a coordinate was not seen.
async function unpackPositions(text, rows) {
  const bytes = await unpackBytes(text), count = bytes.length / 2;
  const values = new Uint16Array(count), last = new Uint16Array(rows);
  for (let i = 0; i < count; ++i) {
    const code = bytes[i] | bytes[count + i] << 8, row = i % rows;
    if (code === UNSEEN) {
      values[i] = UNSEEN;
    } else {
      last[row] += (code >> 1) ^ (code & 1 ? 0xffff : 0);
      values[i] = last[row];
    }
  }
  return values;
}

// Errors in m; NaN: none.
async function unpackErrors(text, largest) {
  const table = Float32Array.from({length: 256}, (_, q) => largest * 10 ** (-6 * (1 - q / 254)));
  table[0] = 0;
  table[255] = NaN;
  return Float32Array.from(await unpackBytes(text), (q) => table[q]);
}

// What a replay holds, ready to be drawn.
async function unpackReplay(replay) {
  const made = {...replay, frames: replay.times.length};
  const grid = (text, count) => text ? unpackPositions(text, 3 * count) : new Uint16Array(0);
  made.recordedGrid = await grid(replay.recorded, replay.points);
  made.predictedGrid = await grid(replay.predicted, replay.points);
  made.hasPrediction = replay.predicted !== undefined;
  made.hasNodes = made.hasPrediction && (replay.points_are_nodes || replay.nodes !== undefined);
  made.nodesGrid = replay.points_are_nodes ? made.predictedGrid : await grid(replay.nodes, replay.node_count);
  made.handlesGrid = await grid(replay.handle_path, replay.handles.length);
  made.handleLines = linesOfHandles(made);
  made.startGrid = await grid(replay.start, replay.node_count);
  if (replay.errors) made.errors = await unpackErrors(replay.errors, replay.largest_error);
  if (replay.missing_force) made.missingForce = await unpackErrors(replay.missing_force, replay.largest_force);
  made.faces = new Int32Array((await unpackBytes(replay.face_list)).buffer);
  made.edges = edgesOf(made.faces);
  made.shapes = [];
  for (const obstacle of replay.obstacles) {
    if (obstacle.type !== 'mesh') continue;
    obstacle.positions = new Float32Array((await unpackBytes(obstacle.vertices)).buffer);
    obstacle.indices = new Int32Array((await unpackBytes(obstacle.faces)).buffer);
  }
  for (const surface of Object.values(replay.surfaces || {})) {
    const obstacle = replay.obstacles.find(({name}) => replay.surfaces[name] === surface);
    surface.grid = await grid(surface.positions, obstacle.positions.length / 3);
  }
  return made;
}

// Float positions of one of the `frames` of a grid; NaN where a point was not seen.
function positionsAt(replay, grid, frame, frames = replay.frames) {
  const count = grid.length / frames, made = new Float32Array(count);
  for (let i = 0; i < count; ++i) {
    const q = grid[frame * count + i];
    made[i] = q === UNSEEN ? NaN : replay.origin[i % 3] + replay.step * q;
  }
  return made;
}

// The ways of all handles, piece by piece.
function linesOfHandles(replay) {
  const lines = [];
  let last = positionsAt(replay, replay.handlesGrid, 0);
  for (let frame = 1; frame < replay.frames; ++frame) {
    const next = positionsAt(replay, replay.handlesGrid, frame);
    for (let i = 0; i < next.length; i += 3) {
      if ([0, 1, 2].every((axis) => next[i + axis] === last[i + axis])) continue;
      lines.push(...last.subarray(i, i + 3), ...next.subarray(i, i + 3));
    }
    last = next;
  }
  return Float32Array.from(lines);
}

function edgesOf(faces) {
  const seen = new Set(), edges = [];
  for (let f = 0; f < faces.length; f += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = faces[f + k], b = faces[f + (k + 1) % 3], key = Math.min(a, b) * 4194304 + Math.max(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      edges.push(a, b);
    }
  }
  return Int32Array.from(edges);
}

// Those of `indices`, `size` at a time, all of whose points were seen.
function seenOnly(indices, size, positions) {
  if (!positions.some(Number.isNaN)) return indices;
  const kept = [];
  for (let i = 0; i < indices.length; i += size) {
    const group = indices.subarray(i, i + size);
    if (group.every((point) => !Number.isNaN(positions[3 * point]))) kept.push(...group);
  }
  return Int32Array.from(kept);
}
