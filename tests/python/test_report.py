"""The page of `planish-viewer --report` in Chromium: it loads, its slider moves, and it asks for nothing from outside."""

import html
import json
import re
import subprocess
from html.parser import HTMLParser

import pytest

from clients import execute, picture, program
from conftest import REPO, binary

DUCK = REPO / "data" / "duck_noisy.obj"
CLEAN = REPO / "data" / "duck_clean.obj"

# Moves the slider as a hand does, and writes what is seen then, and whatever the page may have tried to load.
PROBE = """<script>
const slider = document.querySelector('input');
const after = document.querySelector('.after');
const at = (value) => {
  slider.value = value;
  slider.dispatchEvent(new Event('input'));
  return getComputedStyle(after).clipPath;
};
addEventListener('load', () => {
  const sizes = [...document.images].map((image) => image.naturalWidth);
  const wide = document.documentElement.scrollWidth - innerWidth;
  document.title = JSON.stringify({ low: at(20), high: at(80), sizes, wide, loaded: performance.getEntriesByType('resource').map((entry) => entry.name) });
});
</script></body>"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    viewer = binary("planish-viewer", "PLANISH_VIEWER")
    out = tmp_path_factory.mktemp("report") / "report.html"
    options = ["--size", "600x450", "--backend", "software", "--clean", CLEAN]
    subprocess.run([viewer, DUCK, "--report", out, *options], check=True, timeout=600)
    return out


# What the pictures of a map of `auto` beside a clean mesh show.
PICTURES = [
    "The mesh before denoising",
    "The mesh after denoising",
    "Height of the noise",
    "Where the noise is",
    "Error before",
    "Error after",
]


class Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.seen, self.addresses, self.pictures = [], [], [], []

    def handle_starttag(self, tag, attributes):
        self.seen.append(tag)
        if tag == "img":
            self.pictures.append(dict(attributes)["alt"])
        self.addresses += [value for name, value in attributes if name in ("src", "href", "srcset", "action")]
        if tag not in ("meta", "img", "input", "rect", "line"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in ("rect", "line"):
            assert self.open.pop() == tag


def test_the_page_parses_and_has_all_of_it_within(page):
    text = page.read_text(encoding="utf-8")
    tags = Tags()
    tags.feed(text)
    tags.close()
    assert not tags.open and tags.seen.count("svg") == 2
    assert tags.pictures == PICTURES
    assert all(address.startswith("data:image/png;base64,") for address in tags.addresses)
    assert not re.search(r"https?:|@import|url\(", text)


@pytest.mark.parametrize("size, dark", [((1200, 900), False), ((500, 900), True)], ids=["desk", "small-dark"])
def test_the_slider_moves_and_nothing_is_loaded(page, size, dark, tmp_path):
    browser = program("chromium", "chromium-browser", "google-chrome")
    probed = tmp_path / "probed.html"
    probed.write_text(page.read_text(encoding="utf-8").replace("</body>", PROBE), encoding="utf-8")
    window = f"--window-size={size[0]},{size[1]}"
    common = [browser, "--headless", "--no-sandbox", "--disable-gpu", window, f"--user-data-dir={tmp_path / 'profile'}"]
    if dark:
        common.append("--blink-settings=preferredColorScheme=0")
    found = execute([*common, "--virtual-time-budget=5000", "--dump-dom", probed.as_uri()])
    said = json.loads(html.unescape(re.search(r"<title>(.*?)</title>", found).group(1)))
    assert (said["low"], said["high"]) == ("inset(0px 0px 0px 20%)", "inset(0px 0px 0px 80%)")
    assert said["sizes"] == [600] * len(PICTURES), "every picture is shown"
    assert said["wide"] <= 0, "nothing is wider than the window"
    assert not [name for name in said["loaded"] if not name.startswith("data:")]
    name = picture(f"report-{'dark' if dark else 'light'}", tmp_path)
    execute([*common, f"--screenshot={name}", page.as_uri()])
