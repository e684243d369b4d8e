#!/usr/bin/env python3
"""Records a scene that is simulated with finer steps than it says: what a fit with the scene's own steps then misses.

  datasets/record_finely.py BUILD SCENE TRUTH RECORDING [--divisor 16] [--frame_rate 50] [--noise 0.002]
      [--unknown_start]

BUILD holds the programs `simulate` and `motion`. TRUTH is what `simulate --set` takes. The recording has SCENE with its
own step and nominal values, in single precision, and with --unknown_start not where the cloth starts.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("truth")
    parser.add_argument("recording")
    parser.add_argument("--divisor", type=int, default=16)
    parser.add_argument("--frame_rate", default="50")
    parser.add_argument("--noise", default="0.002")
    parser.add_argument("--unknown_start", action="store_true")
    return parser.parse_args()


def main():
    options = arguments()
    scene = json.loads(options.scene.read_text(encoding="utf-8"))
    for key, name in (("mesh", "obj"), ("initial", "positions"), ("handles", "path")):  # files beside the scene
        part = scene.get(key, {})
        file = options.scene.resolve().parent / str(part.get(name) if isinstance(part, dict) else None)
        if file.is_file():
            scene[key][name] = str(file)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def write(name, content):
            (folder / name).write_text(json.dumps(content), encoding="utf-8")
            return folder / name

        fine = write("fine.json", {**scene, "time_step": scene["time_step"] / options.divisor})
        if options.unknown_start:
            scene.pop("initial", None)
        subprocess.run([options.build / "simulate", "--scene", fine, "--set", options.truth, "--float32", "--noise",
                        options.noise, "--frame_rate", options.frame_rate, "--output", folder / "fine.bin"], check=True)
        subprocess.run([options.build / "motion", "convert", folder / "fine.bin", options.recording, "--scene",
                        write("scene.json", scene)], check=True)


if __name__ == "__main__":
    main()
