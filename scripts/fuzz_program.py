#!/usr/bin/env python3
"""Searches for files on which the program crashes, or takes too much time or memory.

    python3 scripts/fuzz_program.py target/release/tashika --seconds 600 [--seed N] [--out FOLDER]
                                    [TARGET...]
    python3 scripts/fuzz_program.py target/release/tashika --scale [TARGET...]

Needs nothing but Python and Linux. Each input is a file for `info`; one in eight of the files that
are read is rendered as well, to a picture of 4 × 4 pixels. Each run is a process with limits of its
own: --limit seconds and --memory MiB. Inputs are the seeds of fuzz/seeds, changed by bits, by
tokens and by structure: numbers become extreme, parts are repeated, nested in themselves, or
doubled. `--scale` writes families of files that grow, of 60 kB to 1 MB, and reports the seconds per
megabyte: quadratic time stands out.

A finding is an exit code that the guide does not name, a signal, or more than the limits. It is
stored in the folder with its command. The last line is a JSON object with the number of inputs by
target, of which `read` were read.
"""

import argparse
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

STAGE = b"""#usda 1.0
def Mesh "Quad" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
    rel material:binding = </M>
}
def "M" ( references = @look.mtlx@</MaterialX/Materials/M> ) { }
"""
VOLUMES = b"""<scene version="3.0.0"><integrator type="volpath"/><emitter type="constant"/>
<shape type="cube"><bsdf type="null"/><medium type="heterogeneous" name="interior">
<volume type="gridvolume" name="sigma_t"><string name="filename" value="a.vol"/></volume>
</medium></shape></scene>"""
SMOKE = b"""Integrator "volpath" Camera "perspective" WorldBegin LightSource "infinite"
MakeNamedMedium "smoke" "string type" "nanovdb" "string filename" "a.nvdb"
MediumInterface "smoke" "" Material "interface" Shape "sphere\""""

