"""Make the pictures of docs/app.md again: each step of the page, light and dark, wide and narrow.

`python tests/regenerate_pictures.py [FOLDER]` walks the whole road in a Chromium and takes four pictures of every step.
"""

import base64
import io
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path

from browser import driven
from newcomer import write_daq
from PIL import Image
from road import Road

from ropefric.page.desk import Desk
from ropefric.page.server import PageServer

LAB = "aramid-rope-2026"
SIZES = {"wide": (1280, 900), "narrow": (390, 844)}


def take(driver, step, folder):
    """Take four pictures of a step; the page may change its size, but is left as it was."""
    for width, (across, down) in SIZES.items():
        for scheme in ("light", "dark"):
            sizes = {"width": across, "height": down, "deviceScaleFactor": 1, "mobile": width == "narrow"}
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", sizes)
            features = [{"name": "prefers-color-scheme", "value": scheme}]
            driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
            driver.execute_script(
                "scrollTo(0, 0); document.querySelector('.step:not([hidden])').scrollTop = 0"
            )
            tall = (
                driver.execute_script("return document.querySelector('.step:not([hidden])').scrollHeight")
                + 130
            )
            if step != "picks":  # which has its own places to scroll in
                driver.execute_cdp_cmd(
                    "Emulation.setDeviceMetricsOverride", sizes | {"height": max(down, tall)}
                )
            driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
            time.sleep(0.5 if step == "report" else 0)  # its frame is drawn by another process
            shot = driver.execute_cdp_cmd(
                "Page.captureScreenshot", {"format": "png", "captureBeyondViewport": False}
            )
            name = (
                f"app-{step}.png"
                if (width, scheme) == ("wide", "light")
                else f"app-{step}-{width}-{scheme}.png"
            )
            picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
            picture.quantize(128).save(folder / name, optimize=True)
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    lab = Path(tempfile.gettempdir(), LAB)  # the pictures show this name
    lab.mkdir()
    try:
        write_daq(lab / "daq")
        desk = Desk(lab / "daq", by="A. Meier")
        with PageServer(desk) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            for driver in driven():
                road = Road(driver, server.address, lambda on, step: take(on, step, folder))
                for step in (road.recordings, road.picks, road.law, road.wheel, road.report):
                    step()
            server.shutdown()
        desk.close()
    finally:
        shutil.rmtree(lab)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "docs" / "pictures")
