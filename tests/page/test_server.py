"""Only the browser that has the address may ask; nothing it gets is a traceback or comes from elsewhere."""

import http.client
import json
import os
import re
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path
from urllib.parse import urlencode

import pytest

from ropefric.cli.app import main
from ropefric.page.server import MOST_BYTES, MOST_OF_A_FILE, PageServer


@pytest.fixture
def ask(served):
    """Send a request; what is not said is as the page does it."""

    def ask(path, body=None, *, token=served.token, host=None, method=None, raw=None, **headers):
        host = host or f"127.0.0.1:{served.server_port}"
        given = {"Host": host, "X-Ropefric-Token": token}
        if body is not None:
            given |= {"Origin": f"http://{host}", "Content-Type": "application/json"}
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        given = {name: value for name, value in given.items() if value is not None}
        line = http.client.HTTPConnection("127.0.0.1", served.server_port, timeout=20)
        text = raw if raw is not None else None if body is None else json.dumps(body)
        line.request(method or ("GET" if text is None else "POST"), path, text, given)
        answer = line.getresponse()
        content = answer.read().decode()
        line.close()
        assert "Traceback" not in content
        if answer.getheader("Content-Type") == "application/json":
            content = json.loads(content)
        return answer.status, content, answer.headers

    return ask


STATIC = sorted((files("ropefric.page") / "static").iterdir(), key=lambda one: one.name)


def test_the_page_asks_for_nothing_from_elsewhere(ask):
    status, page, headers = ask("/", token=None)
    assert (status, headers["Referrer-Policy"]) == (200, "no-referrer")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    # Nothing stands in the page that its policy refuses.
    assert not re.findall(r"<style|<script(?! type=\"module\" src=)|\son\w+=|\sstyle=", page)
    for one in STATIC:
        status, text, headers = ask(f"/static/{one.name}", token=None)
        assert (status, text) == (200, one.read_text(encoding="utf-8"))
        assert not re.findall(r"(?:https?:)?//[a-z]|url\(|@import|\beval\b|innerHTML", text), one.name
        wanted = re.findall(r'(?:from|import|src=|href=) ?"([\w./-]+)"', text)
        assert all(name.rpartition("/")[2] in {each.name for each in STATIC} for name in wanted)


def test_whoever_lacks_the_token_or_names_this_address_otherwise_gets_nothing(ask, served):
    for given in (None, "", "x", "\xfc"):
        for path in ("/api/overview", "/api/answer", "/api/state", "/results/report.html"):
            status, tree, _ = ask(path, token=given)
            assert (status, list(tree)) == (403, ["error"])
        assert ask("/api/undo", {}, token=given)[0] == 403
        upload = {"raw": "x", "Content_Type": "application/octet-stream"}
        assert ask("/api/upload?name=a.csv", token=given, **upload)[0] == 403
    for host in ("evil.example", f"evil.example:{served.server_port}", "127.0.0.1", "localhost:1"):
        for path in ("/api/overview", "/", "/static/frame.js"):
            assert ask(path, host=host)[0] == 403
    assert ask(f"/api/overview?token={served.token}", token=None)[0] == 200
    assert ask("/api/overview", host=f"localhost:{served.server_port}")[0] == 200


def test_another_page_cannot_write(ask, served):
    path = served.desk.review.campaign_file.parent
    body = {"trial": "c35-r01", "action": "exclude", "text": "torn"}
    before = sorted(one.name for one in path.iterdir())
    for origin in ("http://evil.example", "null", None, "http://127.0.0.1:1"):
        assert ask("/api/decide", body, Origin=origin)[0] == 403
    for kind in ("text/plain", None, "application/x-www-form-urlencoded"):
        assert ask("/api/decide", body, Content_Type=kind)[0] == 415
    assert ask("/api/decide", method="GET")[0] == 404
    assert sorted(one.name for one in path.iterdir()) == before
    done, tree, _ = ask("/api/decide", body)
    assert ((done, tree["rows"]["c35-r01"]["excluded"]), ask("/api/undo", {})[0]) == ((200, "torn"), 200)
    assert len(served.desk.review.campaign.decisions.read_text().splitlines()) == 3


