"""Running other programs: `tashika`, and a second Blender that writes the scene.

Nothing here knows Blender.
"""

import json
import os
import queue
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

#: What the exit codes of `tashika` mean that come with a picture: done, out of budget, contradicted by the audit.
WITH_PICTURE = (0, 4, 5)
#: Seconds between two looks at whether the user wants to stop.
LOOK = 0.1
#: Seconds that a program has to write what is finished when it is asked to stop.
GRACE = 60.0

HOW_TO_GET_IT = (
    "the program tashika was not found; build it in a clone of the project by: cargo install --path crates/tashika-cli; "
    "or name it in the preferences of this add-on"
)


class Failure(Exception):
    """Why there is no picture, in words for the user."""


def find(named):
    """The program: the one that is `named`, if any is, else the one on the search path."""
    if named:
        path = Path(named).expanduser()
        if not path.is_file() or not os.access(path, os.X_OK):
            raise Failure(
                f"{path}, which the preferences of this add-on name, is no program; {HOW_TO_GET_IT}"
            )
        return str(path)
    found = shutil.which("tashika")
    if not found:
        raise Failure(HOW_TO_GET_IT)
    return found


def run(command, cancelled, heard):
    """Runs a program; each line of its standard error is given to `heard`. Returns its exit code.

    When `cancelled()` becomes true it is asked to finish, as by Ctrl-C, and ended by force if it does not.
    """
    windows = sys.platform == "win32"
    # Windows sends the signal to a whole group, in which Blender must not be.
    flags = subprocess.CREATE_NEW_PROCESS_GROUP if windows else 0
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    words = {"encoding": "utf-8", "errors": "replace"}
    try:
        process = subprocess.Popen([str(c) for c in command], creationflags=flags, **pipes, **words)
    except OSError as error:
        raise Failure(f"{command[0]} cannot be run: {error.strerror or error}") from error
    lines = queue.Queue()
    reader = threading.Thread(target=lambda: [lines.put(line) for line in process.stderr], daemon=True)
    reader.start()
    try:
        asked = False
        waited = 0.0
        while reader.is_alive() or not lines.empty():
            try:
                heard(lines.get(timeout=LOOK).rstrip("\n"))
            except queue.Empty:
                waited += LOOK if asked else 0.0
            if not asked and cancelled():
                asked = True
                process.send_signal(signal.CTRL_BREAK_EVENT if windows else signal.SIGINT)
            if waited > GRACE:
                process.kill()
        return process.wait()
    finally:
        # However this ends, nobody else waits for it.
        if process.poll() is None:
            process.kill()
            process.wait()
        process.stderr.close()


class Log:
    """What `tashika` tells with `--log json`, line by line."""

    def __init__(self, tell):
        """`tell(words, share)` hears of each phase and how much of it is done, from 0 to 1."""
        self.tell = tell
        self.notes = []
        self.errors = []
        self._phase = ""

    def hear(self, line):
        try:
            event = json.loads(line)
            kind = event["event"]
        except (ValueError, TypeError, KeyError):
            # What is wrong with options is told in words.
            self.errors.append(line)
            return
        if kind == "phase":
            self._phase = event["what"]
            self.tell(self._phase, 0.0)
        elif kind == "progress":
            left = event.get("seconds_left")
            words = self._phase if not left else f"{self._phase}, {left:.0f} s left"
            self.tell(words, event["pixels"] / max(event["of"], 1))
        elif kind == "note":
            self.notes.append(event["what"])
        elif kind == "error":
            self.errors.append(event["what"])

    def failure(self, exit_code):
        """What went wrong, in the words of the program."""
        said = " ".join(line.strip() for line in self.errors if line.strip())
        return Failure(
            f"tashika: {said}" if said else f"tashika ended with exit code {exit_code} and said nothing"
        )
