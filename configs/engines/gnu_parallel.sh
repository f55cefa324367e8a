#!/bin/sh
# Computes a sweep with GNU parallel (docs/sweeps.md). Usage: gnu_parallel.sh DIR [OPTION of parallel...]
#   parloc sweep S.yaml --out DIR --engine none        # prepares the folder
#   gnu_parallel.sh DIR --jobs 4                       # or --sshlogin 8/big,4/small: all machines see DIR at the same place
#   parloc sweep S.yaml --out DIR --engine none        # table and page
set -eu
folder=$(cd "${1:?expected the folder of a sweep}" && pwd)
shift
seq "$(wc -l < "$folder/parts.txt")" | parallel --retries 3 "$@" sh "$folder/part.sh" {}