def test_requests_that_make_no_sense_are_answered_in_words(ask):
    for path in ("/api/trial", "/api/curve?trial=c35-r01&columns=x",
        "/api/preview?trial=c35-r01&pick_s=soon"):  # fmt: skip
        assert ask(path)[0] == 400
    for path in ("/x", "/api/", "/api/../page.html", "/page.html", "/static/../server.py", "/static/x.js",
        "/static/"):  # fmt: skip
        assert ask(path)[0] == 404
    for raw in ("", "{", "[]", "7", '{"trial": "c35-r01"}', '{"trial": [], "action": "clear"}'):
        status, tree, _ = ask("/api/decide", {}, raw=raw)
        assert status in {400, 409}, raw
        assert tree["error"]["message"]
    for name, body in (("propose", {"channels": []}), ("propose", {"settings": [7]}),
        ("propose", {"channels": {"force": {"colour": 5}}}), ("solve", {"name": "hoist", "values": [1]}),
        ("decide", {"trial": "c35-r01", "action": ["pick"]}), ("use-law", {}), ("write", {})):  # fmt: skip
        assert ask(f"/api/{name}", body)[0] == 400, (name, body)
    assert ask("/api/curve?trial=c35-r01&start_s=1e999&stop_s=nan&columns=1e9")[0] == 400
    status, tree, _ = ask("/api/decide", {}, raw="[" * 65_000)
    assert (status, tree["error"]["code"]) == (400, "RF110")
    assert ask("/api/decide", {}, raw="x" * (MOST_BYTES + 1))[0] == 413
    assert ask("/api/decide", {}, raw="{}", Content_Length="-1")[0] == 413
    status, tree, _ = ask("/api/decide", {"trial": "c99", "action": "clear"})
    assert (status, tree["error"]["code"]) == (409, "RF120")
    assert tree["error"]["fix"]


def test_of_results_only_the_reports_are_shown(ask, served):
    out = served.desk.out
    (out / "report.html").write_text("<p>done</p>", encoding="utf-8")
    try:
        status, page, headers = ask("/results/report.html")
        assert (status, page, headers["X-Frame-Options"]) == (200, "<p>done</p>", None)
        policy = headers["Content-Security-Policy"]
        assert all(said in policy for said in ("default-src 'none'", "sandbox", "frame-ancestors 'self'"))
        assert "script-src" not in policy
        assert ask("/api/state")[1]["reports"] == ["report.html"]
        for name in ("trials.csv", "../campaign.toml", "..%2Fcampaign.toml", "manifest.json"):
            assert ask(f"/results/{name}")[0] == 409
    finally:
        (out / "report.html").unlink()


def test_what_is_dropped_is_bounded_stays_in_its_folder_and_replaces_nothing(ask, served):
    folder = served.desk.draft.home / "recordings"

    def drop(name, content, **headers):
        given = {
            "Origin": f"http://127.0.0.1:{served.server_port}",
            "Content_Type": "application/octet-stream",
        }
        return ask(f"/api/upload?{urlencode({'name': name})}", raw=content, **given | headers)

    assert drop("pull 1.csv", "time_s,force_N\n")[:2] == (200, {"recordings": str(folder)})
    assert (folder / "pull 1.csv").read_text() == "time_s,force_N\n"
    status, tree, _ = drop("pull 1.csv", "other")
    assert (status, tree["error"]["code"]) == (409, "RF150")
    for name in ("../campaign.toml", "a/b.csv", "..", ".hidden", "a\\b.csv", "a\nb.csv", ""):
        assert drop(name, "x")[0] in {400, 409}, name
    # A large one is read to its end, else no browser reads the answer.
    assert drop("pull 1.csv", "x" * 2**22)[1]["error"]["code"] == "RF150"
    (folder / "link.csv").symlink_to(folder / "nowhere.csv")
    assert drop("link.csv", "x")[1]["error"]["code"] == "RF150"
    (folder / "link.csv").unlink()
    assert drop("large.csv", "x", Content_Length=str(MOST_OF_A_FILE + 1))[0] == 413
    assert drop("plain.csv", "x", Content_Type="text/csv")[0] == 415
    assert [one.name for one in folder.iterdir()] == ["pull 1.csv"]


