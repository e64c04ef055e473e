# SPDX-License-Identifier: Apache-2.0

PYTHON ?= python3
GHDL ?= ghdl
# Debian's ghdl takes this back end when it is installed, else the one it finds.
GHDL_BACKEND ?= llvm
SEED ?= 1
TESTS ?=
JOBS ?= 2
# Samples of mutants may be several: tests have the first one's seed.
TEST_SEED := $(firstword $(SEED))
export PYTHON GHDL GHDL_BACKEND
export QUADSHADE_SEED := $(TEST_SEED)

VENV := .venv/bin/python
PYTEST := $(VENV) -m pytest -n $(JOBS) --dist worksteal --hypothesis-seed=$(TEST_SEED)

# Each unit with its default generics, and the whole core with one linear channel and depth. A screen that is
# large enough for a monitor takes too long; in cells of ECP5 also the core with the shade unit and the board.
# Of Gowin the core alone: Yosys has no model of its block RAM.
WHOLE := raster_core or quadshade_axis or screen_video
MAPPED_TESTS := (default and not ($(WHOLE))) or (raster_core and depth_bits)
LARGE := render_core or board
# Of the board with unknown registers, beside its default: one with a monitor, the smallest.
UNKNOWN_TESTS := test_board and (with_video or single_port)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

.PHONY: help
help: ## list the targets
	@awk -F ':.*## ' '/^##@/ {print "\n" substr($$0, 5)} \
	  /^[a-z_-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

##@ Product

.PHONY: setup
setup: tools .venv/installed ## install what is missing: simulators (apt), a .venv with the pinned packages

.PHONY: demo
demo: setup ## draw the six spheres through the VHDL, check every pixel, write build/demo/*.png
	@$(VENV) -m scripts.demo

.PHONY: report
report: setup ## what accuracy costs, as a page: build/report/index.html; goes on after a kill
	@$(VENV) -m quadshade.trade.page --jobs $(JOBS)

.venv/installed: requirements.txt pyproject.toml | tools
	@echo "setup: installing the pinned Python packages into .venv"
	@$(PYTHON) -m venv .venv
	@$(VENV) -m pip install -q --no-compile --disable-pip-version-check -r requirements.txt
	@$(VENV) -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

##@ Development

.PHONY: test
test: setup ## run every test; T=name, TESTS=folder select, SEED=n sets the seed, WAVES=1 keeps waves
	@$(if $(T)$(TESTS),,$(VENV) -m tests.support.compile_loops)
	@$(PYTEST) $(TESTS) $(if $(T),-k '$(T)')

.PHONY: test-netlist
test-netlist: export QUADSHADE_SIM := icarus
test-netlist: setup ## run the cocotb tests on GHDL's netlist, some with unknown registers or mapped (slow)
	@QUADSHADE_NETLIST=ghdl $(PYTEST) cocotb_tests $(if $(T),-k '$(T)')
	@QUADSHADE_NETLIST=unknown $(PYTEST) cocotb_tests -k '$(or $(T),$(MAPPED_TESTS) or ($(UNKNOWN_TESTS)))'
	@QUADSHADE_NETLIST=ice40 $(PYTEST) cocotb_tests -k '$(or $(T),$(MAPPED_TESTS))'
	@QUADSHADE_NETLIST=ecp5 $(PYTEST) cocotb_tests -k '($(or $(T),$(MAPPED_TESTS))) and not ($(LARGE))'
	@QUADSHADE_NETLIST=gowin $(PYTEST) cocotb_tests/core -k '$(or $(T),$(MAPPED_TESTS))' || test $$? = 5

.PHONY: coverage
coverage: setup ## statements, branches and stimuli that the benches reach; writes docs/reports/coverage.md
	@$(VENV) -m scripts.coverage --jobs $(JOBS)

.PHONY: lint
lint: setup ## check style, file hygiene, generated files and that the RTL analyses and synthesises
	@$(PYTEST) -q tests/test_lint.py

.PHONY: format
format: setup ## format the Python files
	@$(VENV) -m ruff check -q --fix . && $(VENV) -m ruff format -q .

.PHONY: formal
formal: setup ## prove units and core over their netlists; writes docs/reports/formal.md; T=name
	@$(VENV) -m scripts.formal --jobs $(JOBS) $(if $(T),--only '$(T)')

.PHONY: rtl
rtl: setup ## write rtl/generated/ from Python, quadshade.core and docs/reference/ports.md from the RTL
	@$(VENV) -m scripts.generate_vhdl
	@$(VENV) -m scripts.release.fusesoc
	@$(VENV) -m scripts.docs.ports

.PHONY: docs
docs: setup ## build the documentation as a site, with the RTL's timing diagrams: build/docs/
	@$(VENV) -m scripts.docs

