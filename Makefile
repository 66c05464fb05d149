# Nothing to prepare: `make demo`, `make test`, `make bench`, `make clean`. `make test-interop` wants more: see there.
# The virtual environment is made once (.venv) and again only when pyproject.toml or constraints.txt change.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
RUN    := $(BIN)/python
PIP    := $(RUN) -m pip --disable-pip-version-check
OUT    ?= build/demo
EXAMPLES = $(sort $(wildcard src/mixlight/assets/examples/*.jpg))

.DEFAULT_GOAL := help
.PHONY: help demo test lint tests test-interop bench clean

help:
	@echo "make demo    estimate the light of the example photos (results in $(OUT))"
	@echo "make test    ruff, mypy, import-linter and the tests"
	@echo "make test-interop   the tests with the real consumers: Chromium, three.js, Blender, Mitsuba, USD, ONNX"
	@echo "make bench   the speed table of benchmarks/"
	@echo "make clean   remove the virtual environments and everything built"

# Some systems ship Python without ensurepip; their own pip then fills the environment.
$(VENV)/.made:
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(v < (3, 11) and f"MixLight needs Python 3.11 or newer; $(PYTHON) is {v[0]}.{v[1]}")'
	$(PYTHON) -m venv $(VENV) || { $(PYTHON) -m venv --without-pip $(VENV) && $(PYTHON) -m pip --python $(RUN) install --quiet pip; }
	@touch $@

# Editable, so that a changed source needs no new install.
$(VENV)/.run: $(VENV)/.made pyproject.toml constraints.txt
	$(PIP) install --quiet --constraint constraints.txt --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.made pyproject.toml constraints.txt
	$(PIP) install --quiet --constraint constraints.txt --editable '.[dev]'
	@touch $@ $(VENV)/.run

$(VENV)/.interop: $(VENV)/.dev pyproject.toml constraints.txt
	$(PIP) install --quiet --constraint constraints.txt --editable '.[dev,insert,interop]'
	@touch $@

# The packages of the lock file, and no other version of any.
tests/interop/web/node_modules/.made: tests/interop/web/package.json tests/interop/web/package-lock.json
	@command -v npm >/dev/null || { echo "make test-interop needs Node.js 20 or newer with npm on PATH" >&2; exit 1; }
	cd tests/interop/web && npm ci --no-audit --no-fund
	@touch $@

# Two environments of Python 3.11 with PyPI's bpy; the script does nothing where they are there already.
.interop/.made: scripts/make_blender_env.sh
	scripts/make_blender_env.sh
	@touch $@

demo: $(VENV)/.run
	@test -n "$(EXAMPLES)" || { echo "no example photos in src/mixlight/assets/examples" >&2; exit 1; }
	@$(BIN)/mixlight estimate $(EXAMPLES) --out $(OUT)

test: lint tests

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The linters go first: they are quick, and pytest's closing line is the last thing to be seen.
tests: $(VENV)/.dev
	$(RUN) -m pytest -n 2 --dist worksteal --durations 10

# Beside what pip and npm fetch it wants Chromium (on PATH or in MIXLIGHT_CHROMIUM), Node.js and Python 3.11
# (python3.11 or PYTHON311). Nothing is skipped here: what is missing fails and says how to get it. One process,
# as each consumer keeps two cores busy by itself.
test-interop: $(VENV)/.interop tests/interop/web/node_modules/.made .interop/.made
	$(RUN) -m pytest tests/interop --interop --durations 10

bench: $(VENV)/.dev
	$(RUN) -m benchmarks

clean:
	rm -rf $(VENV) .interop tests/interop/web/node_modules build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests benchmarks experiments -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true
