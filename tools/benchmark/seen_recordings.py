"""Recordings of known truth as `measure_fits seeds` fits them: exact frames as a sensor sees them, the scene as it is
told to a fit, and what the fit should then find."""
import json
import subprocess
import sys

from known_truths import clothid, np

AXES = "xyz"
OUTLIERS, OUTLIER_DISTANCE = 0.05, 0.1  # the share of points that are far off, m
CLOCK_ERROR = 0.01  # s, by which the user misreads how far the clocks of camera and gripper are apart
NODES_PER_MARKER = 20


def read_scene(path):
    """The scene as a dict that means the same in any folder."""
    scene = json.loads(path.read_text(encoding="utf-8"))
    if isinstance(scene.get("handles"), dict):
        scene["handles"]["path"] = str(path.resolve().parent / scene["handles"]["path"])
    return scene


# -- a camera with white noise --------------------------------------------------------------------------------------

def told_scene(scene, options):
    """What a fit is told: not the start, if it has to find it, and not the truth of a field or a wind."""
    told = dict(scene)
    if options.initial != "scene":
        told.pop("initial", None)
    if options.cut > 0:
        told.pop("duration", None)
    if options.field:
        told.pop("fields")
    if options.wind_profile:
        fitted = options.wind_profile.partition(":")[2] or AXES
        profile = scene["wind"]["profile"]
        still = [[0.0 if axis in fitted else v[i] for i, axis in enumerate(AXES)] for v in profile["velocities"]]
        told["wind"] = {**scene["wind"], "profile": {**profile, "velocities": still}}
    return told


def at_frames(frames, scene, setting, options):
    """(times, positions) of frames at `--frame_rate` after `--cut`, linear between those at the scene's steps."""
    rate = (options.frame_rate or 1 / scene["time_step"]) / (3 if setting == "third" else 1)
    count = int((len(frames) - 1) * scene["time_step"] * rate + 1e-6) + 1
    times = np.arange(count) / rate
    times = times[times >= options.cut - 1e-9]
    places = times / scene["time_step"]
    before = np.minimum((places + 1e-6).astype(int), len(frames) - 2)
    share = (places - before)[:, None, None]
    return times, (1 - share) * frames[before] + share * frames[before + 1]


def seen(frames, scene, setting, seed, options):
    """The recording of frames (T, N, 3) m at the scene's steps."""
    random = np.random.default_rng(seed)
    times, frames = at_frames(frames, scene, setting, options)
    told, others = told_scene(scene, options), {}
    handles = scene.get("handles", [])
    has_path = isinstance(handles, dict)
    if has_path:
        handles = handles["nodes"]
    if has_path and options.initial != "scene":
        told.pop("handles")
        path = frames[:, handles]
        others = {"handle_nodes": handles,
                  "handle_positions": path + options.handle_sigma * random.normal(size=path.shape)}
    points = frames + options.noise * random.normal(size=frames.shape)
    if setting == "half":
        points[random.random(points.shape[:2]) < 0.5] = np.nan
    if setting in ("outliers", "huber"):
        far = random.random(points.shape[:2]) < OUTLIERS
        points[far] += OUTLIER_DISTANCE * random.normal(size=(far.sum(), 3))
    if options.markers:
        free = np.setdiff1d(np.arange(frames.shape[1]), handles)
        others["node_index"] = np.sort(random.choice(free, options.markers, replace=False))
        points = points[:, others["node_index"]]
    sigma = np.full(points.shape[1], options.noise)
    return clothid.Motion(points, times=times, scene=told, sigma=sigma, **others)


# -- the camera and the gripper of a laboratory ---------------------------------------------------------------------

def sensor_of(setting, options):
    """The sensor.json of a setting."""
    sensor = json.loads(options.sensor.read_text(encoding="utf-8"))
    if setting == "clean":
        sensor.update(interval=[np.mean(sensor["interval"])] * 2, gaps=[], drop_fraction=0)
        sensor["gripper"] = {**sensor["gripper"], "noise": 0}
    if setting in ("clean", "markers"):
        sensor["flipped_frames"] = 0
    if setting in ("outliers", "huber"):
        sensor.update(outlier_fraction=OUTLIERS, outlier_distance=OUTLIER_DISTANCE)
    return sensor


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr.strip())


