"""Write docs/claims.md from a full run: python docs/make_claims.py PAPER_DIR."""

import json
import sys
from pathlib import Path

HEAD = """# Claims of the papers

Every claim is computed again by one command and judged by one rule: reproduced where our value lies
within the tolerance of the paper's, not reproduced where it does not, not testable where the paper
rests on measurements that are not published, and ours only where the paper gives no figure. Nothing
is tuned until it holds.
"""

PAPERS = {
    "carrara-kuga": "Carrara and Kuga, Estimating friction parameters in reaction wheels",
    "moreira-lopes-kuga": "Moreira, Lopes and Kuga, Estimation of torque in a reaction wheel",
    "carvalho-fenili": "Carvalho and Fenili, Attitude control with failures in momentum wheels",
    "endo-sekiguchi-nonaka": "Endo, Sekiguchi and Nonaka, Model error compensator for two wheels",
}


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
        lines += [
            f"## {PAPERS[content['paper']]}",
            "",
            f"`gyrostat reproduce {content['paper']} --out DIR`",
            "",
            "| id | paper | ours | unit | verdict | why |",
            "|---|---|---|---|---|---|",
        ]
        lines += [
            f"| `{c['id']}` | {shown(c['paper'])} | {shown(c['ours'])} | {c['unit']} | "
            f"{c['verdict']} | {c['why'].replace('|', chr(92) + '|')} |"
            for c in content["claims"]
        ]
    page = Path(__file__).with_name("claims.md")
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
