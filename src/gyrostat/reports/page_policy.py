"""Content security policy of a page: it runs its own scripts alone, and opens no connection."""

import base64
import hashlib
import re

_POLICY = (
    "default-src 'none'; script-src {scripts} 'wasm-unsafe-eval'; style-src {styles}; "
    "worker-src blob:; connect-src 'none'; img-src data:; base-uri 'none'; form-action 'none'"
)
_SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)
_STYLE = re.compile(r"<style>(.*?)</style>", re.DOTALL)
_PLACE = '<meta charset="utf-8">'


def with_policy(page: str) -> str:
    """Page with its policy: scripts and styles are named by their SHA-256 digests.

    Args:
        page: Page whose scripts and styles stand in it, without attributes.
    """
    sources = {
        name: " ".join(f"'sha256-{_digest(text)}'" for text in pattern.findall(page))
        for name, pattern in (("scripts", _SCRIPT), ("styles", _STYLE))
    }
    policy = _POLICY.format(**sources)
    meta = f'{_PLACE}\n<meta http-equiv="Content-Security-Policy" content="{policy}">'
    return page.replace(_PLACE, meta, 1)


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
