"""A new column of a record is one field in one file: it is read, cut, pooled and written."""

import shutil
import subprocess
import sys
from pathlib import Path

import gyrostat

FIELD = """    housing: Annotated[
        NDArray[np.float64] | None,
        Role("housing", ("housing", "case"), "temperature", written="housing_degC"),
    ] = None
    notes:"""
SCRIPT = """
import sys
import numpy as np
from gyrostat.telemetry import read_record, write_record
from gyrostat.telemetry.cuts import cut
pooling = sys.modules["gyrostat.telemetry.pool"]
pooling.MANY, pooling.ENOUGH, pooling.BLOCKS = 1000, 100, 20
noise = np.random.default_rng(0).normal(0.0, 1.0, 8000).tolist()
time = np.concatenate([np.arange(0.0, 40.0, 0.01), np.arange(100.0, 140.0, 0.01)])
rows = "".join(
    f"{t!r},0.1,{1.0 + 0.01 * t + e!r},{30.0 + t!r}\\n" for t, e in zip(time.tolist(), noise)
)
open("one.csv", "w").write("time_s,current_A,speed_rad/s,case_degC\\n" + rows)
record = read_record("one.csv")
np.testing.assert_allclose(record.housing, 30.0 + time, rtol=1e-12)
parts = cut(record)
assert len(parts.segments) == 2
np.testing.assert_array_equal(parts.housing, record.housing)
means, size = pooling.pool(parts)
assert size > 1
np.testing.assert_allclose(means.housing, 30.0 + means.time, rtol=1e-12)
for name in ("two.csv", "two.parquet"):
    write_record(record, name)
    np.testing.assert_array_equal(read_record(name).housing, record.housing)
print("passed")
"""


def test_one_field_is_enough(tmp_path):
    source = Path(gyrostat.__file__).parent
    shutil.copytree(source, tmp_path / "gyrostat", ignore=shutil.ignore_patterns("__pycache__"))
    path = tmp_path / "gyrostat" / "telemetry" / "record.py"
    text = path.read_text(encoding="utf-8")
    assert text.count("    notes:") == 2  # the documentation and the field
    head, _, tail = text.rpartition("    notes:")
    path.write_text(f"{head}{FIELD}{tail}", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={"PYTHONPATH": str(tmp_path), "PATH": "", "JAX_PLATFORMS": "cpu"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.stdout == "passed\n", done.stderr
