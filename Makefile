# `make` does all its own set-up; the work is in scripts/dev.py. Arguments: make run ARGS="--port 8081"
PYTHON ?= $(firstword $(foreach name,python3 python3.14 python3.13 python3.12 python3.11,$(shell $(name) -c 'import sys; sys.version_info >= (3, 11) and print("$(name)")' 2>/dev/null)) python3)
ARGS ?=

.DEFAULT_GOAL := help
.PHONY: help setup run test lint lock docs soak bench references types clean

help: ## show this
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

run: ## start the robot in its simulated lab and its console on http://127.0.0.1:8080
test: ## everything the project is held to: lint, types, layers, the page's tests, pytest
lint: ## ruff, mypy --strict, the import layers and the words of the prose; biome and tsc on the page
lock: ## renew requirements/*.lock; ARGS=--keep: versions stay where they fit
docs: ## the documentation as a site, with the reference of the packages: build/site/index.html
soak: ## an idle robot for 45 minutes: its memory stays flat; ARGS=MINUTES
bench: ## every benchmark
references: ## measure the modules' reference values again, say what differs; ARGS=--record: on a new recording
types: ## generate the page's types and the clients from the records and REST's description
setup: ## only set up: .venv, packages, page
clean: ## remove everything that can be made again

run test lint lock docs soak bench references types setup clean:
	@$(PYTHON) scripts/dev.py $@ $(ARGS)
