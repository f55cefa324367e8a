#!/usr/bin/env bash
# What a step and its maps take from the C maths library: sqrt, fma, floor, rint and nextafter, which are exact
# everywhere; nothing else, since sin, exp and their like differ between machines (docs/determinism.md).
# Usage: symbols_test.sh <build folder>
set -euo pipefail
build=${1:?usage: symbols_test.sh <build folder>}

libm=$("${CXX:-c++}" -print-file-name=libm.so.6)
[[ -e $libm ]] || { echo "skipped: no libm.so.6 (not glibc)"; exit 77; }
symbols_of_libm=$(nm -D --defined-only "$libm" | awk '{print $3}' | sed 's/@.*//' | sort -u)

objects=$build/CMakeFiles/parloc.dir
mapfile -t step_path < <(find "$objects"/common/{math,map,model,filter,flow,search,localize,slam} "$objects"/cpu \
  -name '*.o' | sort)
(( ${#step_path[@]} > 0 )) || { echo "no object files under $objects: build first"; exit 1; }

failed=0
for object in "${step_path[@]}"; do
  imported=$(nm -u "$object" | awk '{print $2}' | sed 's/@.*//' | sort -u)
  forbidden=$(comm -12 <(echo "$imported") <(echo "$symbols_of_libm") | grep -vE '^(sqrt|fma|floor|rint|nextafter)[fl]?$' || true)
  if [[ -n $forbidden ]]; then
    echo "${object#"$objects"/} imports from libm: $(tr '\n' ' ' <<< "$forbidden")"
    failed=1
  fi
done
echo "${#step_path[@]} object files, $(wc -w <<< "$symbols_of_libm") functions in libm"
exit $failed
