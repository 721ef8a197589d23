PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PROJECTS := --editable ".[dev]" --editable src/pianta_bench
# uv takes seconds where pip takes minutes; pip is there for where uv does not find the packages
UV_INSTALL := $(BIN)/python -m pip install --quiet uv && $(BIN)/python -m uv pip install --quiet \
	--python $(BIN)/python --constraints constraints.txt --build-constraints constraints.txt $(PROJECTS)
# Also binds what pip installs to build the package.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.PHONY: demo quick test properties fuzz matrix lint types docs site dist clean

demo: $(READY)  ## set up, and read the sample map into demo/read
	$(BIN)/pianta world sample -o demo
	$(BIN)/pianta read demo/map.yaml -o demo/read

# A process of the tests has one thread, since there is one for each core, and keeps what it compiles: the next one
# starts twice as fast.
quick test properties fuzz: export OMP_NUM_THREADS := 1
quick test properties fuzz: export PYTHONDONTWRITEBYTECODE :=

quick: $(READY)  ## set up, and pass the quick tests, which cover every module
	$(BIN)/pytest -n auto -m "not slow"

test: $(READY)  ## set up, and pass all tests
	$(BIN)/pytest -n auto

PROPERTY_SECONDS ?= 1800
properties: export HYPOTHESIS_PROFILE := properties
properties: export PROPERTY_SECONDS := $(PROPERTY_SECONDS)
properties: $(READY)  ## set up, and look for examples that break a test of a property, for PROPERTY_SECONDS (1800)
	$(BIN)/pytest -n auto -r fE

matrix:  ## tests with each Python from 3.11 to 3.13 that is at hand, and with the lowest versions of packages
	$(PYTHON) .ci/matrix.py

FUZZ_INPUTS ?= 1000000
fuzz: $(READY)  ## set up, and give FUZZ_INPUTS (1000000) mutated inputs to readers and commands
	$(BIN)/python fuzzing/fuzz.py --inputs $(FUZZ_INPUTS)

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

docs: $(READY)  ## draw the pictures of README and docs again
	$(BIN)/python docs/draw_pictures.py
	$(BIN)/python docs/draw_graph_kernels.py
	$(BIN)/python docs/draw_realism.py
	$(BIN)/python docs/draw_partial.py
	$(BIN)/python docs/draw_generation.py
	$(BIN)/python docs/draw_prediction.py
	$(BIN)/python docs/draw_exploration.py
	$(BIN)/python docs/draw_mapping.py
	$(BIN)/python docs/draw_plans.py
	$(BIN)/python docs/draw_patterns.py
	$(BIN)/python docs/draw_navigation.py
	$(BIN)/python docs/draw_view.py

site: export OMP_NUM_THREADS := 1
site: $(READY)  ## set up, run the notebooks, and build the documentation into site/html; needs no internet
	$(BIN)/python docs/build_site.py site

dist: $(READY)  ## set up, build wheel and sdist into dist, check them, and try the wheel in an empty environment
	$(BIN)/python .ci/dist.py

clean:
	rm -rf $(VENV) demo dist site

$(READY): pyproject.toml src/pianta_bench/pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(UV_INSTALL) || $(BIN)/python -m pip install --quiet $(PROJECTS)
	touch $@
