"""What the documentation adds to its pages."""

import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


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
        "<summary>Show</summary><premise>"
    )


def test_pictures_of_the_pages_exist_and_have_words():
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for words, file in re.findall(r"!\[(.*?)\]\((images/\S+?)\)", text, re.DOTALL):
            assert (DOCS / file).is_file(), f"{page.name}: {file}"
            assert words.strip(), f"{page.name}: {file}"
