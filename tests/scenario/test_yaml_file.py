"""Reading and writing YAML."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from haul_ros.errors import ScenarioError
from haul_ros.scenario.text_file import MOST_BYTES
from haul_ros.scenario.yaml_file import dump_yaml, parse_yaml, read_yaml

KEYS = st.from_regex("[A-Za-z0-9][A-Za-z0-9_.-]*", fullmatch=True)
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=10,
)


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)
"""Nine to the power of twelve words in a kilobyte."""
MERGE_BOMB = "a0: &a0 {x: 1}\n" + "".join(
    f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 9)}]}}\n" for n in range(1, 12)
)


def test_numbers_and_words_are_those_of_yaml_1_2() -> None:
    data = parse_yaml("{a: 1e-3, b: no, c: 1E3, d: 012, e: true}", "x").data
    assert data == {"a": 0.001, "b": "no", "c": 1000.0, "d": 12, "e": True}


def test_each_value_knows_its_line() -> None:
    document = parse_yaml("a:\n  b: 1\n  c:\n    - 2\n    - {d: 3,\n       e: 4}\n", "x.yaml")
    paths = [("a",), ("a", "b"), ("a", "c", 0), ("a", "c", 1, "d"), ("a", "c", 1, "e"), ("a", "c", 1, "e", "unknown")]
    assert [document.origin(path) for path in paths] == [f"x.yaml:{line}" for line in (1, 2, 4, 5, 6, 6)]
    assert document.origin(()) == "x.yaml"


@pytest.mark.filterwarnings("error")
def test_an_anchor_may_be_set_again_without_a_word() -> None:
    assert parse_yaml("a: &x 1\nb: *x\nc: &x 2\nd: *x\n", "x").data == {"a": 1, "b": 1, "c": 2, "d": 2}


def test_a_merged_mapping_can_be_overridden_key_by_key() -> None:
    assert parse_yaml("a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}", "x").data["b"] == {"x": 1, "y": 3}


@settings(max_examples=60, deadline=None)
@example({"a": {"b": ":0", "c": "?0", "d": "\x85", "e": "大秦", "f": "null", "g": "1e3", "h": " x ", "i": "- a"}})
@given(st.dictionaries(KEYS, PLAIN, max_size=4))
def test_what_is_written_reads_back_the_same_in_the_same_order(data: dict[str, object]) -> None:
    text = dump_yaml(data)
    again = parse_yaml(text, "x").data
    assert again == data
    assert list(again) == list(data)
    assert dump_yaml(again) == text


@pytest.mark.no_cover
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: 1\nb: 2\na: 3\n", r"^x:3: not valid YAML: found duplicate key \"a\""),
        ("a: [1, 2\n", r"^x:2: not valid YAML: "),
        ("a: 1\n b: 2\n", r"^x:2: not valid YAML: mapping values are not allowed here$"),
        ("a: !wagon {}\n", r"^x:1: not valid YAML: could not determine a constructor for the tag '!wagon'$"),
        ("a: 1\nb: !!set {c}\n", r"^x:2: b: the tag .*set is not used here$"),
        ("a: 1\n? [b]\n: 2\n", r"^x:2: \?: a key must be text$"),
        ("a: 1\n1: 2\n", r"^x:2: 1: a key must be text$"),
        ("a: *b\n", r"^x:1: not valid YAML: found undefined alias"),
        ("a: 1\n---\nb: 2\n", r"^x:2: not valid YAML: but found another document$"),
        ("a: &b [*b]\n", r"^x: not a YAML file: nested too deeply, or inside itself$"),
        ("a: " + "[" * 1000, r"^x: not usable: nested too deeply"),
        ("a: " + "[" * 101 + "]" * 101, r"^x: not a YAML file: nested too deeply"),
        (BOMB, r"^x: not a YAML file: more than 50000 values and keys$"),
        (MERGE_BOMB, r"^x: not a YAML file: more than 50000 values and keys$"),
        ("[" + "1," * 50_001 + "]", r"^x: not a YAML file: more than 50000 values and keys$"),
        (f"a: {'9' * 4301}\n", r"^x: not valid YAML: a value is not what its form says: Exceeds the limit"),
        ("a: !!bool maybe\n", r"^x: not valid YAML: a value is not what its form says: 'maybe'$"),
        ("a: 2017-13-45\n", r"^x: not valid YAML: a value is not what its form says: month"),
        ("a: \x01\n", r"^x: not a YAML file: unacceptable character"),
    ],
    ids=lambda text: text[:30],  # one is of 100 kB, which pytest would print
)
def test_what_is_not_yaml_is_refused_in_one_line(text: str, expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected) as caught:
        parse_yaml(text, "x")
    assert "\n" not in str(caught.value)


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(ScenarioError, match=r"x.yaml: not a YAML file: not text in UTF-8$"):
        read_yaml(path)


@pytest.mark.parametrize("text", ["", "# nothing\n", "just text", "[]"])
def test_a_text_without_keys_has_no_mapping(text: str) -> None:
    assert not isinstance(parse_yaml(text, "x").data, dict)


def test_a_pipe_and_a_device_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(ScenarioError, match=r"(pipe|zero): cannot be read: not a regular file$"):
            read_yaml(path)


def test_a_file_without_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    with path.open("wb") as file:
        file.truncate(10**12)  # a hole
    with pytest.raises(ScenarioError, match=r"long.yaml: more than 4 MiB"):
        read_yaml(path)


@pytest.mark.parametrize("number", ["0x" + "f" * 5000, "0o" + "7" * 5000, "-0x" + "f" * 5000, "9" * 4000])
def test_a_whole_number_of_thousands_of_digits_is_refused_in_one_line(number: str) -> None:
    with pytest.raises(ScenarioError, match=r"a\.yaml:2: speed: a whole number of more than 10000 bits") as caught:
        parse_yaml(f"a: 1\nspeed: {number}\n", "a.yaml")
    assert "\n" not in str(caught.value)


def test_a_text_that_is_longer_than_a_file_may_be_is_refused_before_it_is_parsed() -> None:
    with pytest.raises(ScenarioError, match="recorded: more than 4 MiB, expected YAML of less"):
        parse_yaml("#" * (MOST_BYTES + 1), "recorded")
