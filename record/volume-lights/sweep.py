"""Pairs and rays of a pixel against its gather points: a row of the record for each number of them.

    python3 record/volume-lights/sweep.py target/release/tashika [SCENE]
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = Path(__file__).parent / "hall.pbrt"
METHODS = (["mdlc"], ["tashika", "--truth", "vpl"])


def work(program: str, scene: str, method: list[str], points: int, folder: str) -> dict:
    report = Path(folder) / "report.json"
    options = f"--error 10% --max-pairs 1000000 --vpls 20000 --clamp 0.2 --gather {points} --size 24x15"
    command = [program, "render", scene, "--method", *method, *options.split()]
    command += ["-o", str(Path(folder) / "film.exr"), "--json", str(report)]
    subprocess.run(command, check=True, capture_output=True)
    return json.loads(report.read_text())


def main() -> None:
    program, scene = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else str(SCENE)
    print("| gather points | terms | mdlc: pairs | rays | tashika: pairs | rays |")
    with tempfile.TemporaryDirectory() as folder:
        for points in (16, 32, 64, 128, 256, 512, 1024):
            row = [points]
            for method in METHODS:
                told = work(program, scene, method, points, folder)
                assert told["budget_hit"] == 0, told
                row += [] if len(row) > 1 else [points * told["lights"]["count"]]
                row += [told["pairs_per_pixel"], told["rays_per_pixel"]]
            print("|", " | ".join(f"{value:,.0f}" for value in row), "|", flush=True)


if __name__ == "__main__":
    main()
