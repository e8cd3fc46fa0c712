"""The process that has Basilisk, as it is asked: see basilisk_peer.py."""

import json
import subprocess
from pathlib import Path

PEER = Path(__file__).with_name("basilisk_peer.py")


class Basilisk:
    """The process that has Basilisk."""

    def __init__(self, python):
        command = [python, str(PEER)]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.version = self._answer()["version"]

    def _answer(self):
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit("Basilisk: found no answer, expected --basilisk PYTHON to have it")
        return json.loads(line)

    def ask(self, what, runs, **given):
        """Seconds and processor's seconds, and what each run found."""
        question = {"what": what, "runs": runs, "given": given}
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        answer = self._answer()
        return answer["seconds"], answer["found"]