.PHONY: readme
readme: setup ## run the demo and write the first picture and the tables of README and pages
	@$(VENV) -m scripts.demo --publish
	@$(VENV) -m scripts.readme

.PHONY: report-image
report-image: setup ## the report, and the README's picture of it
	@$(VENV) -m quadshade.trade.page --jobs $(JOBS) --screenshot docs/images/report.png

.PHONY: tools
tools: ## install what comes from the system (simulators, venv), through apt
	@scripts/install_tools.sh

.PHONY: clean
clean: ## remove everything that was built, but not the .venv
	@rm -rf build .pytest_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +

.PHONY: pictures
pictures: export QUADSHADE_WRITE_PICTURES := 1
pictures: setup ## run every command of README and pages, and write the pictures that they show
	@$(PYTEST) tests/test_documents.py

.PHONY: view-film
view-film: setup ## film quadshade view in Chromium: docs/images/view.gif, view.png
	@$(VENV) -m scripts.view_film

##@ Reports, in docs/reports

.PHONY: throughput
throughput: setup ## measure clocks per pixel in simulation, write docs/reports/throughput.md
	@$(VENV) -m scripts.experiments.throughput

.PHONY: simspeed
simspeed: setup ## measure cycles per second in GHDL and Verilator, write docs/reports/simspeed.md
	@$(VENV) -m scripts.experiments.simulation_speed

.PHONY: boardspeed
boardspeed: setup ## triangles a second, line load of the simulated board; docs/reports/boardspeed.md
	@$(VENV) -m scripts.experiments.board_speed

.PHONY: frametime
frametime: setup ## turning scenes in a frame time, in a board's clocks; docs/reports/frame_time.md; goes on
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.frame_time.report

.PHONY: frametime-vertices
frametime-vertices: setup ## a frame time with vertices and without; docs/reports/frame_time_vertices.md
	@$(VENV) -m scripts.experiments.frame_time.vertices

.PHONY: turnspeed
turnspeed: setup ## processor time of a frame of turn and view, beside VTK; docs/reports/turn_speed.md
	@$(VENV) -m pip install -q --disable-pip-version-check --no-build-isolation -e '.[peer]'
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.turn_speed

.PHONY: hostspeed
hostspeed: setup ## measure the host, planning and fits on one core; docs/reports/hostspeed.md, planspeed.md
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.host_speed
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.plan_speed

.PHONY: helpspeed
helpspeed: setup ## processor time of help and completion, beside an earlier commit; docs/reports/helpspeed.md
	@$(VENV) -m scripts.experiments.help_speed

.PHONY: stability
stability: setup ## compare set-up methods with exact rationals, write docs/reports/stability.md
	@$(VENV) -m scripts.experiments.setup_stability

.PHONY: extremes
extremes: setup ## measure error over triangle size and fraction, write docs/reports/extremes.md
	@$(VENV) -m scripts.experiments.error_extremes

.PHONY: continuity
continuity: setup ## measure Mach bands and fractional stepping, write docs/reports/continuity.md
	@$(VENV) -m scripts.experiments.continuity.report

.PHONY: adapt
adapt: setup ## adaptive pictures beside fixed choices, error against bytes; writes docs/reports/adapt.md
	@$(VENV) -m scripts.experiments.adaptive_vs_fixed

.PHONY: adapt-fits
adapt-fits: setup ## what fits save of an adaptive picture's bytes; writes docs/reports/adapt_fits.md
	@$(VENV) -m scripts.experiments.adaptive_fits

.PHONY: density
density: setup ## mesh density, order, fit and power at the pixel for an error; writes docs/reports/density.md
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.density

.PHONY: shade-table
shade-table: setup ## spheres in every shading against Phong; writes docs/reports/shade.md
	@$(VENV) -m scripts.experiments.shade_table

.PHONY: fits
fits: setup ## fits beside six points: error, jumps, time; writes docs/reports/fits.md
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.fits

.PHONY: mesh-readers
mesh-readers: setup ## readers of mesh files over the tests' cases; writes docs/reports/mesh_readers.md
	@$(VENV) -m scripts.experiments.mesh_readers

.PHONY: edges
edges: setup ## edge maps against the mesh's edges; docs/reports/edges.md, docs/images/styles.png
	@$(VENV) -m scripts.experiments.edges.report

.PHONY: cho
cho: setup ## Cho's tables on a teapot of 896 triangles, 60 views; writes docs/reports/cho.md
	@OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(VENV) -m scripts.experiments.cho.tables

.PHONY: linkbytes
linkbytes: setup ## bytes of a triangle on the line; writes link_bytes.md, link_parts.md, link_vertices.md
	@$(VENV) -m scripts.experiments.link_bytes
	@$(VENV) -m scripts.experiments.link_parts
	@$(VENV) -m scripts.experiments.link_vertices