def keep_markers(seed, folder):
    """Leaves the points of some nodes alone; returns the arguments that say which."""
    points = np.load(folder / "points.npy")
    num_markers = -(-points.shape[1] // NODES_PER_MARKER)
    nodes = np.random.default_rng(seed).choice(points.shape[1], num_markers, replace=False)
    np.save(folder / "points.npy", points[:, nodes])
    lines = ["id,node", *(f"{i},{node}" for i, node in enumerate(nodes))]
    (folder / "map.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return ["--map", folder / "map.csv"]


def from_sensor(setting, seed, folder, options):
    """A recording by `simulate --sensor`, imported and checked as those of a laboratory are. Without the frames whose
    points the check calls reordered."""
    sensor = sensor_of(setting, options)
    (folder / "sensor.json").write_text(json.dumps(sensor), encoding="utf-8")
    (folder / "camera.json").write_text(json.dumps(sensor["pose"]), encoding="utf-8")
    truth = ",".join(f"{name}={value}" for name, value in options.set.items())
    run(options.build / "simulate", "--scene", options.scene, "--sensor", folder / "sensor.json", "--set", truth,
        "--seed", seed, "--output", folder / "points.npy", "--handles_output", folder / "gripper.csv")
    read_off = sensor["gripper"]["clock_offset"] - sensor["clock_offset"] - CLOCK_ERROR
    convert = ["convert", folder / "points.npy", folder / "motion.bin", "--scene", options.scene, "--transform",
               folder / "camera.json", "--start_at", "0", "--handles", folder / "gripper.csv", "--handle_time_offset",
               read_off, "--handle_nodes", ",".join(map(str, clothid.Scene(options.scene).handles))]
    if setting == "markers":
        convert += keep_markers(seed, folder)
    run(options.build / "motion", *convert)
    motion = clothid.Motion.load(folder / "motion.bin")
    turned = [frame for found in clothid.check(motion) if found.what == "order of points" for frame in found.frames]
    if turned:
        run(options.build / "motion", *convert, "--skip_frames", ",".join(map(str, turned)))
        motion = clothid.Motion.load(folder / "motion.bin")
    return motion


# -- the truth ------------------------------------------------------------------------------------------------------

def knots_of(scene, times, wind_profile):
    """{name: truth} of the knots of a wind between the first and the last frame."""
    count, _, fitted = wind_profile.partition(":")
    profile = scene["wind"]["profile"]
    knots, truths = np.linspace(times[0], times[-1], int(count)), {}
    for i, axis in enumerate(AXES):
        if axis not in (fitted or AXES):
            continue
        speeds = np.interp(knots, profile["times"], np.array(profile["velocities"])[:, i])
        mean = scene["wind"].get("mean", [0, 0, 0])[i]
        truths.update({f"wind.{axis}.{k + 1}": mean + speed for k, speed in enumerate(speeds)})
    return truths


def between(values, count):
    """`count` rows evenly over those of `values`."""
    places = np.linspace(0, 1, count) if count > 1 else [0.5]
    return np.stack([np.interp(places, np.linspace(0, 1, len(values)), column) for column in values.T], -1)


def nodes_of(scene, truth, field):
    """{name: truth} of the control nodes of a field whose level is that of `truth`, else that of the scene."""
    name, _, size = field.partition(":")
    rows, columns = map(int, size.split("x"))
    level = clothid.Scene(scene).parameters[name]
    logs = between(between(np.log(scene["fields"][name]), rows).T, columns).T
    values = truth.get(name, level) / level * np.exp(logs)
    return {f"{name}.{r + 1}.{c + 1}": value for (r, c), value in np.ndenumerate(values)}
