#!/usr/bin/env bash
# The rules of the layout, read from the sources: tools, tests -> {cpu, cuda} -> common; one-way floors; sizes; twins; headers;
# paths. Usage: structure_test.sh [C++ compiler]
set -euo pipefail

# Python finds a module beside the one that wants it: the studies stay in one folder.
known_large_folders='tools/studies'

cd "$(dirname "$0")/../.."
compiler=${1:-c++}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
violations=$work/violations

# fail <rule>: every line of standard input is a violation of the rule.
fail() { sed "s|^|$1: |" >> "$violations"; }

# includes <folder>...: "file:line: included path" for every #include there.
includes() {
  grep -rnE --include='*.h' --include='*.cpp' --include='*.cu' --include='*.cuh' --include='*.inc' \
    '^[[:space:]]*#[[:space:]]*include' "$@" | sed -E 's/#[[:space:]]*include[[:space:]]*[<"]([^>"]+)[>"].*/ \1/' || true
}

# ---- dependencies: tools, tests -> {cpu, cuda} -> common -----------------------------------------------------------
ours='(common|cpu|cuda|tools|tests)/'
includes common | grep -E " (cpu|cuda|tools|tests)/" | fail "common may include only common" || true
includes cpu | grep -E " (cuda|tools|tests)/" | fail "cpu may include only cpu and common" || true
includes cuda | grep -E " (cpu|tools|tests)/" | fail "cuda may include only cuda and common" || true
includes common | grep -E ' (omp\.h|cuda[a-z_]*\.h|curand.*|cub/.*|thrust/.*|cooperative_groups.*)$' |
  fail "common has no OpenMP and no CUDA runtime" || true
grep -rnE '^[[:space:]]*#[[:space:]]*pragma[[:space:]]+omp' common | fail "common has no OpenMP" || true
includes cpu | grep -E ' (cuda[a-z_]*\.h|cub/.*|thrust/.*)$' | fail "cpu has no CUDA" || true
includes cuda | grep -E ' omp\.h$' | fail "cuda has no OpenMP" || true
grep -rlE --include='*.h' --include='*.cpp' --include='*.cu' '^[[:space:]]*#[[:space:]]*include[[:space:]]*[<"]Eigen/' common cpu cuda tools tests |
  grep -vx common/slam/loops/pose_graph.cpp | fail "Eigen is included in common/slam/loops/pose_graph.cpp alone" || true
includes common cpu cuda tools tests | grep -E ' yaml-cpp/' | grep -v '^common/file/yaml_reader\.cpp:' |
  fail "yaml-cpp is known to one file" || true
# Paths are written from the repository's root, so that this very test can read them.
grep -rnE --include='*.h' --include='*.cpp' --include='*.cu' --include='*.cuh' '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' \
  common cpu cuda tools tests/unit tests/system tests/fuzz |
  grep -vE "include[[:space:]]*\"$ours" | fail "project headers are included by their path from the root" || true

# ---- one-way floors: no folder of common or tools includes one that includes it, over however many others -------------
# A file directly in common (error.h, which all may include, and parloc.h, which none does) or in tools (main.cpp) stands for itself.
includes common tools | grep -E ' (common|tools)/' | sed 's/:[0-9]*://' |
  awk 'function folder(path) { sub("/[^/]*$", "", path); return path }
       { for (k = 1; k <= 2; ++k) if (folder($k) ~ /\//) $k = folder($k); if ($1 != $2) print $1, $2 }' | sort -u |
  tsort 2>&1 > /dev/null | sed 's/^tsort: //; s/^-: input contains a loop:$/:/' | tr '\n' ' ' |
  tr ':' '\n' | grep . | fail "folders include each other in a ring" || true

# ---- sizes ---------------------------------------------------------------------------------------------------------
source_names='\.(h|cpp|cu|cuh|inc|py)$'
find common cpu cuda tools tests -type f | grep -E "$source_names" | tr '\n' '\0' | xargs -0 wc -l | awk '$2 != "total" && $1 > 400 { print $2, "has", $1 }' |
  fail "a file has at most 400 lines" || true
find common tools -type d | while read -r folder; do
  lines=$(find "$folder" -maxdepth 1 -type f | grep -E "$source_names" | tr '\n' '\0' | xargs -0 -r cat | wc -l)
  (( lines <= 2500 )) || echo "$folder has $lines"
done | grep -v "^$known_large_folders " | fail "the files of a folder have at most 2500 lines" || true

# ---- twins ------------------------------------------------------------------------------------------------------------
# Each stage and each class that runs them is there for both backends.
mapfile -t names < <({ basename -a -s .cpp cpu/*.cpp; basename -a -s .cu cuda/*.cu; } | sort -u)
for name in "${names[@]}"; do
  for twin in "cpu/$name.cpp" "cuda/$name.cu"; do
    [[ -s $twin ]] || echo "$twin is missing" | fail "twin files have twin names"
  done
done

# ---- every header compiles alone ------------------------------------------------------------------------------------
# The build shows it of those that their own source includes first.
comes_first() { [[ $(grep -m1 '^#include' "${1%.h}.cpp" 2> /dev/null) == "#include \"$1\"" ]]; }
check_header() {
  printf '#include "%s"\n' "$1" > "$2/$(tr / _ <<< "$1").cpp"
  "$3" -std=c++20 -fsyntax-only -fopenmp -w -I. "$2/$(tr / _ <<< "$1").cpp" > /dev/null 2>&1 || echo "$1"
}
export -f check_header
find common cpu -name '*.h' | sort | while read -r header; do comes_first "$header" || echo "$header"; done |
  xargs -P "$(nproc)" -I{} bash -c 'check_header "$@"' _ {} "$work" "$compiler" |
  fail "a header compiles alone" || true

# ---- no path of the machine that a file was written on ----------------------------------------------------------------
files() {
  { git ls-files --cached --others --exclude-standard 2> /dev/null ||
    find . -type f -not -path './build/*' -not -path './.git/*'; } | while read -r file; do [[ ! -e $file ]] || echo "$file"; done
}
files | tr '\n' '\0' | xargs -0 grep -nIE '(^|[^A-Za-z0-9_.])/(work|root|home)/' 2> /dev/null |
  fail "no file names this machine's paths" || true

# ---- pages that sources refer to exist (links between pages: tools/reference/build) -----------------------------------------------------------------------------------
files | grep -E '\.(md|h|cpp|cu|cmake|txt|sh|py|yaml)$|^(\./)?tools/' | tr '\n' '\0' | xargs -0 grep -oE 'docs/[a-z0-9_]+\.md' -h 2> /dev/null |
  sort -u | while read -r page; do [[ -e $page ]] || echo "$page is missing"; done | fail "pages that are referred to exist"

if [[ -s $violations ]]; then
  cat "$violations"
  echo "$(wc -l < "$violations") violations"
  exit 1
fi
echo "structure: $(find common cpu -name '*.h' | wc -l) headers, $(includes common cpu cuda tools tests | wc -l) includes checked"