def test_a_fault_of_ours_is_told_in_words(ask, served, monkeypatch):
    monkeypatch.setattr(served.desk.review, "overview", lambda: 1 / 0)
    status, tree, _ = ask("/api/overview")
    assert (status, tree["error"]["code"]) == (500, "RF000")


def test_data_come_as_json_and_are_kept_nowhere(ask):
    status, tree, headers = ask("/api/curve?trial=c35-r01&start_s=NaN&stop_s=NaN&columns=200")
    assert (status, headers["Cache-Control"]) == (200, "no-store")
    assert len(tree["time_s"]) == len(tree["low_N"]) == len(tree["high_N"]) <= 400
    assert ask("/api/trial?trial=c28-r03")[1]["candidates"][0]["time_s"] == 2.198333
    assert ask("/api/preview?trial=c28-r03&pick_s=2.198333")[1]["picked"][0] == pytest.approx(79.12, abs=0.01)


def test_a_port_that_is_taken_is_told(served):
    with pytest.raises(ValueError, match=f"port {served.server_port} cannot be used"):
        PageServer(served.desk, served.server_port)


def test_the_command_serves_until_it_is_interrupted(campaign):
    out, path = campaign / "out", campaign / "trials.csv"
    head, *rows = path.read_text().splitlines(keepends=True)[1:]
    # Of one condition: to fit laws to more takes longer than all else.
    path.write_text("".join([head, *rows[-4:]]))
    told = {"schema": "ropefric.run/1", "campaign": "../campaign.toml", "law": ""}
    (out / "manifest.json").write_text(json.dumps(told))
    # A job in the background, as these tests may be, ignores Ctrl-C, and so do its processes.
    start = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    start += "from ropefric.__main__ import main; sys.exit(main())"
    words = [sys.executable, "-c", start, "review", str(out), "--by", "A. Meier"]
    browser, opened = campaign / "browser.sh", campaign / "opened"
    browser.write_text(f'#!/bin/sh\nls -ld "$(dirname "${{1#file://}}")" >{opened}.part\n'
        f'echo "$1" >>{opened}.part\ncat "${{1#file://}}" >>{opened}.part\nmv {opened}.part {opened}\n')  # fmt: skip
    browser.chmod(0o700)
    # Without a width of the terminal, which a library of the line editor may hand on behind Python's back.
    env = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    env |= {"BROWSER": f"{browser} %s"}
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
    try:
        address = ""
        while "token=" not in address:
            address = process.stderr.readline()
            assert address
        port, token = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)\n", address).groups()
        while not opened.exists():
            time.sleep(0.01)
        rights, door, page = opened.read_text().split("\n", 2)
        # What everybody sees of a browser is where a page stands that only this user can read.
        assert (rights[:10], door[:8], f"token={token}" in page) == ("drwx------", "file:///", True)
        assert token not in door
        line = http.client.HTTPConnection("127.0.0.1", int(port), timeout=60)
        headers = {"Origin": f"http://127.0.0.1:{port}", "Content-Type": "application/json"}
        body = json.dumps({"trial": "c35-r01", "action": "exclude", "text": "torn"})
        line.request("POST", f"/api/decide?token={token}", body, headers)
        assert line.getresponse().status == 200
        line.close()
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=60)
    finally:
        process.kill()
        process.communicate()
    assert (process.returncode, Path(door.removeprefix("file://")).exists()) == (0, False)
    assert said.startswith("1 decision written to ")
    assert "`ropefric report" in said
    assert ",torn,,A. Meier,20" in (campaign / "decisions.csv").read_text()


def test_a_folder_that_knows_no_campaign_needs_its_name(campaign, capfd):
    refused = {
        "out": "--campaign CAMPAIGN.toml",
        "nowhere": "no such folder",
        "trials.csv": "this is a table",
    }
    for name, why in refused.items():
        assert main(["review", str(campaign / name), "--no-open"]) == 3
        assert why in capfd.readouterr().err
