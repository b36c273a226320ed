"""The mechanism itself: what agrees, what does not, what is written anew, and what a page may not claim."""

import pytest
import sessions

PRINTED = ["The law: coupled", "  a   1.25", "  b   3.5", "  c   7", "", "Doubts", "  - none"]


AGREE = [PRINTED, ["…"], ["The law: coupled", "…"], ["…", "  - none"], ["…", "  b   3.5", "…"],
    ["The law: coupled", "…", "  c   7", "…", "Doubts", "  - none"]]  # fmt: skip
DIFFER = [[], PRINTED[:-1], PRINTED[1:], ["  b   3.5", "…"], ["…", "  b   3.5"], ["…", "  b   3.6", "…"],
    ["…", "  b   3.5", "Doubts", "…"], ["…", "Doubts", "…", "  b   3.5", "…"]]  # fmt: skip


def test_parts_in_order_agree_and_other_lines_do_not():
    for shown in AGREE:
        assert sessions.agrees(shown, PRINTED), shown
        assert sessions.written_anew(shown, PRINTED) == shown
    assert not any(sessions.agrees(shown, PRINTED) for shown in DIFFER)


def test_what_changed_is_written_where_it_stood():
    changed = ["The law: coupled", "  a   1.3", "  b   4.5", "  new 1", "", "Doubts", "  - none"]
    assert sessions.written_anew(["…", "  b   3.5", "…"], changed) == ["…", "  b   4.5", "…"]
    assert sessions.written_anew(PRINTED, changed) == changed
    with pytest.raises(AssertionError, match="begins like"):
        sessions.written_anew(["…", "  gone   3.5", "…"], changed)


@pytest.fixture
def page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text):
        path = tmp_path / "page.md"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_false_number_on_a_page_is_found_and_put_right(page):
    true = "```console\n$ ropefric --version\nropefric 0.2.0\n```\nwords\n\n```pycon\n>>> 1 + 1\n2\n```\n"
    assert sessions.run_page(page(true)) == true
    false = true.replace("0.2.0", "9.9.9")
    with pytest.raises(AssertionError, match="sessions"):
        sessions.run_page(page(false))
    assert sessions.run_page(page(false), anew=True) == true
    with pytest.raises(AssertionError, match="Expected:"):
        sessions.run_page(page(true.replace("\n2\n", "\n3\n")))


def test_a_failing_command_says_so(page):
    fails = "```console\n$ ropefric check nothing.toml --quiet\n…\n$ echo $?\n3\n```\n"
    assert sessions.run_page(page(fails)) == fails
    for silent in (
        "```console\n$ ropefric check nothing.toml --quiet\n…\n```\n",
        "```console\n$ ropefric check nothing.toml --quiet\n…\n$ ropefric --version\nropefric 0.2.0\n```\n",
    ):
        with pytest.raises(AssertionError, match="ended with 3"):
            sessions.run_page(page(silent))


def test_what_waits_for_a_browser_is_left_as_it_stands(page):
    waits = "```console\n$ ropefric review out\nhttp://127.0.0.1:1/\n```\n"
    assert sessions.run_page(page(waits), anew=True) == waits


def test_only_our_own_program_is_run(page):
    with pytest.raises(AssertionError, match="not a command"):
        sessions.run_page(page("```console\n$ rm -rf x\n```\n"))
