PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# Also binds what pip installs to build the package.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.PHONY: demo test lint types docs clean

demo: $(READY)  ## set up, and read the sample map into demo/read
	$(BIN)/pianta world sample -o demo
	$(BIN)/pianta read demo/map.yaml -o demo/read

test: $(READY)  ## set up, and pass the tests
	$(BIN)/pytest -n auto

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
	$(BIN)/python docs/draw_plans.py

clean:
	rm -rf $(VENV) demo

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@
