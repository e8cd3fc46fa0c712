import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import read_record


@pytest.fixture
def read(tmp_path):
    """Write a file and read it as a record."""

    def read_content(content, name="bench.csv", **options):
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_record(path, **options)

    return read_content


@pytest.fixture
def refusal(read, tmp_path):
    """Write a file that must be refused; the error without the file's folder."""

    def message(content, name="bench.csv", **options):
        with pytest.raises(InputError) as caught:
            read(content, name, **options)
        text = str(caught.value)
        assert text.isprintable(), "one line"
        assert text.startswith(str(tmp_path / name))
        return text.removeprefix(str(tmp_path)).lstrip("/\\")

    return message
