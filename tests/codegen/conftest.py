import platform

import pytest

from gyrostat.codegen.simd import compiler

NO_COMPILER = ("test_parts.py", "test_lowering.py")
NARROW = [("-mno-avx512f",)] if platform.machine() in ("x86_64", "AMD64") else []


def pytest_collection_modifyitems(items):
    if compiler() is None:
        for item in items:
            if item.path.parent.name == "codegen" and item.path.name not in NO_COMPILER:
                item.add_marker(pytest.mark.skip(reason="needs a C compiler"))


@pytest.fixture(
    scope="module", params=[(), *NARROW], ids=["all lanes", "four lanes"][: 1 + len(NARROW)]
)
def flags(request):
    """More flags of the compiler: for what this processor has, and for what every one has."""
    return request.param
