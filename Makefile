# Two commands: make run, make test. Every target makes .venv first, from constraints.txt.
# On Linux the package index's torch brings CUDA along; environment.md says how to get the CPU build:
#   make setup PIP_FLAGS="--extra-index-url https://download.pytorch.org/whl/cpu"

PYTHON ?= python3
PIP_FLAGS ?=
BIN := .venv/bin
STAMP := .venv/.ready
GRADING := .venv/.grading

.PHONY: setup run test lab lint notebooks book handout autograde clean

setup: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; assert sys.version_info >= (3, 11), f"Python 3.11 or later is needed, this is {sys.version}"'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet $(PIP_FLAGS) --constraint constraints.txt --editable ".[notebooks,sweep,test]"
	touch $@

# nbgrader comes with the first command that grades: JupyterLab shows its menus from then on.
$(GRADING): $(STAMP)
	$(BIN)/python -m pip install --quiet $(PIP_FLAGS) --constraint constraints.txt --editable ".[grading]"
	touch $@

# Train EMRLD-WS live, adapt it to unseen goals, and show notebook 06 as a page.
run: setup
	rm -rf build/run
	@echo "1 of 3: meta-training on twelve goals until the mean return is 70 (about a minute; then: goals it never saw)"
	$(BIN)/python -m emrld_lite train --env point2d --algorithm emrld-ws --demos optimal --seed 0 --iterations 150 --stop-at-return 70 --out build/run
	@echo "2 of 3: adapting to twenty unseen goals, one demonstration each (seconds; then: the notebook as a page)"
	$(BIN)/python -m emrld_lite evaluate --run build/run --tasks 20 --steps 3 --seed 0 --out build/unseen-goals.csv
	@echo "3 of 3: running notebook 06, which trains once more by itself (about a minute and a half; then: its page)"
	$(BIN)/python notebooks/book.py --run 06 --out build/book

# Lint, drift check, every notebook run again and compared (the student versions run too, blanks and
# all), unit and property tests. The notebooks, whose few cells take longest, come first, not sorted last
# by their number: else one of them runs alone at the end.
test: setup $(GRADING)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python notebooks/build.py --check
	$(BIN)/python -m pytest notebooks tests -n 2 --dist loadfile --no-loadscope-reorder --nbval --nbval-sanitize-with tests/nbval_sanitize.cfg

lab: setup
	$(BIN)/jupyter lab notebooks

lint: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Run every notebook from its source and write the outputs and the student versions.
notebooks: setup
	$(BIN)/python notebooks/build.py

# Write the notebooks, as they ran last, as a static site: open build/book/index.html.
book: setup
	$(BIN)/python notebooks/book.py --out build/book

# Graded courses: environment.md says how. NOTEBOOKS="01 03" takes these alone, PRIVATE_TESTS=folder adds tests that students do not see.
NOTEBOOKS ?=
PRIVATE_TESTS ?=
HIDDEN := $(if $(PRIVATE_TESTS),--private-tests "$(PRIVATE_TESTS)")

# Write the class folder for nbgrader, build/class: what students get, and what grades them.
handout: setup $(GRADING)
	$(BIN)/python notebooks/handout.py $(NOTEBOOKS) $(HIDDEN)

# Hand in a blank, a half-right and a full copy of each notebook, have nbgrader grade them, compare the marks.
autograde: setup $(GRADING)
	$(BIN)/python notebooks/autograde.py $(NOTEBOOKS) $(HIDDEN)

clean:
	rm -rf build .pytest_cache .ruff_cache .hypothesis
