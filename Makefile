# One command for each job; each brings the environment that it needs.
#   make demo    a wheel's friction from the example record
#   make test    the tests
#   make soak    the long attacks of benchmarks/soak_*.py, under 15 minutes
#   make mutants 200 wrong factors, signs and terms, and the tests that feel them; about two hours
#   make peers   the tests against FMPy, Basilisk and OpenTURNS, which are left out where these are not installed
#   make cluster the tests with workers of Dask and a server of S3, in an environment of their own
#   make check   everything that must pass before a change goes in
#   make newest  the built wheel with the newest of everything, for each Python that is here
#   make dist    wheel and source distribution, checked and installed
#   make docs    the documentation, its examples executed
#   make docs-versions COMMITS="v0.1.0 HEAD"  documentation of several commits side by side
#   make clean   remove what the above made, but for the environment
#
# PYTHON names the interpreter that makes the environment (3.11 or newer): make test PYTHON=python3.12

PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2

BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
PINS := pyproject.toml constraints.txt

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test soak mutants peers cluster newest dist check lint format types contracts docs docs-versions types-and-docs clean

help:
	@sed -n 's/^#   //p' Makefile

# pip comes last when an environment is made: where it stands, the environment is whole.
$(BIN)/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "gyrostat needs Python 3.11 or newer; $(PYTHON) is not. Try: make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

# A stamp says that a set is installed; a larger set stamps the smaller ones that it contains.
$(VENV)/.runtime: $(PINS) | $(BIN)/pip
	$(INSTALL) -e .
	@touch $@

$(VENV)/.test: $(PINS) | $(BIN)/pip
	$(INSTALL) -e '.[test]'
	@touch $(VENV)/.runtime $@

$(VENV)/.peers: $(PINS) | $(BIN)/pip
	$(INSTALL) -e '.[test,peers]'
	@touch $(VENV)/.runtime $(VENV)/.test $@

$(VENV)/.check: $(PINS) | $(BIN)/pip
	$(INSTALL) -e '.[test,check,docs]'
	@touch $(VENV)/.runtime $(VENV)/.test $@

demo: $(VENV)/.runtime
	$(BIN)/gyrostat identify examples/wheel_profile2.csv --inertia 1.5e-3 --speed-sigma 5rpm --out demo-out
	@echo "The report: demo-out/report.html"

test: $(VENV)/.test
	$(BIN)/python -m pytest -n $(JOBS) -q tests

# Every script runs, whatever the others found.
soak: $(VENV)/.test
	@failed=; for script in benchmarks/soak_*.py; do \
	  echo "== $$script"; $(BIN)/python $$script || failed="$$failed $$script"; \
	done; test -z "$$failed" || { echo "failed:$$failed" >&2; exit 1; }

mutants: $(VENV)/.test
	$(BIN)/python benchmarks/mutants.py --jobs $(JOBS)

peers: $(VENV)/.peers
	$(BIN)/python -m pytest -q tests/exports tests/spacecraft/test_against_basilisk.py \
		tests/spacecraft/test_torques_against_basilisk.py tests/campaigns/test_effects.py

# without constraints.txt: botocore bounds a pinned package from above
cluster:
	$(PYTHON) -m venv $(VENV)-cluster
	$(VENV)-cluster/bin/pip install -q -c constraints.txt -e '.[test,cluster,s3,servers]'
	$(VENV)-cluster/bin/python -m pytest -q tests/campaigns/test_cluster.py tests/campaigns/test_object_store.py

newest:
	@.ci/newest

dist:
	@PYTHON=$(PYTHON) .ci/dist

lint: $(VENV)/.check
	$(BIN)/ruff check .

format: $(VENV)/.check
	$(BIN)/ruff format --check .

types: $(VENV)/.check
	$(BIN)/basedpyright --pythonpath $(BIN)/python

contracts: $(VENV)/.check
	$(BIN)/lint-imports --no-logo

docs: $(VENV)/.check
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "The documentation: docs/_build/html/index.html"

COMMITS ?= HEAD
docs-versions: $(VENV)/.check
	$(BIN)/python docs/make_versions.py $(COMMITS)

# Both take one core, for minutes.
types-and-docs: $(VENV)/.check
	@$(MAKE) --no-print-directory types & types=$$!; \
	  $(MAKE) --no-print-directory docs; docs=$$?; wait $$types && exit $$docs

# Types and documentation leave half of the cores idle for minutes: the tests run beside them, and end last.
check: lint format contracts
	@$(MAKE) --no-print-directory types-and-docs & others=$$!; \
	  $(MAKE) --no-print-directory test; tests=$$?; \
	  wait $$others || { echo "types or documentation: see above"; exit 1; }; exit $$tests

clean:
	rm -rf build dist demo-out docs/_build docs/api/generated .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests docs -name __pycache__ -type d -prune -exec rm -rf {} +
