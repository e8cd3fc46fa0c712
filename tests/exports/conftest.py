from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def tools(module_at):
    """The C compiler's results as functions, and the interpreter beside it."""
    from types import SimpleNamespace

    here = Path(__file__).parent
    compiled = module_at(here / "compiled.py")
    interpreter = module_at(here / "interpreter.py")
    return SimpleNamespace(
        Compiled=compiled.Compiled,
        write=compiled.write,
        build=compiled.build,
        compiler=compiled.compiler,
        interpret=interpreter.interpret,
    )
