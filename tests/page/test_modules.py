"""The modules of the page fit together as one: they are joined in order, in one scope of names."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from haul_ros.page import document

STATIC = Path(document.__file__).parent / "static"
MODULES = {name: (STATIC / name).read_text("utf-8") for name in document._MODULES}
DECLARED = re.compile(r"^(export )?(?:async )?(?:class|const|let|function) (\w+)", re.M)
IMPORTED = re.compile(r'^import \{([^}]*)\} from "\./(\w+\.js)";', re.M)


def test_every_module_is_part_of_the_page() -> None:
    assert {path.name for path in STATIC.glob("*.js")} - {"uplot.min.js"} == set(MODULES)


def test_no_name_is_declared_twice() -> None:
    names = Counter(name for text in MODULES.values() for _, name in DECLARED.findall(text))
    assert [name for name, count in names.items() if count > 1] == []


def test_what_is_imported_is_exported_by_a_module_before_and_used() -> None:
    before: dict[str, set[str]] = {}
    for module, text in MODULES.items():
        for names, source in IMPORTED.findall(text):
            assert source in before, f"{module} is joined before {source}"
            for name in filter(None, map(str.strip, names.split(","))):
                assert name in before[source], f"{module}: {source} has no {name}"
                assert len(re.findall(rf"\b{name}\b", text)) > 1, f"{module} does not use {name}"
        before[module] = {name for exported, name in DECLARED.findall(text) if exported}


def test_nothing_of_modules_is_left_when_they_are_joined() -> None:
    assert re.findall(r"^(?:import|export)\b.*", document._program(), re.M) == []
