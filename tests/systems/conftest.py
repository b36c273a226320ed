import pytest
from paper import press_data, printed_press


@pytest.fixture(scope="session")
def paper_data():
    """The printed machine data in SI units, by name."""
    return press_data()


@pytest.fixture(scope="session")
def paper_press():
    """The printed machine at 50 rpm, without what the paper does not give."""
    return printed_press()
