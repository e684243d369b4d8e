'use strict';
// The 3D view: draws cloth, points and obstacles of a replay with WebGL.

// Depth alone is moved by `push` along the view: a cloth that lies on an obstacle is not cut by it.
const VERTEX = `#version 300 es
  in vec3 position, normal, colour;
  uniform mat4 camera;
  uniform vec3 view;
  uniform float push, pointSize;
  out vec3 shade, across;
  void main() {
    vec4 moved = camera * vec4(position + push * view, 1.0);
    gl_Position = camera * vec4(position, 1.0);
    gl_Position.z = moved.z / moved.w * gl_Position.w;
    gl_PointSize = pointSize;
    shade = colour;
    across = normal;
  }`;
const FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 shade, across;
  uniform vec3 view, light;
  uniform float lit, alpha, isPoint;
  out vec4 result;
  void main() {
    if (isPoint > 0.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
    vec3 n = normalize(across + vec3(1e-9));
    if (dot(n, view) > 0.0) n = -n;
    float bright = 1.0;
    if (lit > 1.5) bright = 0.84 + 0.16 * abs(dot(n, light));
    else if (lit > 0.5) bright = 0.52 + 0.48 * max(dot(n, light), 0.0) + 0.12 * abs(dot(n, view));
    result = vec4(shade * bright * alpha, alpha);
  }`;

// The colour `name` of the page's legend, of 0 .. 1.
const legendColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()
  .match(/[0-9a-f]{2}/gi).map((digits) => parseInt(digits, 16) / 255);
const RECORDED = legendColour('recorded'), PREDICTED = legendColour('predicted'), OBSTACLE = [0.80, 0.84, 0.88];
const HANDLE = [0.13, 0.15, 0.19], WIND = [0.24, 0.55, 0.37];

// What draws into `canvas`; null where the browser has no WebGL.
function makeBrush(canvas) {
  const gl = canvas.getContext('webgl2', {antialias: true, preserveDrawingBuffer: true});
  if (!gl) return null;
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const uniform = {};
  for (const name of ['camera', 'view', 'push', 'pointSize', 'light', 'lit', 'alpha', 'isPoint']) {
    uniform[name] = gl.getUniformLocation(program, name);
  }
  const attributes = ['position', 'normal', 'colour'].map((name) => {
    const made = {location: gl.getAttribLocation(program, name), buffer: gl.createBuffer()};
    gl.bindBuffer(gl.ARRAY_BUFFER, made.buffer);
    gl.enableVertexAttribArray(made.location);
    gl.vertexAttribPointer(made.location, 3, gl.FLOAT, false, 0, 0);
    return made;
  });
  const indexBuffer = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indexBuffer);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  return {gl, uniform, attributes};
}

// Draws into `canvas`; null without a brush. Many viewers may share one of another canvas, from which theirs is then
// copied: browsers have few of them.
function makeViewer(canvas, brush = makeBrush(canvas)) {
  if (!brush) return null;
  const {gl, uniform, attributes} = brush, surface = gl.canvas;
  let replay = null, center = [0, 0, 0], radius = 1, yaw = 0, pitch = 0, distance = 1, shift = [0, 0, 0], planes = [];

  function draw(mode, positions, indices, colours, {normals, isCloth, push = 0, size = 1, alpha = 1} = {}) {
    [positions, normals || positions, colours].forEach((values, i) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, attributes[i].buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    });
    gl.uniform1f(uniform.push, push * radius);
    gl.uniform1f(uniform.pointSize, size * (window.devicePixelRatio || 1));
    gl.uniform1f(uniform.lit, !normals ? 0 : isCloth ? 2 : 1);
    gl.uniform1f(uniform.alpha, alpha);
    gl.uniform1f(uniform.isPoint, mode === gl.POINTS ? 1 : 0);
    if (!indices) {
      gl.drawArrays(mode, 0, positions.length / 3);
      return;
    }
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
    gl.drawElements(mode, indices.length, gl.UNSIGNED_INT, 0);
  }

  // Edges make the shape of a cloth plain.
  function drawEdges(positions, colour, alpha) {
    const colours = uniformColours(positions.length / 3, colour);
    draw(gl.LINES, positions, seenOnly(replay.edges, 2, positions), colours, {push: -0.006, alpha});
  }

  function drawSurface(positions, indices, colours, options) {
    draw(gl.TRIANGLES, positions, indices, colours, {...options, normals: normalsOf(positions, indices)});
  }

  // Lit from both sides alike, and never far from its colour in the legend.
  function drawCloth(positions, indices, colours) { drawSurface(positions, indices, colours, {isCloth: true}); }

  function drawPoints(positions, points, colours, size) {
    const shownPositions = new Float32Array(3 * points.length), shownColours = new Float32Array(3 * points.length);
    let count = 0;
    for (const point of points) {
      if (Number.isNaN(positions[3 * point])) continue;
      for (let axis = 0; axis < 3; ++axis, ++count) {
        shownPositions[count] = positions[3 * point + axis];
        shownColours[count] = colours[3 * point + axis];
      }
    }
    if (count === 0) return;
    draw(gl.POINTS, shownPositions.subarray(0, count), null, shownColours.subarray(0, count), {push: -0.012, size});
  }

  // Where an obstacle is that moves; undefined of one that stands still.
  const poseOf = ({name}, frame) => replay.poses && replay.poses[name] && replay.poses[name][frame];

  function planeAt(plane, frame) {
    const pose = poseOf(plane, frame), normal = posed(plane.normal, pose && [0, 0, 0, ...pose.slice(3)]);
    return planeShape({point: posed(plane.point, pose), normal}, center, 1.6 * radius);
  }

  function drawObstacles(frame) {
    gl.depthMask(false);
    for (const plane of planes.map((flat) => planeAt(flat, frame))) {
      draw(gl.TRIANGLES, plane.positions, plane.indices, uniformColours(4, [0.86, 0.89, 0.92]), {alpha: 0.8});
      draw(gl.LINES, plane.lines, null, uniformColours(plane.lines.length / 3, [0.70, 0.75, 0.80]), {alpha: 0.6});
    }
    gl.depthMask(true);
    for (const shape of replay.shapes) {
      const deforming = replay.surfaces && replay.surfaces[shape.name];
      const positions = deforming ? positionsAt(deforming, deforming.grid, frame, replay.frames)
        : posedAll(shape.positions, poseOf(shape, frame));
      drawSurface(positions, shape.indices, uniformColours(positions.length / 3, OBSTACLE), {push: 0.02});
    }
  }

  const allPoints = () => Array.from({length: replay.points}, (_, p) => p);

  function drawPredicted(frame, withErrors, withForce) {
    const nodes = positionsAt(replay, replay.nodesGrid, frame);
    if (replay.hasNodes) {
      const colours = withForce ? forceColours(replay, frame)
        : withErrors && replay.points_are_nodes ? errorColours(replay, frame)
          : uniformColours(nodes.length / 3, PREDICTED);
      drawCloth(nodes, replay.faces, colours);
      drawEdges(nodes, HANDLE, 0.16);
      const handles = replay.handles.filter((node) => node < replay.node_count);
      drawPoints(nodes, handles, uniformColours(nodes.length / 3, HANDLE), 7);
    } else {
      const points = positionsAt(replay, replay.predictedGrid, frame);
      drawPoints(points, allPoints(), uniformColours(replay.points, PREDICTED), 5);
    }
  }

  // Over the prediction: edges, and points; or where points are no nodes, the markers with a line to where they should be.
  function drawRecordedOver(frame, withErrors) {
    const recorded = positionsAt(replay, replay.recordedGrid, frame);
    const colours = withErrors && !replay.points_are_nodes ? errorColours(replay, frame)
      : uniformColours(replay.points, RECORDED);
    if (replay.points_are_nodes) {
      drawEdges(recorded, RECORDED, 0.4);
      drawPoints(recorded, allPoints(), colours, replay.points > 2500 ? 2.5 : 4);
      return;
    }
    const predicted = positionsAt(replay, replay.predictedGrid, frame), lines = new Float32Array(6 * replay.points);
    let count = 0;
    for (let p = 0; p < replay.points; ++p) {
      if (Number.isNaN(recorded[3 * p]) || Number.isNaN(predicted[3 * p])) continue;
      lines.set(recorded.subarray(3 * p, 3 * p + 3), count);
      lines.set(predicted.subarray(3 * p, 3 * p + 3), count + 3);
      count += 6;
    }
    draw(gl.LINES, lines.subarray(0, count), null, uniformColours(count / 3, RECORDED), {push: -0.008, alpha: 0.8});
    drawPoints(recorded, allPoints(), colours, 8);
  }

  // By itself: a cloth, or points, the smaller the more there are.
  function drawRecordedAlone(frame) {
    const recorded = positionsAt(replay, replay.recordedGrid, frame);
    const colours = replay.colours || uniformColours(replay.points, RECORDED);
    if (replay.points_are_nodes) {
      const faces = seenOnly(replay.faces, 3, recorded);
      drawCloth(recorded, faces, colours);
      drawEdges(recorded, HANDLE, 0.16);
      const isDrawn = new Set(faces.length < replay.faces.length ? faces : allPoints());
      drawPoints(recorded, allPoints().filter((point) => !isDrawn.has(point)), colours, 4);
    } else {
      drawPoints(recorded, allPoints(), colours, Math.min(Math.max(160 / Math.sqrt(replay.points), 2.5), 8));
    }
  }

  // Where a simulation starts, where handles are and go, and the wind in the middle of the cloth, as a cone over it.
  function drawAround(frame, withStart) {
    if (withStart) drawEdges(positionsAt(replay, replay.startGrid, 0, 1), PREDICTED, 0.7);
    const handles = positionsAt(replay, replay.handlesGrid, frame), count = handles.length / 3;
    drawPoints(handles, Array.from({length: count}, (_, i) => i), uniformColours(count, HANDLE), 7);
    if (replay.handleLines.length > 0) {
      draw(gl.LINES, replay.handleLines, null, uniformColours(replay.handleLines.length / 3, HANDLE), {alpha: 0.35});
    }
    const cone = replay.wind && windShape(replay, frame, add(center, replay.up, 0.85 * radius), 0.5 * radius);
    if (cone) drawSurface(cone.positions, cone.indices, uniformColours(cone.positions.length / 3, WIND), {});
  }

  function axes() {
    const up = replay.up, right = across(up), front = cross(up, right);
    const level = add(add([0, 0, 0], right, Math.cos(yaw)), front, Math.sin(yaw));
    const back = unit(add(add([0, 0, 0], level, Math.cos(pitch)), up, Math.sin(pitch)));
    const side = unit(cross(up, back));
    return {back, side, above: cross(back, side)};
  }

  // Column by column: perspective times view.
  function cameraMatrix(aspect) {
    const {back, side, above} = axes(), target = add(center, shift), eye = add(target, back, distance);
    const near = Math.max(distance - 6 * radius, 0.02 * radius), far = distance + 8 * radius;
    const focal = 2.6, fx = focal / Math.max(aspect, 1e-3) * Math.min(aspect, 1), fy = focal * Math.min(aspect, 1);
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    const tx = -dot(side, eye), ty = -dot(above, eye), tz = -dot(back, eye);
    return Float32Array.from([0, 1, 2].flatMap((i) => [fx * side[i], fy * above[i], a * back[i], -back[i]])
      .concat([fx * tx, fy * ty, a * tz + b, -tz]));
  }

  function drawView(x, width, frame, drawContent) {
    gl.viewport(x, 0, width, surface.height);
    const {back, side, above} = axes();
    gl.uniformMatrix4fv(uniform.camera, false, cameraMatrix(width / surface.height));
    gl.uniform3fv(uniform.view, add([0, 0, 0], back, -1));
    gl.uniform3fv(uniform.light, unit(add(add(add([0, 0, 0], back, 0.6), above, 0.7), side, -0.35)));
    drawObstacles(frame);
    drawContent();
  }

  function frameScene() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const extend = (point, margin) => point.forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value - margin);
      high[axis] = Math.max(high[axis], value + margin);
    });
    for (const corner of replay.middle || []) extend(corner, 0);
    const grid = replay.hasNodes ? replay.nodesGrid : replay.predictedGrid;
    for (let frame = 0; frame < replay.frames; frame += Math.max(1, Math.floor(replay.frames / 50))) {
      const positions = positionsAt(replay, grid, frame);
      for (let i = 0; i < positions.length; i += 3) {
        if (!Number.isNaN(positions[i])) extend([...positions.subarray(i, i + 3)], 0);
      }
    }
    const cloth = 0.5 * Math.hypot(...add(high, low, -1)) || 1;
    for (const obstacle of replay.obstacles) {
      const reach = obstacleReach(obstacle), pose = poseOf(obstacle, 0);
      if (reach !== null && reach < cloth) extend(posed(obstacle.center, pose), reach);
      if (['capsule', 'cylinder'].includes(obstacle.type) && obstacle.radius < cloth) {
        for (const end of [posed(obstacle.from, pose), posed(obstacle.to, pose)]) {
          if (Math.hypot(...add(end, low, -1)) < 4 * cloth) extend(end, obstacle.radius);
        }
      }
    }
    center = add(low, add(high, low, -1), 0.5);
    radius = 0.5 * Math.hypot(...add(high, low, -1)) || 1;
  }

  const viewer = {
    load(unpacked) {
      replay = unpacked;
      frameScene();
      planes = replay.obstacles.filter(({type}) => type === 'plane');
      replay.shapes = replay.obstacles.filter(obstacleShape).map((obstacle) => ({...obstacleShape(obstacle), name: obstacle.name}));
      viewer.reset();
    },
    reset() {
      yaw = -0.85;
      pitch = 0.32;
      distance = (replay.middle ? 3 : 2.5) * radius;
      shift = [0, 0, 0];
    },
    turn(dx, dy) {
      yaw -= 0.008 * dx;
      pitch = Math.min(Math.max(pitch + 0.008 * dy, -1.5), 1.5);
    },
    move(dx, dy) {
      if (!replay) return;
      const {side, above} = axes(), scale = 0.8 * distance / canvas.clientHeight;
      shift = add(add(shift, side, -scale * dx), above, scale * dy);
    },
    zoom(factor) { distance = Math.min(Math.max(distance * factor, 0.2 * radius), 30 * radius); },
    draw(frame, {sideBySide, withErrors, withForce, withStart}) {
      const ratio = window.devicePixelRatio || 1;
      const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
      for (const own of new Set([surface, canvas])) {
        if (own.width !== width || own.height !== height) [own.width, own.height] = [width, height];
      }
      gl.clearColor(0.933, 0.949, 0.965, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      if (sideBySide) {
        const half = Math.floor(width / 2);
        drawView(0, half, frame, () => drawRecordedAlone(frame));
        drawView(half, width - half, frame, () => drawPredicted(frame, withErrors, withForce));
        return;
      }
      drawView(0, width, frame, () => {
        if (replay.hasPrediction) {
          drawPredicted(frame, withErrors, withForce);
          drawRecordedOver(frame, withErrors);
        } else {
          drawRecordedAlone(frame);
          drawAround(frame, withStart);
        }
      });
      if (surface !== canvas) canvas.getContext('2d').drawImage(surface, 0, 0);
    },
  };
  return viewer;
}
