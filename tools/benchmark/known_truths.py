"""What measurements of fits share: motions that the fitting model did not make, fits that are timed, and tables.
`measure_fits` and `measure_other_truths` import it."""
import csv
import os
import time
import warnings

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read once, when NumPy and clothid load their linear algebra

import clothid  # noqa: E402
import numpy as np  # noqa: E402


def finer_mesh(scene):
    """The scene with twice the density of nodes. Nodes between handles are handles, too."""
    columns, rows = scene["mesh"]["grid"]["nodes"]
    held = np.zeros((rows, columns), dtype=bool)
    held.flat[scene.get("handles", [])] = True
    fine = np.zeros((2 * rows - 1, 2 * columns - 1), dtype=bool)
    fine[::2, ::2] = held
    fine[1::2, ::2] = held[:-1] & held[1:]
    fine[::2, 1::2] = held[:, :-1] & held[:, 1:]
    fine[1::2, 1::2] = fine[1::2, :-1:2] & fine[1::2, 2::2]
    grid = {**scene["mesh"]["grid"], "nodes": [2 * columns - 1, 2 * rows - 1]}
    return {**scene, "mesh": {"grid": grid}, "handles": np.flatnonzero(fine).tolist()}


def simulated(scene, truth, steps=1, levels=0, all_nodes=False):
    """Positions (T, N, 3) m of the scene's nodes at the scene's steps, of a rollout with `steps` times as many steps on
    a mesh that was refined `levels` times; of all nodes of that mesh with `all_nodes`."""
    fine = {**scene, "time_step": scene["time_step"] / steps}
    for _ in range(levels):
        fine = finer_mesh(fine)
    frames = np.asarray(clothid.Rollout(fine, truth).positions)[::steps]
    if levels == 0 or all_nodes:
        return frames
    columns, rows = fine["mesh"]["grid"]["nodes"]
    stride = 2**levels
    grid = frames.reshape(len(frames), rows, columns, 3)[:, ::stride, ::stride]
    return grid.reshape(len(frames), -1, 3)


class RightPrediction:
    """What a right prediction holds and misses, of draws (D, ..) of the coordinates of a cell: coverage of bands of
    90 % and error of the median, (low, high) nine times in ten, and `usual`, how often the coverage is 80 to 98 %."""

    def __init__(self, draws):
        coverage, error = clothid.leave_one_out(draws)
        ends = np.quantile([coverage, error], (0.05, 0.95), axis=1, method="weibull")
        self.coverage, self.error = ends[:, 0], ends[:, 1]
        self.usual = np.mean((coverage >= 0.8) & (coverage <= 0.98))


class Cell:
    """Some frames of a prediction, judged: coverage, error of the median and half the width of the bands in m, and the
    `RightPrediction` or None."""

    def __init__(self, coverage, error, width, right=None):
        self.coverage, self.error, self.width, self.right = coverage, error, width, right

    def is_too_narrow(self):
        return self.coverage < self.right.coverage[0] or self.error > self.right.error[1]

    def is_too_wide(self):
        return not self.is_too_narrow() and self.error < self.right.error[0]

    def __str__(self):
        told = f"{100 * self.coverage:.0f} %", f"{1e3 * self.error:.2g} mm"
        if self.right:
            shares, errors = 100 * self.right.coverage, 1e3 * self.right.error
            told = f"{told[0]} ({shares[0]:.0f}..{shares[1]:.0f})", f"{told[1]} ({errors[0]:.2g}..{errors[1]:.2g})"
        return f"{told[0]} of {told[1]} in +- {1e3 * self.width:.2g}"


def count_cells(cells):
    """How many of them lie where, in a line."""
    coverage = np.array([cell.coverage for cell in cells])
    usual = (coverage >= 0.8) & (coverage <= 0.98)
    words = [f"{usual.sum()} of {len(cells)} cells hold 80 to 98 %, {(coverage < 0.8).sum()} less, "
             f"{(coverage > 0.98).sum()} more"]
    if all(cell.right for cell in cells):
        narrow, wide = sum(cell.is_too_narrow() for cell in cells), sum(cell.is_too_wide() for cell in cells)
        words = [f"{words[0]}, {sum(cell.right.usual for cell in cells):.0f} of right predictions",
                 f"{len(cells) - narrow - wide} are as of right predictions, {narrow} too narrow, {wide} too wide"]
    return "; ".join([*words, f"in the mean {100 * coverage.mean():.0f} %"])


def clouds_on(frames, columns, count, noise, generator):
    """A list of (3, count) arrays, m: points anywhere on the triangles of a grid whose nodes (T, N, 3) have as many
    columns, each of the same chance, with noise of `noise` m on every coordinate."""
    nodes = np.arange(frames.shape[1]).reshape(-1, columns)
    a, b, c, d = (part.ravel() for part in (nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, :-1], nodes[1:, 1:]))
    triangles = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    clouds = []
    for frame in frames:
        corners = frame[triangles[generator.integers(len(triangles), size=count)]]
        first = 1 - np.sqrt(generator.uniform(size=(count, 1)))
        second = (1 - first) * generator.uniform(size=(count, 1))
        points = first * corners[:, 0] + second * corners[:, 1] + (1 - first - second) * corners[:, 2]
        clouds.append((points + noise * generator.normal(size=points.shape)).T)
    return clouds


def seen_as_clouds(motion, clouds, sigma):
    """The recording with `clouds`, (3, M) m a frame, in place of its points."""
    state = motion.__getstate__()
    state.update(clouds=clouds, cloud_sigma=sigma, positions=np.zeros((0, len(clouds))), sigma=np.zeros(0),
                 node_index=np.zeros(0, dtype=np.int32))
    seen = clothid.Motion.__new__(clothid.Motion)
    seen.__setstate__(state)
    return seen


def fit(motion, names, start, **options):
    """{"result": the `clothid.Result`, "seconds", "rollouts", "all_seconds"} of a fit on one thread, or {"failure": why
    there is none}. Seconds are those of the processor; "seconds" and "rollouts" end with the last iteration, before
    intervals and checks."""
    begin = time.process_time()
    told = {}

    def on_iteration(state):
        told.update(seconds=time.process_time() - begin, rollouts=state["rollouts"])

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clothid.RecordingWarning)
        try:
            result = clothid.identify(motion, names, start=start, on_iteration=on_iteration, **options)
        except clothid.Error as error:
            return {"failure": str(error)}
    return {"result": result, **told, "all_seconds": time.process_time() - begin}


def text(value):
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}" if np.isfinite(value) else "-"
    return "-" if value is None else str(value)


def print_table(header, rows):
    """Columns as wide as their widest entry."""
    lines = [header] + [[text(value) for value in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines)]
    for line in lines:
        print("  ".join(entry.rjust(width) for entry, width in zip(line, widths)))


def write_csv(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])
