# Two commands on a fresh machine: `make render` sets up, plays and films; `make test` sets up and tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
DRAGON := $(BIN)/pymunk-dragon

.DEFAULT_GOAL := help
.PHONY: help render runs films figures screenshot report test lint bench demos clean
# A film or a run that was interrupted is not a film or a run.
.DELETE_ON_ERROR:

help: ## list the targets
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 10

$(VENV)/core: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --editable .
	@touch $@

$(VENV)/figures: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[figures]'
	@touch $@

$(VENV)/report: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[report]'
	@touch $@

$(VENV)/demos: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[demos]'
	@touch $@

$(VENV)/all: $(VENV)/core
	$(BIN)/pip install --quiet --editable '.[curves,demos,figures,mp4,report,test,lint]'
	@touch $@

render: runs films figures ## play the dragon in Pymunk, film it, draw the figures, and write a page that plays it

# Every picture is the same to the byte until what it shows changes.
runs: $(VENV)/figures
	$(DRAGON) simulate -o renders/march.npz
	$(DRAGON) simulate --from 400 --frame-interval 0.02 -o renders/first_contact.npz
	$(DRAGON) simulate --guide none -o renders/unguided.npz
	$(DRAGON) simulate --curve u-turn --from -100 --until 100 -o renders/u-turn.npz

films: runs
	$(DRAGON) render renders/march.npz -o renders/march.gif
	$(DRAGON) render renders/first_contact.npz -o renders/first_contact.gif --from 405.4 --camera head --fps 20 --speedup 0.75 --hold 2.5
	$(DRAGON) render renders/march.npz renders/unguided.npz -o renders/guides.gif --until 12.5 --size 330 --speedup 1 --hold 2 --title "Dancers keep the dragon on its path"
	$(DRAGON) render renders/first_contact.npz --exact -o renders/exact.gif --from 409 --camera head --span 5 --size 330 --speedup 0.5 --hold 3 --title "The engine and the exact model"
	$(DRAGON) render renders/first_contact.npz -o renders/marks.png --camera head --size 660 --velocities --grid --impulses --contacts --normals --title "The head meets bench 8" --caption "Arrows end where the handles would be in half a second; discs are impulses in the joints; cells are darker where a bench is filed."
	$(DRAGON) render renders/u-turn.npz -o renders/u-turn.gif --from -6 --until 36 --span 15 --speedup 6 --fps 20
	$(DRAGON) render renders/march.npz -o renders/march.html

STILLS := outer-loop inward collision
CHARTS := spiral grid trajectories velocities gap speeds
OF_RUNS := drift impulses
STUDIES := min-pitch u-turn max-speed sensitivity

figures: runs
	mkdir -p renders/figures
	set -e; for name in $(STILLS); do $(DRAGON) figure $$name -o renders/figures/$$name.png; done
	set -e; for name in $(CHARTS); do for ending in png svg; do $(DRAGON) figure $$name -o renders/figures/$$name.$$ending; done; done
	set -e; for name in $(OF_RUNS); do for ending in png svg; do $(DRAGON) figure $$name renders/march.npz -o renders/figures/$$name.$$ending; done; done
	set -e; for name in $(STUDIES); do $(DRAGON) study $$name -o renders/figures/$$name.png; done

screenshot: films demos $(VENV)/all ## pictures of the player and of the lessons, in Chromium: renders/player.png, lessons.png
	$(BIN)/python tests/bench/screenshot.py renders/march.html "#t=409.8&follow=head" renders/player.png
	$(BIN)/python tests/bench/screenshot.py renders/lessons.html "#spiral" renders/lessons.png

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
	$(BIN)/python tests/bench/bench_march.py
	$(BIN)/python tests/bench/bench_answers.py
	$(BIN)/python tests/bench/bench_player.py
	$(BIN)/python tests/bench/bench_debug_draw.py
	$(BIN)/python tests/bench/bench_lessons.py

demos: $(VENV)/demos ## play all lessons, and put them on one page: renders/lessons.html
	$(DRAGON) demo -o renders/lessons.html
	@echo "open renders/lessons.html in a browser, or play a lesson here: $(DRAGON) demo spiral"

clean: ## remove what the targets made, but not the gallery
	rm -rf $(VENV) .venv-* renders/*.npz renders/*.html .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
