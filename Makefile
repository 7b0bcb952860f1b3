# Two commands on a fresh machine: `make render` installs, simulates and films; `make test`
# installs and tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
DRAGON := $(BIN)/pymunk-dragon
export PIP_DISABLE_PIP_VERSION_CHECK := 1

# As many jobs as there are cores. Lines appear whole, so jobs draw no progress bars over each
# other.
MAKEFLAGS += --jobs=$(shell getconf _NPROCESSORS_ONLN)
MAKEFLAGS += $(if $(filter output-sync,$(.FEATURES)),--output-sync=line)

.DEFAULT_GOAL := help
.PHONY: help render figures map screenshot report demos docs
.PHONY: test test-all test-versions fuzz lint bench engines findings clean FORCE
# A film or a run that was interrupted is not a film or a run.
.DELETE_ON_ERROR:

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' Makefile | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 16

# The virtual environment, in four steps: the core, the extras of the program, pdoc, and what
# tests and lint need.
$(VENV)/core: pyproject.toml
	@echo "setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/pip install --quiet --editable .
	@touch $@

# Installs the extras of pyproject.toml; the package, which other jobs may be running, is there
# already.
$(VENV)/extras: $(VENV)/core
	@$(BIN)/pip install --quiet "pymunk-dragon[all]" && touch $@

# Prints the dependency groups $(1) of pyproject.toml.
print_groups = import tomllib; \
	groups = tomllib.load(open('pyproject.toml', 'rb'))['dependency-groups']; \
	print(*(line for name in '$(1)'.split() for line in groups[name]), sep='\n')
# Installs them, as `pip install --group` does from pip 25.1 on.
install_groups = $(BIN)/python -c "$(print_groups)" > $@.txt \
	&& $(BIN)/pip install --quiet --requirement $@.txt && mv $@.txt $@

$(VENV)/documentation: $(VENV)/extras
	@$(call install_groups,docs)

$(VENV)/tools: $(VENV)/documentation
	@$(call install_groups,test lint)

# An environment with the lowest versions that pyproject.toml allows of what the program depends
# on, and one with the newest; the tools of the tests are new in both.
.venv-lowest/tools: RESOLUTION := lowest-direct
.venv-highest/tools: RESOLUTION := highest
.venv-lowest/tools .venv-highest/tools: pyproject.toml
	@echo "setting up $(@D)"
	@$(PYTHON) -m venv --clear $(@D)
	@$(@D)/bin/pip install --quiet uv
	@$(@D)/bin/uv pip install --quiet --python $(@D) --resolution $(RESOLUTION) --editable ".[all]"
	@$(@D)/bin/uv pip install --quiet --python $(@D) --group dev
	@touch $@

# What makes each file: the arguments of pymunk-dragon. A file is made again when its line here,
# the code that makes it or the run that it shows has changed.
march.npz := simulate
first_contact.npz := simulate --from 400 --frame-interval 0.02
unguided.npz := simulate --guide none
u-turn.npz := simulate --curve u-turn --from -100 --until 100
report.npz := simulate --from 400 --until 416 --contacts report

march.gif := render renders/march.npz --size 390 --camera cut
first_contact.gif := render renders/first_contact.npz --from 405.4 --camera head
guides.gif := render renders/march.npz renders/unguided.npz --until 12.5 --size 330 \
	--title "Dancers keep the dragon on its path"
exact.gif := render renders/first_contact.npz --exact --from 409 --camera head --span 5 \
	--size 330 --title "The engine and the exact model"
marks.png := render renders/first_contact.npz --camera head --size 660 \
	--velocities --grid --forces --contacts --title "First contact: benches 0 and 8" \
	--caption "Arrows end where the handles would be in half a second; discs are forces in \
	the joints; cells are darker where a bench is filed."
u-turn.gif := render renders/u-turn.npz --from -6 --until 36 --span 15
march.html := render renders/march.npz
report.html := report renders/report.npz
lessons.html := demo

# Figures of a march, of a run, and of the answers of studies; those with axes are also written as
# SVG.
STILLS := outer-loop inward collision
CHARTS := spiral grid trajectories velocities gap speeds order
CHARTS_OF_RUN := drift forces
STUDIES := min-pitch u-turn max-speed
$(foreach name,$(STILLS) $(CHARTS),$(eval figures/$(name).png := figure $(name)))
$(foreach name,$(CHARTS_OF_RUN),$(eval figures/$(name).png := figure $(name) renders/march.npz))
$(foreach name,$(STUDIES),$(eval figures/$(name).png := study $(name)))

