"""The linter finds words and phrases to avoid in what people read, and nowhere else."""

import pytest

from tools.plain_words import findings, rules


def found(path, text):
    path.write_text(text, encoding="utf-8")
    return [(line, words) for line, words, _ in findings(path, rules())]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Worlds are made anew.", "anew"),
        ("Nobody eats it.", "Nobody"),
        ("The curve beside it.", "beside"),
        ("The run goes on.", "goes on"),
        ("The file says so.", "says"),
        ("Leaving is no death.", "is no"),
        ("It takes .5 s.", ".5"),
        ("In 95 % of runs.", "5 %"),
        ("The colour of grass.", "colour"),
        ("Animals have learnt it.", "learnt"),
        ("Not covered is the sea.", "Not covered is"),
    ],
)
def test_a_phrase_to_avoid_is_found_with_its_line(tmp_path, text, words):
    hits = found(tmp_path / "page.md", f"# Page\n\n{text}\n")
    assert {line for line, _ in hits} == {3}
    assert words in {phrase for _, phrase in hits}


def test_code_and_code_spans_are_passed_over(tmp_path):
    page = "`nobody` and [a link](beside.md)\n\n```python\nnobody = 1  # beside\n```\n"
    assert found(tmp_path / "page.md", page) == []
    assert found(tmp_path / "code.py", "beside = nobody = 1\n") == []


def test_docstrings_comments_and_messages_of_python_are_read(tmp_path):
    code = 'def f():\n    """Let it pass."""\n    raise ValueError("there is nobody here")  # goes on\n'
    assert found(tmp_path / "code.py", code) == [(2, "Let"), (3, "nobody"), (3, "goes on")]


def test_good_english_is_left_alone(tmp_path):
    text = "The mean is 0.5 (95% interval: 0.4 to 0.6). There is no limit. It is no longer used.\n"
    assert found(tmp_path / "page.md", text) == []


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("page.js", 'h("p", { text: "Click where nobody lives." });'),
        ("page.js", "notice(`After tick ${tick} there is nobody.`);"),
        ("page.html", '<b title="A place for nobody else">'),
        ("page.html", "<p>There is nobody here.</p>"),
        ("world.toml", 'description = "Grass that nobody eats."'),
        ("project.toml.template", 'description = "Grass that nobody eats."'),
        ("system.py.template", "nobody = 1  # nobody"),
    ],
)
def test_texts_of_the_viewer_of_worlds_and_of_templates_are_read(tmp_path, name, text):
    assert found(tmp_path / name, text) == [(1, "nobody")]


def test_code_in_strings_is_passed_over(tmp_path):
    assert found(tmp_path / "world.toml", 'when = "nobody > 0.8 or beside > 0.98"\n') == []


def test_labels_of_stored_results_are_left_alone(tmp_path):
    (tmp_path / "studies").mkdir()
    label = 'LABEL = "yellow: selection coefficient where nobody learns"\n'
    assert found(tmp_path / "studies" / "goats.py", label) == []
    assert found(tmp_path / "studies" / "goats.py", label.replace("yellow", "blue")) == [(1, "nobody")]
