'use strict';
// What replays share, one on a page or many: which frame belongs to a time, and how a view is turned, moved and zoomed.

const POINTER_HINT = isTouch ? 'One finger turns, two fingers move and zoom.'
  : 'Drag to turn, shift and drag to move, wheel to zoom.';

// The last frame that is not later than `time`.
function frameAt(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}

// What one pointer, or the first two fingers, do to the view of a canvas that shows something.
function listenToPointers(canvas, viewer, redraw) {
  const held = new Map();
  const between = () => {
    const [[ax, ay], [bx, by]] = [...held.values()];
    return {x: (ax + bx) / 2, y: (ay + by) / 2, spread: Math.hypot(bx - ax, by - ay) || 1};
  };
  canvas.addEventListener('pointerdown', (event) => {
    if (held.size === 2) return;
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, ({pointerId}) => held.delete(pointerId));
  }
  canvas.addEventListener('pointermove', (event) => {
    const last = held.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!last) return;
    const before = held.size === 2 ? between() : null, dx = now[0] - last[0], dy = now[1] - last[1];
    held.set(event.pointerId, now);
    if (before) {
      const after = between();
      viewer.move(after.x - before.x, after.y - before.y);
      viewer.zoom(before.spread / after.spread);
    } else if (event.shiftKey || event.buttons > 1) {
      viewer.move(dx, dy);
    } else {
      viewer.turn(dx, dy);
    }
    redraw();
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    viewer.zoom(Math.exp(0.001 * event.deltaY));
    redraw();
  }, {passive: false});
}