# The first contacts of 26 x 21 dragons, and of those by which borders are known to a sixteenth of
# the distance: 2,326 in place of the 128,721 of a grid as fine.
MAP := figures/contact-map.png
$(MAP) := sweep --axis pitch=0.50:0.60:0.004 --axis width=0.25:0.35:0.005 --refine 4 --resume

PICTURES := march.gif first_contact.gif guides.gif exact.gif marks.png u-turn.gif
FIGURES := $(patsubst %,figures/%.png,$(STILLS) $(CHARTS) $(CHARTS_OF_RUN) $(STUDIES))
RUNS := march.npz first_contact.npz unguided.npz u-turn.npz report.npz
PAGES := march.html report.html lessons.html

# A file with the arguments, renewed only when they change.
COMMANDS := renders/.commands
FILES := $(PICTURES) $(FIGURES) $(RUNS) $(PAGES) $(MAP)
$(FILES:%=$(COMMANDS)/%): $(COMMANDS)/%: FORCE
	@mkdir -p $(@D); echo '$($*)' | cmp -s - $@ || echo '$($*)' > $@

# The endings of all files that are made with the first one.
endings = $(suffix $@)
$(patsubst %,renders/figures/%.png,$(CHARTS) $(CHARTS_OF_RUN)): endings = .png,.svg
# A run that is made for a figure has not the endings of the figure.
$(RUNS:%=renders/%): endings = .npz

$(FILES:%=renders/%): renders/%: $(COMMANDS)/% | $(VENV)/core
	@echo "making $@"
	@$(BIN)/python renders/gallery.py $@ $(endings) $($*)

