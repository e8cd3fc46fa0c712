"""What the documentation adds to its pages."""

import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
LONGEST = 1200
"""Largest number of words of a tutorial."""


def test_pages_can_be_read_with_a_keyboard_and_on_a_phone():
    spec = spec_from_file_location("accessible_pages", DOCS / "accessible_pages.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (
        '<p class="caption" role="heading"><span>How-to</span></p><pre>x_y.z</pre><p>a_b</p>'
        '<code><span class="pre">zero_crossing.toml</span> <span class="pre">a&lt;b</span></code>'
        '<div class="table-wrapper colwidths-auto"></div><div><math></math></div><div class="b">'
        '</div><p><img src="a.png"/></p><p><img src="a.svg"/></p>'
        '<figure class="c"><img/></figure>'
        '<summary aria-label="Toggle hidden content">Show</summary><premise>'
    )
    assert module.accessible(page) == (
        '<p class="caption" role="heading" aria-level="2"><span>How-to</span></p>'
        '<pre tabindex="0">x_y.z</pre><p>a_b</p>'
        '<code><span class="pre">zero_<wbr>crossing.<wbr>toml</span> '
        '<span class="pre">a&lt;b</span></code>'
        '<div tabindex="0" class="table-wrapper colwidths-auto"></div>'
        '<div tabindex="0"><math></math></div><div class="b"></div>'
        '<p tabindex="0"><img src="a.png"/></p><p tabindex="0"><img src="a.svg"/></p>'
        '<figure tabindex="0" class="c"><img/></figure><summary>Show</summary><premise>'
    )


def prose(text):
    """Text of a page without code, tables, pictures and formulas."""
    text = re.sub(r"\A---\n.*?\n---\n", "", text, flags=re.DOTALL)
    text = re.sub(r"^(`{3,}|:{3,}).*?^\1\s*$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"!\[.*?\]\(\S+\)|\$\$.*?\$\$", "", text, flags=re.DOTALL)
    return "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("|"))


def pages_under(caption):
    """Names of the pages of a section of the table of contents."""
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    (section,) = re.findall(
        rf"```{{toctree}}\n:hidden:\n:caption: {caption}\n(.*?)```", index, re.DOTALL
    )
    return [line.split("<")[-1].strip("> ") for line in section.split("\n") if line.strip()]


def test_tutorials_and_guides_are_short():
    names = [*pages_under("Tutorials"), *pages_under("How-to")]
    assert len(names) > 30
    words = {name: len(prose((DOCS / f"{name}.md").read_text("utf-8")).split()) for name in names}
    assert {name: count for name, count in words.items() if count > LONGEST} == {}


def test_a_background_is_reached_from_its_page():
    backgrounds = pages_under("Background")
    found = {page.stem for page in DOCS.glob("*_background.md")}
    assert len(found) > 15
    assert found <= {*backgrounds}
    for name in found:
        page = DOCS / f"{name.removesuffix('_background')}.md"
        assert f"({name}.md" in page.read_text("utf-8"), f"{page.name} does not lead to it"


def test_links_between_pages_lead_to_files_and_headings():
    labels = {}
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        heads = re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE)
        words = (re.sub(r"[^\w\- ]|\(\S*\)", "", head.replace("](", "] (")) for head in heads)
        labels[page.name] = {each.strip().lower().replace(" ", "-") for each in words}
        labels[page.name] |= {*re.findall(r"^\(([\w-]+)\)=$", text, re.MULTILINE)}
        # docutils names a section such as [[metrics.window]] in its own way
        labels[page.name] |= {re.sub(r"\W+", "-", head).strip("-").lower() for head in heads}
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for name, label in re.findall(r"\]\(([\w./-]*\.md)?(?:#([\w-]+))?\)", text):
            assert not name or (DOCS / name).is_file(), f"{page.name}: {name}"
            known = labels.get(name or page.name)
            assert not label or known is None or label in known, f"{page.name}: {name}#{label}"


def test_pictures_of_the_pages_exist_and_have_words():
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for words, file in re.findall(r"!\[(.*?)\]\((images/\S+?)\)", text, re.DOTALL):
            assert (DOCS / file).is_file(), f"{page.name}: {file}"
            assert words.strip(), f"{page.name}: {file}"
