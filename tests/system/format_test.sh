#!/usr/bin/env bash
# The sources are formatted as clang-format 14 does it (other versions differ in small things, and are not asked).
set -euo pipefail
version=$(clang-format --version 2> /dev/null | grep -oE 'version [0-9]+' || true)
if [[ $version != "version 14" ]]; then
  echo "needs clang-format 14, found: ${version:-none}"
  exit 77
fi
tools/format
