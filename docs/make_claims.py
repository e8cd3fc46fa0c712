"""Write docs/claims.md from full runs: python docs/make_claims.py PAPER_DIR..."""

import json
import sys
from pathlib import Path

from gyrostat.papers import PAPERS

HEAD = """# Claims of the papers

Every claim is computed again by one command and judged by one rule: reproduced where our value lies
within the tolerance of the paper's, not reproduced where it does not, not testable where the paper
rests on measurements that are not published or where no such value exists, and ours only where the
paper gives no figure. Nothing is tuned until it holds.
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
