"""Every Python block of the README runs, and prints what the README says it prints."""

import doctest
import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.mark.slow
def test_blocks_print_what_they_promise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    names: dict[str, object] = {}
    report: list[str] = []
    for number, block in enumerate(BLOCKS):
        test = doctest.DocTestParser().get_doctest(
            block, names, f"README block {number + 1}", str(README), 0
        )
        assert test.examples, f"block {number + 1} of the README has no >>> line"
        runner.run(test, out=report.append, clear_globs=False)
        names = test.globs
    assert runner.failures == 0, "".join(report)
    assert runner.tries >= 10


def test_every_name_the_readme_documents_exists() -> None:
    import pwmap
    import woodpecker

    text = README.read_text(encoding="utf-8")
    for package in (pwmap, woodpecker):
        for name in re.findall(rf"`{package.__name__}\.(\w+)", text):
            assert hasattr(package, name), f"{package.__name__}.{name}"
