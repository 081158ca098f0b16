"""What many shares of a large image cost besides their pixels, and their merge: many_shares.py PROGRAM WIDTH HEIGHT SHARES SAMPLE

One path a pixel of the small built-in scene, so that nearly all of the time is what is not the pixels. Of the shares, as many as SAMPLE are timed,
spread over the image; all are rendered for the merge if that is all of them.
"""

import pathlib
import resource
import subprocess
import sys
import tempfile
import time

program, (width, height, shares, sample) = sys.argv[1], map(int, sys.argv[2:])


def timed(*words):
    begun = time.time()
    subprocess.run([program, *map(str, words), "--quiet"], check=True, cwd=folder)
    return time.time() - begun


def memory():
    """Of the largest child so far, in megabytes."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


render = ["render", "builtin:tiny", "--method", "path", "--paths", 1, "--size", f"{width}x{height}", "--threads", 1]
with tempfile.TemporaryDirectory() as folder:
    numbers = [1 + i * shares // sample for i in range(sample)]
    of_shares = [timed(*render, "--tiles", f"{n}/{shares}", "-o", f"part-{n}.exr") for n in numbers]
    bytes_of_parts = [pathlib.Path(folder, f"part-{n}.exr").stat().st_size for n in numbers]
    print(f"a share: {sum(of_shares) / sample:.2f} s, the longest {max(of_shares):.2f} s, {memory():.0f} MB")
    print(f"a part: {sum(bytes_of_parts) / sample / 1e6:.2f} MB")
    parts = [f"part-{n}.exr" for n in numbers]
    one = timed("merge", parts[0], "-o", "one.exr", "--partial")
    all_of_them = timed("merge", *parts, "-o", "all.exr", "--partial")
    each = (all_of_them - one) / max(1, sample - 1)
    print(f"merge: {one:.2f} s for one, {all_of_them:.2f} s for {sample}, {1000 * each:.0f} ms each; {memory():.0f} MB")
