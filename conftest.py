"""What pytest loads first: notebooks are compared as numbers, wherever it is called from."""

pytest_plugins = ["pytester", "tests.browser", "tests.numeric_nbval"]
