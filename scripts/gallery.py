#!/usr/bin/env python3
"""Renders the scenes of the book's gallery, compares them with references, and writes the chapter.

    pip install numpy OpenEXR pillow
    python3 scripts/gallery.py target/release/tashika WORK [--scenes FOLDER] [--threads N] [NAME...]

WORK stores the images: an image that was rendered there by the same options is not rendered again.
Scenes of other authors are below FOLDER, each in the folder that its command names; without FOLDER
they are omitted. If any NAME is given, scenes that are not named are omitted. The chapter,
`docs/book/src/gallery.md`, has the scenes of this run; its pictures are beside the scenes of the
book in `docs/book/src/gallery`. A table of all numbers is printed.
"""

import argparse
import json
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

LUMINANCE = [0.2126729, 0.7151522, 0.0721750]
BOOK = Path(__file__).resolve().parent.parent / "docs/book/src"
BITTERLI = "from [Benedikt Bitterli's resources](https://benedikt-bitterli.me/resources/)"
BY = "[CC BY {0}](https://creativecommons.org/licenses/by/{0}/)"
DRAFT = "--quality draft --time 45s"
# Options of a reference where paths alone would be too noisy.
TIGHTER = "--quality good --time 135s"


def paths(count):
    return f"--method path --paths {count}"


HEAD = """# Gallery

Each picture was made by the command below it, on one thread, and then measured. *Claimed* is the
program's claim, made without knowing the truth. *Measured* is the result of `tashika compare` with
a reference.

Where path tracing alone gets far enough, it makes the reference; it shares only the scene with the
picture. Where paths are too noisy, the reference is a render with another seed and more time. A
reference has an error of its own, which counts against the picture; the row *against* states it.

A draft claims that a share of its pixels is within 10 %, by an audit of random pixels. A render
with `--error` claims an interval for each pixel. Drafts had the time in their command, on a machine
that was busy with other work; with more time they claim more. The fewer pixels an audit could check
in that time, the lower is its claim, compared with the measured share.

`scripts/gallery.py` makes this page, and the
[record](https://github.com/tashika-render/tashika/blob/main/record/2026-11-27-gallery.md) has the
machine and all numbers. The scenes of this book can be downloaded. The other scenes are by the
authors named here, and are rendered as their files have them.
"""

