"""docs/clients.md shows no code that no test runs."""

import re

from clients import PAGE
from conftest import REPO


def test_every_snippet_is_run():
    page = PAGE.read_text(encoding="utf-8")
    snippets = re.findall(r"<!-- snippet: ([\w-]+) -->", page)
    fences = len(re.findall(r"^```", page, re.MULTILINE))
    assert fences == 2 * len(snippets), "code without a name"
    tests = "".join(path.read_text(encoding="utf-8") for path in (REPO / "tests" / "python").glob("test_*.py"))
    assert [name for name in snippets if f'"{name}"' not in tests] == []
