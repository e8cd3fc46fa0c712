import pytest

from gyrostat.lanes import compiler


def pytest_collection_modifyitems(items):
    if compiler() is None:
        for item in items:
            if "tests/lanes" in str(item.path):
                item.add_marker(pytest.mark.skip(reason="needs a C compiler"))