# Name, title, scene below FOLDER or below the book, caption, author, options of the picture, those
# of the reference.
SCENES = [
    ("room", "The room that is built in", "builtin:room", "A bulb in a shade, a spot light, glass, varnish and 616 instances.", None, f"--size 320x180 {DRAFT}", TIGHTER),
    ("tiny", "Tiny, built in", "builtin:tiny", "The scene of the project's own tests: 36 triangles and a lamp.", None, "--size 160x160 --error 10%", paths(4096)),
    ("book-room", "The room of this book", "room.gltf", "[glTF](room.gltf): a lamp, a matt and a metal block.", None, f"--size 240x240 {DRAFT}", TIGHTER),
    ("marbles", "Marbles", "gallery/marbles.usda", "[USD](gallery/marbles.usda): matt, metal, varnish and a bubble under a lamp and a sky.", None, f"--size 240x180 {DRAFT}", TIGHTER),
    ("fan", "A fan and a ball", "gallery/fan.xml", "[Mitsuba](gallery/fan.xml): both move while the shutter is open, in light of a lamp and of a sky.", None, f"--size 240x180 {DRAFT}", TIGHTER),
    ("fog", "Fog", "gallery/fog.pbrt", "[pbrt](gallery/fog.pbrt): a lamp above a lattice, in fog that fills the room, by path tracing.", None, f"--size 240x180 {DRAFT}", TIGHTER),
    ("medieval", "Medieval building", "obj-nvpro/scenes/Medieval_building.obj", "OBJ: 91 materials of Phong's, under a clear sky and its sun.", "From [vk_raytracing_tutorial_KHR](https://github.com/nvpro-samples/vk_raytracing_tutorial_KHR) by NVIDIA, Apache-2.0.", f"--environment sky:elevation=35,azimuth=150 --light sun:elevation=35,azimuth=150 --size 240x180 {DRAFT}", paths(512)),
    ("level", "A level of a game", "gltf-zdm2/zdm2.glb", "glTF: white halls in the open, under a low sun.", "Map zdm2 of Cube 2: Sauerbraten, converted by Calinou, from [godot-demo-projects](https://github.com/godotengine/godot-demo-projects), " + BY.format("4.0") + ".", "--environment sky:elevation=20,azimuth=60 --light sun:elevation=20,azimuth=60 --size 160x120 --error 10%", paths(2048)),
    ("cornell", "Cornell box", "mi3-cornell-box/scene_v3.xml", "Mitsuba: the box of the Cornell Program of Computer Graphics.", f"Scene {BITTERLI}, CC0.", f"--size 200x200 {DRAFT}", TIGHTER),
    ("hall", "Modern Hall", "mi3-staircase2/scene.xml", "Mitsuba: thirteen lamps, mirrors of metal, a glass wall.", f"Scene by NewSee2l035, {BITTERLI}, {BY.format('3.0')}.", f"--size 200x200 {DRAFT}", TIGHTER),
    ("ajar", "Veach, Ajar", "pbrt4-veach-ajar/scene-v4.pbrt", "pbrt: all light comes through the gap of a door.", f"Scene by Benedikt Bitterli after Eric Veach, {BITTERLI}, CC0.", "--size 192x108 --quality draft --time 120s", paths(1536)),
    ("coffee", "Coffee Maker", "pbrt4-coffee/scene-v4.pbrt", "pbrt: varnish, metal and a glass jug in a studio.", f"Scene by cekuhnen, {BITTERLI}, {BY.format('3.0')}.", "--size 200x250 --quality draft --time 120s", TIGHTER),
    ("living-room", "The Grey & White Room", "mi06-living-room/scene.xml", "Mitsuba: a low sun and a sky, through windows alone.", f"Scene by Wig42, {BITTERLI}, {BY.format('3.0')}.", f"--size 256x144 {DRAFT}", TIGHTER),
    ("bar", "Bistro, the bar", "mi3-bistro-bar-halftex/scene_room.xml", "Mitsuba: 41,753 triangles that shine, in many colours.", f"Amazon Lumberyard Bistro (NVIDIA ORCA), with a chalice by SusanKing, {BY.format('4.0')}; another camera, images halved.", f"--size 256x144 {DRAFT}", TIGHTER),
    ("san-miguel", "San Miguel", "pbrt3-sanmiguel-halftex/sanmiguel_cam14.pbrt", "pbrt: 9.3 million triangles in the open, with leaves that are images.", f"San Miguel by Guillermo M. Leal Llaguno, {BY.format('3.0')}, without the trees and with another sky; images halved.", f"--size 256x176 {DRAFT}", TIGHTER),
]


