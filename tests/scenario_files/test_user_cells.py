"""Own parts of cells of a real kernel."""

import textwrap

import numpy as np
import pytest

pytest.importorskip("ipykernel", reason="found no ipykernel, expected the extra docs")
manager = pytest.importorskip("jupyter_client.manager", reason="found no jupyter_client")

PART = """
import numpy as np
import jax.numpy as jnp
class P:
    size: float = 1.0
    def __call__(self, spacecraft, attitude, time):
        return law() * self.size * jnp.ones(3)
"""
CELLS = {
    "redefined in a magic cell": (
        ["def law(): return 2.0", PART, "%%time\ndef law(): return 3.0"],
        3.0,
    ),
    "class in a magic cell": (["def law(): return 2.0", f"%%time\n{textwrap.dedent(PART)}"], 2.0),
    "a cell that failed": (["def law(): return 2.0", PART, "1 / 0\ndef law(): return 3.0"], 2.0),
    "executed twice": (
        ["def law(): return 2.0", PART, "def law(): return 3.0", "def law(): return 2.0"],
        2.0,
    ),
    "a captured name that changed": (
        ["gain = 2.0\ndef make(k): return lambda: k\nlaw = make(gain)", PART, "gain = 3.0"],
        None,
    ),
}
ASK = """
from gyrostat.scenario_files.python.objects import user_object
from gyrostat.scenario.user.parts import user_part
from gyrostat.core.errors import InputError
try:
    found = user_object("environment.torque", P)
    part = user_part("environment.torque", found.kind, found.sources)
    print(part.build(found.values)(None, None, 0.0)[0], "runs")
except InputError as error:
    print("refused", error)
%reset -f
"""


@pytest.fixture(scope="module")
def kernel():
    made, client = manager.start_new_kernel(kernel_name="python3")
    try:
        yield client
    finally:
        client.stop_channels()
        made.shutdown_kernel(now=True)


@pytest.mark.parametrize(("cells", "expected"), CELLS.values(), ids=CELLS)
def test_cells_run_as_they_are_in_memory(kernel, cells, expected):
    said = []

    def hear(message):
        said.append(message["content"].get("text", ""))

    for cell in (*cells, ASK):
        kernel.execute_interactive(
            cell, output_hook=hear, timeout=120, stop_on_error=False, allow_stdin=False
        )
    answer = "".join(said).splitlines()[-1]
    if expected is None:
        assert answer.startswith("refused environment.torque P: found law")
    else:
        assert answer.endswith(" runs"), answer
        np.testing.assert_equal(float(answer.split()[0]), expected)