# The run that each one shows, what else it needs, and the code that made it the last time.
renders/march.gif renders/march.html renders/guides.gif: renders/march.npz
$(CHARTS_OF_RUN:%=renders/figures/%.png): renders/march.npz
renders/first_contact.gif renders/exact.gif renders/marks.png: renders/first_contact.npz
renders/guides.gif: renders/unguided.npz
renders/u-turn.gif: renders/u-turn.npz
renders/report.html: renders/report.npz
renders/lessons.html: $(wildcard $(addprefix pymunk_dragon/lessons/,*.py *.js zh.toml))
renders/lessons.html: $(wildcard pymunk_dragon/lessons/_framework/assets/*)
renders/lessons.html: $(wildcard pymunk_dragon/web/assets/*)
$(FIGURES:%=renders/%) renders/$(MAP) renders/report.html renders/lessons.html: | $(VENV)/extras
-include $(FILES:%=$(COMMANDS)/%.d)

render: ## simulate the dragon in Pymunk, film it, and write a page that plays it
render: renders/march.gif renders/march.html $(PICTURES:%=renders/%)
	@echo "open renders/march.gif first, then renders/march.html in a browser;" \
	  "\`make figures\` draws the charts"

figures: ## draw the paper's figures and the studies' answers: renders/figures/
figures: $(FIGURES:%=renders/%)
	@echo "open renders/figures/gap.png first"

map: renders/$(MAP) ## compute the first contacts of 2,326 dragons in minutes, and draw a map
	@echo "open renders/$(MAP)"

report: renders/report.html ## simulate past the first contact and report on it: renders/report.html
	@echo "open renders/report.html in a browser"

demos: renders/lessons.html ## run all lessons, and put them on one page: renders/lessons.html
	@echo "open renders/lessons.html in a browser, or play a lesson here: $(DRAGON) demo spiral"

SCREENSHOT = $(BIN)/python tests/bench/screenshot.py

screenshot: ## pictures of the pages, in Chromium: player.png, lesson*.png, live.gif in renders/
screenshot: renders/march.html renders/lessons.html $(VENV)/tools
	$(SCREENSHOT) renders/march.html "#t=409.8&follow=head" renders/player.png
	$(SCREENSHOT) renders/lessons.html "#spiral" renders/lessons.png
	$(SCREENSHOT) renders/lessons.html "#chain" renders/lesson-chain.png
	$(SCREENSHOT) renders/lessons.html "#sat" renders/lesson-sat.png walls=4
	$(SCREENSHOT) renders/lessons.html "#near-miss" renders/lesson-near-miss.png \
	  time=412.6 coordinates=3
	$(SCREENSHOT) renders/lessons.html "#speed-limit" renders/lesson-speed-limit.png \
	  way_of_the_head=14.6 speed_of_the_head=1.3
	$(BIN)/python tests/bench/film_live.py renders/live.gif

# The arguments that make each picture and its run, for the gallery.
MADE = $(foreach file,$(RUNS) $(PICTURES) $(FIGURES) $(MAP),'$(file)=$($(file))')

docs: $(PAGES:%=renders/%) $(VENV)/documentation ## build the documentation: renders/docs/
	@echo "making renders/docs"
	@$(BIN)/python renders/documentation.py renders/docs $(MADE)
	@echo "open renders/docs/index.html in a browser"

# The tools for the scripts of the pages, and Python in WebAssembly for tests, of exact versions; on
# a machine without node, neither is checked.
NODE := $(shell command -v npm 2>/dev/null)
SCRIPT_TOOLS := tests/node/node_modules/.installed

$(SCRIPT_TOOLS): tests/node/package.json
	@npm install --prefix $(<D) --no-audit --no-fund --loglevel error > /dev/null && touch $@

# Options for pytest, as in `make test PYTEST="-k sat"`.
PYTEST ?=
RUN_TESTS = $(BIN)/python -m pytest -q --numprocesses auto --dist worksteal

test: $(VENV)/tools ## run the quick tests, which are most of them
	$(RUN_TESTS) -m "not thorough" $(PYTEST)

test-versions: ## run the quick tests with the lowest and the newest dependencies
test-versions: .venv-lowest/tools .venv-highest/tools
	$(RUN_TESTS:$(VENV)/%=.venv-lowest/%) -m "not thorough" $(PYTEST)
	$(RUN_TESTS:$(VENV)/%=.venv-highest/%) -m "not thorough" $(PYTEST)

test-all: ## run all tests: whole runs, every lesson, the commands in texts, pages in a browser
test-all: $(VENV)/tools $(if $(NODE),$(SCRIPT_TOOLS))
	$(RUN_TESTS) $(PYTEST)

# Cases of each kind that `make fuzz` runs, at most 3,000 of wrong arguments.
CASES ?= 5000
# Words in the names of the kinds, all by default, as in KIND="command or csv" or KIND=arguments.
KIND ?=
FUZZED = no_case_fails$(if $(KIND), and ($(KIND)))

fuzz: $(VENV)/tools ## run CASES random cases of command lines, files and wrong arguments  [5000]
	FUZZ_CASES=$(CASES) $(BIN)/python -m pytest -q -s tests/fuzz -k '$(FUZZED)'

NO_NODE := @echo "no node: the scripts of pages are not checked"

lint: ## style, types, which package imports which, and which texts have no translation
lint: $(VENV)/tools $(if $(NODE),$(SCRIPT_TOOLS))
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python tests/translations.py
	! LC_ALL=C.UTF-8 grep -rnE '.{101}' pymunk_dragon renders/templates --include=*.html --include=*.js \
	  --include=*.css --include=*.j2 --include=*.jinja2
	$(if $(NODE),npm run --prefix tests/node --silent lint,$(NO_NODE))

bench: $(VENV)/tools ## measure the figures that README and the documentation quote
	$(BIN)/python tests/bench/bench.py
	$(BIN)/python tests/bench/order.py
	$(BIN)/python tests/bench/bench_live.py pyodide page

# The engines of the benchmark, of exact versions; on a machine without node, those for JavaScript
# are left out.
$(VENV)/engines: $(VENV)/extras
	@$(call install_groups,engines)

NODE_ENGINES := tests/bench/node/node_modules/.installed

$(NODE_ENGINES): tests/bench/node/package.json
	@npm install --prefix $(<D) --no-audit --no-fund --loglevel error > /dev/null && touch $@

engines: ## compare physics engines by the dragon, and film four of them: renders/engines.gif
engines: $(VENV)/engines $(if $(NODE),$(NODE_ENGINES))
	$(BIN)/python tests/bench/engines.py
	$(BIN)/python tests/bench/film_engines.py renders/engines.gif

findings: ## run the scripts about surprises in the libraries, with the packages that each one names
	@for script in findings/*.sh; do \
	  echo "$$script"; PATH="$(abspath $(BIN)):$$PATH" bash "$$script" || \
	  { echo "$$script failed"; failed=1; }; \
	done; test -z "$$failed"

clean: ## remove what the targets made, but not the gallery
	rm -rf $(VENV) .venv-* renders/*.npz renders/*.html renders/docs renders/.commands renders/.new
	rm -rf tests/node/node_modules tests/bench/node/node_modules
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