def run(program, words, folder):
    """Runs a command of the program; returns its JSON."""
    done = subprocess.run([program, *words, "--json", "-"], cwd=folder, capture_output=True, text=True)
    # A picture that ran out of its budget or its time is measured all the same.
    if done.returncode not in (0, 4):
        sys.exit(f"{shlex.join(words)}: {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout)


def relative_noise(path):
    """Median over the pixels of the standard error, relative to the luminance."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    luminance = sum(weight * channels[name].pixels.astype(float) for weight, name in zip(LUMINANCE, "RGB"))
    lit = luminance > 0
    return float(np.median(channels["standard_error.Y"].pixels[lit] / luminance[lit]))


def rendered(program, words, image, folder):
    """Renders an image, unless it was rendered by the same words; returns its JSON."""
    kept = image.with_suffix(".json")
    if kept.exists():
        found = json.loads(kept.read_text())
        if found["words"] == words:
            return found["render"]
    found = run(program, ["render", *words, "-o", str(image)], folder)
    kept.write_text(json.dumps({"words": words, "render": found}, indent=1))
    return found


def measure(program, scene, folder, work, threads):
    name, _, path, _, _, options, truth = scene
    image, reference = [work / f"{name}{of}.exr" for of in ("", "-reference")]
    size = options.split("--size ")[1].split()[0]
    light = options.split("--size ")[0].split()
    thread = ["--threads", str(threads)]
    of_image = rendered(program, [path, *options.split(), *thread], image, folder)
    words = [path, *light, "--size", size, *truth.split(), "--seed", "2", *thread]
    of_reference = rendered(program, words, reference, folder)
    compared = run(program, ["compare", str(image), str(reference)], folder)
    noise = None if truth == TIGHTER else relative_noise(reference)
    return {"render": of_image, "reference": of_reference, "compare": compared, "noise": noise}


def percent(share):
    return f"{100 * share:.3g} %"


def of_picture(found):
    """Claim of an audit about all pixels."""
    claim = found["picture_claim"]
    if claim["upper_outside"] >= 1:
        return "nothing yet: there was no time for an audit that says anything"
    return f"at least {percent(1 - claim['upper_outside'])} of the pixels within {percent(claim['error'])}, {percent(claim['assurance'])} sure"


def claimed(found):
    """Claim of the picture."""
    render = found["render"]
    if render["picture_claim"]:
        return of_picture(render)
    left = render["pixels"] - render["promise_met"]
    return "each pixel an interval, 95 % sure" + (f"; {left} of {render['pixels']} say that they are not done" if left else "")


def measured(found):
    compare = found["compare"]
    told = f"{percent(compare['within_tolerance'])} of the pixels within {percent(compare['error'])}, median error {percent(compare['median'])}"
    claims = compare["claims"]
    return told + (f"; {percent(claims['kept'] / claims['of'])} of the intervals hold" if claims and claims["of"] else "")


def held_to(scene, found):
    """The reference, and its error."""
    if found["noise"] is None:
        return f"a render with `{scene[6]} --seed 2`: {of_picture(found['reference'])}"
    return f"`{scene[6]}`, whose own standard error is {percent(found['noise'])}"


def section(scene, found):
    name, title, path, seen, author, options, _ = scene
    # Commands of the book's own scenes are run by its tests.
    block = "sh" if author is None else "text"
    whose = f" {author}" if author else ""
    return f"""
## {title}

![{title}](gallery/{name}.png)

{seen}{whose}

```{block}
tashika render {path} {options} -o {name}.exr
```

| | |
|---|---|
| claimed | {claimed(found)} |
| measured | {measured(found)} |
| against | {held_to(scene, found)} |
"""


def row(scene, found):
    render, compare = found["render"], found["compare"]
    seconds = [f"{sum(f['seconds'].values()):.0f}" for f in (render, found["reference"])]
    numbers = [percent(compare[key]) for key in ("within_tolerance", "mean", "median", "p95", "bias")]
    cells = [scene[1], f"`{scene[5]}`", claimed(found), *numbers, f"{compare['flip']:.3f}", held_to(scene, found), *seconds]
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("work", type=Path)
    parser.add_argument("--scenes", type=Path)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("names", nargs="*")
    args = parser.parse_intermixed_args()
    program, work = args.program.resolve(), args.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    done = []
    for scene in SCENES:
        name, _, _, _, author, _, _ = scene
        folder = BOOK if author is None else args.scenes
        if folder and (not args.names or name in args.names):
            print(name, file=sys.stderr, flush=True)
            found = measure(program, scene, folder, work, args.threads)
            done.append((scene, found))
            # 256 colours suffice, in a third of the bytes.
            picture = Image.open(work / f"{name}.png").convert("RGB")
            picture = picture.quantize(palette=picture.quantize(256), dither=Image.Dither.FLOYDSTEINBERG)
            picture.save(BOOK / f"gallery/{name}.png", optimize=True)
    (BOOK / "gallery.md").write_text(HEAD + "".join(section(*of) for of in done))
    print("| scene | options | claimed | within | mean | median | 95th | bias | FLIP | reference | seconds | of the reference |")
    print("|---" * 12 + "|")
    for of in done:
        print(row(*of))


if __name__ == "__main__":
    main()
