# make demo and make test are all a newcomer needs; both create .venv first when it is missing.
PYTHON ?= python3
BIN := .venv/bin
# where the shell forbids Python to keep what it compiled, every start of a command would take seconds more
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo serve pictures docs test types suite bench clean

setup: .venv/ready

.venv/ready: pyproject.toml studies/pyproject.toml requirements.lock
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || { \
	  echo "Creating .venv failed: Debian and Ubuntu need 'apt install python3-venv'."; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	# Rota with what it runs on first: its loops are compiled while the tools for tests and pages are installed
	$(BIN)/uv pip install --quiet --python $(BIN)/python --constraints requirements.lock --editable . --editable studies
	@$(BIN)/rota compile patrol >.venv/compile.log 2>&1 &
	$(BIN)/uv pip install --quiet --python $(BIN)/python --requirements requirements.lock
	@touch $@

demo: setup
	@mkdir -p out
	$(BIN)/rota plan examples/harbour-copters.yaml --effort quick -o out/harbour.rota.json
	$(BIN)/rota check out/harbour.rota.json
	$(BIN)/rota draw out/harbour.rota.json -o out/harbour.png
	@echo "The plan: out/harbour.rota.json   its picture: out/harbour.png"

# the page
serve: setup
	$(BIN)/rota serve

# the README's pictures
pictures: demo
	$(BIN)/rota draw out/harbour.rota.json -o docs/harbour-copters.png
	$(BIN)/rota animate out/harbour.rota.json -o docs/harbour.gif
	$(BIN)/rota plan examples/harbour.yaml --effort quick -o out/at-once.rota.json
	$(BIN)/rota draw out/at-once.rota.json -o docs/harbour.png
	$(BIN)/rota rehearse out/at-once.rota.json --failures-per-hour 0.01 --speed-noise 2% -o docs/rehearsal.png
	$(BIN)/rota plan examples/port-relief.yaml -o out/port-relief.rota.json
	for name in farm warehouse-relief; do $(BIN)/rota plan examples/$$name.yaml --effort quick -o out/$$name.rota.json; done
	for name in farm port-relief warehouse-relief; do \
	  $(BIN)/rota animate out/$$name.rota.json --seconds 9 --fps 6 -o docs/$$name.gif; \
	  $(BIN)/rota draw out/$$name.rota.json -o docs/$$name.png; done
	$(BIN)/rota plan examples/coast.yaml -o out/coast.rota.json
	$(BIN)/rota draw out/coast.rota.json -o docs/coast.png
	$(BIN)/rota plan examples/swarm-port.yaml -o out/swarm-port.rota.json
	$(BIN)/rota draw out/swarm-port.rota.json -o docs/swarm-port.png
	$(BIN)/rota plan examples/swarm-importance.yaml -o out/swarm-importance.rota.json
	$(BIN)/rota draw out/swarm-importance.rota.json -o docs/swarm-importance.png
	$(BIN)/rota plan examples/swarm-charging.yaml -o out/swarm-charging.rota.json
	$(BIN)/rota draw out/swarm-charging.rota.json -o docs/swarm-charging.png
	$(BIN)/rota plan examples/bounce-monitor.yaml -o out/bounce-monitor.rota.json
	$(BIN)/rota draw out/bounce-monitor.rota.json --cells -o docs/bounce-monitor.png
	$(BIN)/python -m docs.page_pictures

# the pages of docs/ as HTML; a warning is an error
docs: setup
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -b html docs docs/_build

test: setup
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	@$(MAKE) --no-print-directory --jobs 2 types suite

types: setup
	$(BIN)/mypy

suite: .venv/read
	$(BIN)/python -m pytest --numprocesses auto --dist worksteal -m "not slow and not ros"

# a new clone reads its tests once before, or each process would rewrite the asserts of all of them
.venv/read: .venv/ready
	-@$(BIN)/python -m pytest --collect-only >/dev/null 2>&1
	@touch $@

bench: setup
	$(BIN)/python -m benchmarks

clean:
	rm -rf .venv out docs/_build
