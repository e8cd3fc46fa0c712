"""Digest of the code of this package."""

import hashlib
from functools import lru_cache
from pathlib import Path

import gyrostat


@lru_cache
def source_digest() -> str:
    """Version of the package with a digest of its code, which may change between versions."""
    root = Path(gyrostat.__file__).parent
    digest = hashlib.sha256()
    # templates of texts that are stored too, among them headers of C
    templates = (path for path in root.glob("*/templates/**/*") if path.is_file())
    for path in sorted({*root.rglob("*.py"), *root.rglob("*.h"), *templates}):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return f"{gyrostat.__version__}+{digest.hexdigest()[:12]}"
