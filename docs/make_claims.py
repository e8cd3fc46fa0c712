"""Write docs/claims.md from full runs: python docs/make_claims.py PAPER_DIR..."""

import json
import sys
from pathlib import Path

from gyrostat.papers import PAPERS

HEAD = """# Claims of the papers

This page lists the claims of four papers and of the worked example of a standard, with our values,
a verdict and its reason. One command recomputes all claims of a paper:

```sh
gyrostat reproduce carrara-kuga --out DIR
```

The verdict is *reproduced* if our value is within the tolerance of the paper's value, and *not
reproduced* otherwise. It is *calibrated* if the values agree but a setting that the paper leaves
open was chosen by this value, so that the agreement shows nothing; the reason names the setting. It
is *infeasible* if the quantity was shown not to exist, such as a time to settle at an attitude that
cannot be reached, *not testable* if the claim needs data that the paper does not publish, and *ours
only* if the paper gives no value. Settings of the other claims were chosen without their values.
"""


def shown(value):
    """A table cell."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def main():
    """Write the page."""
    lines = [HEAD]
    for folder in sys.argv[1:]:
        content = json.loads((Path(folder) / "claims.json").read_text(encoding="utf-8"))
        paper = PAPERS[content["paper"]]
        lines += [
            f"## {paper.citation}",
            "",
            f"`gyrostat reproduce {paper.name} --out DIR`",
            "",
            "| id | paper | ours | unit | verdict | source | why |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [
            f"| `{c['id']}` | {shown(c['paper'])} | {shown(c['ours'])} | {c['unit']} | "
            f"{c['verdict']} | {row.source} | {c['why'].replace('|', chr(92) + '|')} |"
            for c, row in zip(content["claims"], paper.rows, strict=True)
        ]
        lines.append("")
    page = Path(__file__).with_name("claims.md")
    page.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
