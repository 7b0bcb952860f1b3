# Two commands on a fresh machine: `make render` sets up, plays and films; `make test` sets up and tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
DRAGON := $(BIN)/pymunk-dragon

.DEFAULT_GOAL := help
.PHONY: help render report test lint bench demos clean
# A film or a run that was interrupted is not a film or a run.
.DELETE_ON_ERROR:

help: ## list the targets
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 10

$(VENV)/core: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --editable .
	@touch $@

$(VENV)/report: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[report]'
	@touch $@

$(VENV)/all: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[figures,mp4,report,test,lint]'
	@touch $@

render: $(VENV)/core ## play the dragon in Pymunk and film it: renders/*.gif
	$(DRAGON) simulate -o renders/march.npz
	$(DRAGON) render renders/march.npz -o renders/march.gif
	$(DRAGON) simulate --from 400 --frame-interval 0.02 -o renders/first_contact.npz
	$(DRAGON) render renders/first_contact.npz -o renders/first_contact.gif --from 405.4 --camera head --fps 20 --speedup 0.75 --hold 2.5
	$(DRAGON) simulate --guide none -o renders/unguided.npz
	$(DRAGON) render renders/unguided.npz -o renders/unguided.gif --fps 20 --speedup 1 --hold 2

report: $(VENV)/report ## play on past the first contact and tell what happened: renders/report.html
	$(DRAGON) simulate --from 400 --until 416 --contacts report -o renders/report.npz
	$(DRAGON) report renders/report.npz -o renders/report.html

test: $(VENV)/all ## run the tests
	$(BIN)/python -m pytest -q

lint: $(VENV)/all ## style, types, and which room imports which
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/all ## measure the figures that README quotes
	$(BIN)/python tests/bench/bench_engine.py
	$(BIN)/python tests/bench/bench_drift.py
	$(BIN)/python tests/bench/bench_film.py
	$(BIN)/python tests/bench/bench_collision.py
	$(BIN)/python tests/bench/bench_debug_draw.py

demos: $(VENV)/core ## the lessons: a head that only pulls, and a contact that a scan misses
	$(DRAGON) simulate --guide none
	$(DRAGON) contact --width 0.301
	$(DRAGON) contact --width 0.301 --method grid

clean: ## remove what the targets made, but not the films
	rm -rf $(VENV) .venv-* renders/*.npz renders/report.html .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