.PHONY: readback
readback: setup ## bytes on the line of a board's picture, or of its CRC; writes docs/reports/readback.md
	@$(VENV) -m scripts.experiments.read_back

.PHONY: faults
faults: setup ## inject a million faults into the link's frames, write docs/reports/faults.md
	@$(VENV) -m scripts.experiments.link_faults

.PHONY: faults-boards
faults-boards: setup ## kill boards that share pictures on bad lines, write docs/reports/faults_boards.md
	@$(VENV) -m scripts.experiments.pool_faults

.PHONY: scale
scale: setup ## tiles against one screen, and pictures shared by boards, write docs/reports/scale.md
	@$(VENV) -m scripts.experiments.scale

.PHONY: sdram
sdram: setup ## what a picture in SDRAM takes of memory, line and clocks, write docs/reports/sdram.md
	@$(VENV) -m scripts.experiments.sdram_budget

.PHONY: faults-rtl
faults-rtl: setup ## damage the line to a board in RTL, write docs/reports/faults_rtl.md
	@$(VENV) -m scripts.experiments.link_faults_rtl

.PHONY: fuzz-vertices
fuzz-vertices: setup ## vertex packets at the limits and damaged, in model and RTL (minutes); COUNT=300
	@QUADSHADE_FUZZ=$(or $(COUNT),300) \
	  $(PYTEST) tests/test_vertex_fuzz.py cocotb_tests/link/test_vertex_unpacker.py

.PHONY: mutation
mutation: setup ## which changes of the RTL the benches notice (hours); UNIT=, SEED=, COUNT=, ALL=1; goes on
	@nice $(VENV) -m scripts.mutation.rtl --jobs $(JOBS) --seed $(SEED) $(if $(UNIT),--unit $(UNIT)) \
	  $(if $(COUNT),--count $(COUNT)) $(if $(ALL),--all)

.PHONY: mutation-python
mutation-python: setup ## which changes of the host's Python do its tests notice; COUNT=600, SEED=n; goes on
	@nice $(VENV) -m scripts.mutation.python \
	  $(foreach seed,$(SEED),--seed $(seed)) $(if $(COUNT),--count $(COUNT))

.PHONY: screen
screen: setup ## block RAM and area of what stands behind the pixel stream, clock of SEEDS runs (0: none)
	@JOBS=$(JOBS) $(VENV) -m scripts.experiments.screen_area --seeds $(SEEDS)

##@ Hardware

DEVICE ?=
BOARD ?=
SEEDS ?= 5
GENERICS ?=
GENERIC_OPTIONS := $(foreach generic,$(GENERICS),--generic $(generic))

.PHONY: netlist
netlist: setup ## write the core as one Verilog file below build/; GENERICS="stream_width=128 ..."
	@$(VENV) -m scripts.netlist $(GENERIC_OPTIONS)

.PHONY: synth
synth: setup ## clock and area for a DEVICE=ecp5-25k-6 or BOARD=ulx3s-85f; SEEDS=5 GENERICS="..."
	@JOBS=$(JOBS) $(VENV) -m scripts.synth run --seeds $(SEEDS) $(GENERIC_OPTIONS) \
	  $(if $(DEVICE),--device $(DEVICE)) $(if $(BOARD),--board $(BOARD))

.PHONY: limits
limits: setup ## the core beside a lone accumulator on every device of the table; writes synth/resources.json
	@JOBS=$(JOBS) $(VENV) -m scripts.synth limits --seeds $(SEEDS)
	@$(VENV) -m scripts.readme

.PHONY: synth-check
synth-check: setup ## measure the table synth/resources.json again and compare (slow)
	@JOBS=$(JOBS) $(VENV) -m scripts.synth check

.PHONY: bitstream
bitstream: setup ## a board's bitstream in build/bitstream, BOARD=name of synth/boards
	@$(VENV) -m scripts.bitstream build --seeds $(SEEDS) $(if $(BOARD),--board $(BOARD))

.PHONY: bitstreams
bitstreams: setup ## the bitstreams of all boards, for a release (hours)
	@$(VENV) -m scripts.bitstream all --seeds $(SEEDS)

.PHONY: release
release: setup ## RTL, netlists, benches, built bitstreams as an archive in build/release
	@$(VENV) -m scripts.release

.PHONY: clocks
clocks: setup ## find the clock crossings in the boards' netlists; writes docs/reports/clocks.md
	@$(VENV) -m scripts.clocks

.PHONY: program
program: setup ## load that bitstream into the board, with openFPGALoader, fujprog, ecpdap or iceprog
	@$(VENV) -m scripts.bitstream program $(if $(BOARD),--board $(BOARD))
