"""The whole road on the page, as a newcomer goes it: 32 German files in mV, from the folder to the report."""

from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

PATIENCE_S = 300
FIELDS = {"r-force-sensitivity": "25 N/mV", "r-end_tension-sensitivity": "40 N/mV", "r-name": "Newcomer"}
DESIGN = {"r-design-radius": "40 mm", "r-design-wrap": "270 deg", "r-design-tension": "30 N"}
WHEEL = {"w-wheel_radius_m": "42", "w-wrap_angle_rad": "300", "w-end_tension_N": "35"}


class Road:
    """One step after the other; `seen` is told of each, once it is done."""

    def __init__(self, driver, address, seen=lambda driver, step: None):
        self.driver, self.seen = driver, lambda step: seen(driver, step)
        driver.get(address)

    def wait(self, done):
        WebDriverWait(self.driver, PATIENCE_S, poll_frequency=0.05).until(lambda _: done())

    def one(self, name):
        return self.driver.find_element(By.ID, name)

    def text(self, name):
        return self.one(name).text

    def can(self, name):
        """Return whether a button can be used."""
        return self.one(name).get_attribute("aria-disabled") != "true"

    def idle(self):
        script = "return document.getElementById('work').hidden && document.getElementById('error').hidden"
        self.wait(lambda: self.driver.execute_script(script))

    def write(self, fields):
        for name, words in fields.items():
            field = self.one(name)
            field.clear()
            self.idle()
            self.one(name).send_keys(words, Keys.TAB)
            self.settled()

    def settled(self):
        """Wait until what was asked last is looked at."""
        script = "return import('/static/recordings.js').then((page) => page.look()).then(() => true)"
        self.driver.set_script_timeout(PATIENCE_S)
        assert self.driver.execute_script(script)

    def recordings(self):
        self.wait(lambda: self.one("r-more").is_displayed())
        self.settled()
        assert self.one("r-force-sensitivity").get_attribute("aria-invalid") == "true"
        # What changes from name to name is marked, then said.
        for part, header in (
            ("30", "wheel radius mm"),
            ("180", "wrap angle deg"),
            ("20", "end tension N"),
            ("1", "repeat"),
        ):
            field = self.one("r-pattern")
            at = field.get_property("value").rindex(part)
            self.driver.execute_script(
                "arguments[0].setSelectionRange(arguments[1], arguments[2])", field, at, at + len(part)
            )
            self.one("r-headers").find_element(By.XPATH, f".//button[.='{header}']").click()
        self.settled()
        self.write(FIELDS | DESIGN)
        # The stretch at the beginning in which nothing pulls is drawn over.
        plot = self.one("r-plot")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
        left = 60 - plot.size["width"] // 2
        chain = ActionChains(self.driver).move_to_element_with_offset(plot, left, 0).click_and_hold()
        chain.move_by_offset(int(0.05 * plot.size["width"]), 0).release().perform()
        self.settled()
        self.seen("recordings")
        button = self.one("r-write")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
        self.wait(lambda: self.can("r-write"))
        button.click()
        self.wait(lambda: self.driver.execute_script("return document.body.dataset.step") == "picks")

    def picks(self):
        self.wait(
            lambda: (
                self.text("trial") not in {"", "…"} and "F_A" in self.one("plot").get_attribute("aria-label")
            )
        )
        self.one("list").send_keys(Keys.ARROW_LEFT)
        self.wait(lambda: "it would be" in self.text("said"))
        self.one("list").send_keys("a")
        self.wait(lambda: "written" in self.text("said"))
        self.wait(lambda: not self.text("computing").startswith("computing"))
        self.seen("picks")

    def go(self, name):
        self.driver.find_element(By.CSS_SELECTOR, f"nav a[href='#{name}']").click()

    def law(self):
        self.go("law")
        self.wait(lambda: self.one("l-all").is_displayed() and self.text("l-law"))
        self.seen("law")

    def wheel(self):
        self.go("wheel")
        self.wait(lambda: self.text("w-lift").startswith("F_A") and self.one("m-effects").text)
        for name, value in WHEEL.items():
            self.one(name).clear()
            self.one(name).send_keys(value)
        script = "return import('/static/wheel.js').then(({W}) => W.lift)"
        self.wait(lambda: abs(self.driver.execute_script(script)["end_tension_N"] - 35) < 1e-9)
        self.wait(lambda: "lifts" in self.text("w-inverse"))
        self.seen("wheel")
        return self.driver.execute_script(script)

    def report(self):
        self.go("report")
        self.one("p-make").click()
        self.wait(lambda: self.one("p-frame").is_displayed() or self.one("error").is_displayed())
        assert not self.one("error").is_displayed(), self.text("error")
        self.driver.switch_to.frame(self.one("p-frame"))
        self.wait(lambda: self.driver.find_elements(By.TAG_NAME, "h1"))
        title = self.driver.find_element(By.TAG_NAME, "h1").text
        self.driver.switch_to.default_content()
        self.seen("report")
        return title