# By target: name of the fuzzed file, scene that contains it, and True for text.
TARGETS = {
    "gltf": ("scene.gltf", None, True),
    "glb": ("scene.glb", None, False),
    "obj": ("scene.obj", None, True),
    "rad": ("scene.rad", None, True),
    "mtl": ("m.mtl", ("scene.obj", b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"), True),
    "pbrt": ("scene.pbrt", None, True),
    "mitsuba": ("scene.xml", None, True),
    "ply": ("m.ply", ("scene.pbrt", b'WorldBegin\nShape "plymesh" "string filename" "m.ply"\n'), False),
    "serialized": (
        "m.serialized",
        ("scene.xml", b'<scene version="0.6.0"><shape type="serialized"><string name="filename" value="m.serialized"/></shape></scene>'),
        False,
    ),
    "vol": ("a.vol", ("scene.xml", VOLUMES), False),
    "nvdb": ("a.nvdb", ("scene.pbrt", SMOKE), False),
    "mtlx": ("look.mtlx", ("scene.usda", STAGE), True),
    **{
        kind: (f"e.{kind}", ("scene.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), False)
        for kind in ("exr", "hdr", "pfm", "png", "tga", "tif")
    },
    "usda": ("scene.usda", None, True),
    "usdc": ("scene.usdc", None, False),
    "usdz": ("scene.usdz", None, False),
    "light": ("lamp.ies", ("scene.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), True),
}

# Folders of the seeds of images, by target.
IMAGES = {
    "exr": ["film/*.exr"],
    "tif": ["image/*.tif", "image/*.tx"],
    **{kind: [f"image/*.{kind}"] for kind in ("hdr", "pfm", "png", "tga")},
}

# Exit codes that the guide names.
KNOWN = {0, 2, 3, 4, 5, 6, 130}

EXTREMES = [
    "0", "-0", "1", "-1", "1e38", "-1e38", "3.5e38", "1e300", "1e-45", "1e-300", "nan", "inf", "-inf", "0.5", "1000", "65535",
    "65536", "100000", "16777217", "2147483647", "-2147483648", "4294967295", "4294967296", "1000000000", "18446744073709551615",
    "99999999999999999999", "1e9", "0x10", "",
]


class Text:
    """Changes of texts."""

    TOKEN = re.compile(rb'[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|"[^"\n]{0,200}"|\w+|[^\w\s]')

    def __init__(self, draw, all_seeds):
        self.draw, self.seeds = draw, all_seeds

    def tokens(self, data):
        return [m.span() for m in self.TOKEN.finditer(data[: 1 << 16])]

    def change(self, data):
        draw = self.draw
        spans = self.tokens(data)
        if not spans:
            return data + b" 1"
        start, end = draw.choice(spans)
        way = draw.randrange(11)
        if way <= 1:
            numbers = [s for s in spans if data[s[0] : s[0] + 1] in b"+-.0123456789"]
            if numbers:
                start, end = draw.choice(numbers)
                return data[:start] + draw.choice(EXTREMES).encode() + data[end:]
        if way == 2:
            other = draw.choice(spans)
            return data[:start] + data[other[0] : other[1]] + data[end:]
        if way == 3:
            return data[:start] + data[end:]
        if way == 4:
            return repeated(draw, data, start, end)
        if way == 5:
            lines = data.split(b"\n")
            i = draw.randrange(len(lines))
            j = min(len(lines), i + draw.choice([1, 1, 2, 5, 20]))
            times = draw.choice([2, 3, 10, 100, 1000])
            size = max(1, sum(map(len, lines[i:j])))
            block = lines[i:j] * min(times, max(1, 60000 // size))
            return b"\n".join(lines[:i] + block + lines[j:])
        if way == 6:
            return nested(draw, data)
        if way == 7:
            other = draw.choice(self.seeds)
            cut = draw.randrange(len(other) + 1)
            return data[:start] + other[cut : cut + draw.choice([10, 100, 1000])] + data[end:]
        if way == 8:
            lines = data.split(b"\n")
            i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
            lines[i], lines[j] = lines[j], lines[i]
            return b"\n".join(lines)
        if way == 9:
            words = [s for s in spans if data[s[0] : s[0] + 1].isalpha() or data[s[0] : s[0] + 1] == b'"']
            if words:
                start, end = draw.choice(words)
                word = data[start:end]
                return data.replace(word, data[slice(*draw.choice(words))])
        return data[:start] + data[start:end] * draw.choice([2, 3, 300]) + data[end:]


def repeated(draw, data, start, end):
    """Repeats a part of the text, from a token on."""
    end = min(len(data), start + draw.choice([1, 10, 50, 200, 1000]))
    part = data[start:end]
    times = draw.choice([2, 3, 10, 100, 1000, 10000])
    return data[:start] + part * min(times, max(1, 60000 // max(1, len(part)))) + data[end:]


def nested(draw, data):
    """Nests a part between two brackets in itself."""
    pairs = [(b"{", b"}"), (b"[", b"]"), (b"(", b")"), (b"AttributeBegin", b"AttributeEnd"), (b"<", b"/>"), (b"ObjectBegin", b"ObjectEnd")]
    draw.shuffle(pairs)
    for opens, closes in pairs:
        starts = [m.start() for m in re.finditer(re.escape(opens), data)][:200]
        if not starts:
            continue
        start = draw.choice(starts)
        end = data.find(closes, start + len(opens))
        if end < 0:
            continue
        before, inner, after = data[:start], data[start + len(opens) : end], data[end + len(closes) :]
        depth = draw.choice([2, 10, 100, 1000])
        depth = min(depth, max(1, 60000 // max(1, len(inner) + 2)))
        if draw.random() < 0.5:
            return before + (opens + inner) * depth + closes * depth + after
        return before + opens + (opens + inner + closes) * depth + closes + after
    return data


def changed_bytes(draw, data, seeds):
    data = bytearray(data)
    if not data:
        return b"\0"
    at = draw.randrange(len(data))
    way = draw.randrange(8)
    if way == 0:
        data[at] ^= 1 << draw.randrange(8)
    elif way == 1:
        data[at] = draw.choice([0, 1, 0x7F, 0x80, 0xFF, draw.randrange(256)])
    elif way in (2, 3):
        size = draw.choice([2, 4, 8])
        value = draw.choice([0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 10**6, 10**9, 2**63 - 1, 2**64 - 1, len(data)])
        data[at : at + size] = (value % 2 ** (8 * size)).to_bytes(size, draw.choice(["little", "little", "big"]))
    elif way == 4:
        del data[at : at + draw.choice([1, 4, 16, 100])]
    elif way == 5:
        data[at:at] = data[at : at + draw.choice([4, 16, 64, 256])] * draw.choice([1, 2, 16, 200])
    elif way == 6:
        other = draw.choice(seeds)
        cut = draw.randrange(len(other) + 1)
        data[at : at + 16] = other[cut : cut + draw.choice([4, 16, 64])]
    else:
        del data[at:]
    return bytes(data[:65536])


class Runner:
    """Runs the program on files, and stores its findings."""

    def __init__(self, args):
        self.args, self.out = args, Path(args.out)
        self.out.mkdir(parents=True, exist_ok=True)
        self.folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
        self.findings = []

    def limits(self):
        memory = (self.args.memory + 512) << 20
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        seconds = int(self.args.limit) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 26, 1 << 26))

    def command(self, target, picture):
        name, scene, _ = TARGETS[target]
        file = str(self.folder / (scene[0] if scene else name))
        common = [file, "--allow-missing", "--threads", "1", "--quiet"]
        if target == "light":
            common += ["--light", f"ies:{self.folder / name}@0,1,0"]
        if target in IMAGES:
            common += ["--environment", str(self.folder / name)]
        if picture:
            return [self.args.program, "render", *common, "--size", "4x4", "--method", "path", "--paths", "2", "-o", str(self.folder / "out.exr")]
        return [self.args.program, "info", *common, "--json", str(self.folder / "out.json")]

    def run(self, target, data, picture=False):
        """Returns seconds and exit code of a run."""
        name, scene, _ = TARGETS[target]
        (self.folder / name).write_bytes(data)
        if scene:
            (self.folder / scene[0]).write_bytes(scene[1])
        command = self.command(target, picture)
        begun = time.monotonic()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                timeout=20 * self.args.limit, preexec_fn=self.limits, check=False,
            )
            code, said = done.returncode, done.stderr
        except subprocess.TimeoutExpired:
            code, said = "timeout", b""
        # Processor time, which other work on the machine does not change.
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        del begun
        if code not in KNOWN or seconds > self.args.limit:
            self.keep(target, data, command, code, seconds, said)
        return seconds, code

    def keep(self, target, data, command, code, seconds, said):
        number = len(self.findings)
        file = self.out / f"{target}-{self.args.seed}-{number}{Path(TARGETS[target][0]).suffix}"
        if number < 200:
            file.write_bytes(data)
        message = said.decode("utf-8", "replace").strip().splitlines()[-3:]
        finding = {"file": str(file), "code": code, "seconds": round(seconds, 2), "message": message, "command": command[1]}
        self.findings.append(finding)
        print("finding:", json.dumps(finding), flush=True)

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)


def seeds(target):
    patterns = IMAGES.get(target, [f"{target}/*"])
    found = sorted(file for pattern in patterns for file in (ROOT / "fuzz/seeds").glob(pattern))
    return [file.read_bytes() for file in found if file.is_file()] or [b""]


def fuzz(runner, targets, args):
    draw = random.Random(args.seed)
    pools = {target: list(seeds(target)) for target in targets}
    counts = {target: {"inputs": 0, "read": 0, "pictures": 0, "slowest": 0.0} for target in targets}
    for target in targets:
        for data in pools[target]:
            runner.run(target, data)
    begun = time.monotonic()
    while time.monotonic() - begun < args.seconds:
        for target in targets:
            pool, is_text = pools[target], TARGETS[target][2]
            data = draw.choice(pool)
            text = Text(draw, pool)
            for _ in range(draw.choice([1, 1, 2, 3, 6])):
                data = text.change(data) if is_text and draw.random() < 0.9 else changed_bytes(draw, data, pool)
            data = data[: 1 << 18]
            seconds, code = runner.run(target, data)
            count = counts[target]
            count["inputs"] += 1
            count["slowest"] = max(count["slowest"], round(seconds, 2))
            if code == 0:
                count["read"] += 1
                if draw.random() < 0.02 and len(pool) < 200:
                    pool.append(data[:65536])
                if draw.random() < 0.125:
                    runner.run(target, data, picture=True)
                    count["pictures"] += 1
            if time.monotonic() - begun >= args.seconds:
                break
    return counts


def families():
    """Returns the families of growing files: target, name, bytes for a size, sizes."""
    from fuzz_families import FAMILIES

    return FAMILIES


def scale(runner, targets, args):
    worst = []
    for target, name, make, sizes in families():
        if target not in targets:
            continue
        line = []
        for n in sizes:
            data = make(n)
            seconds, code = runner.run(target, data)
            line.append({"n": n, "kB": len(data) // 1000, "s": round(seconds, 2), "s/MB": round(seconds / max(len(data), 1) * 1e6, 1), "code": code})
        worst.append((max(entry["s"] for entry in line), target, name))
        print(f"{target:10} {name:28}", "  ".join(f"{e['kB']} kB {e['s']} s ({e['code']})" for e in line), flush=True)
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(TARGETS)}; all, if none is named")
    parser.add_argument("--seconds", type=float, default=60, help="how long to go on")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=5, help="seconds of the processor for an input")
    parser.add_argument("--memory", type=int, default=1024, help="MiB for an input")
    parser.add_argument("--out", default="fuzz/findings", help="where findings are kept")
    parser.add_argument("--scale", action="store_true", help="files that grow, in place of changed seeds")
    args = parser.parse_args()
    args.program = str(Path(args.program).resolve())
    targets = args.targets or list(TARGETS)
    for target in targets:
        if target not in TARGETS:
            parser.error(f"{target} is none of {', '.join(TARGETS)}")
    runner = Runner(args)
    try:
        if args.scale:
            scale(runner, targets, args)
            counts = {}
        else:
            counts = fuzz(runner, targets, args)
    finally:
        runner.close()
    print(json.dumps({"counts": counts, "inputs": sum(c["inputs"] for c in counts.values()), "findings": len(runner.findings)}))
    sys.exit(1 if runner.findings else 0)


if __name__ == "__main__":
    main()
