#!/usr/bin/env bash
# The Python of the repository passes ruff, by the rules of ruff.toml.
set -euo pipefail
if ! command -v ruff > /dev/null; then
  echo "Skipped: needs ruff (pip install ruff)"
  exit 77
fi
ruff check .
