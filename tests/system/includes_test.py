#!/usr/bin/env python3
"""Every source includes the standard headers of what it uses: itself, or through headers of this project. What comes
along with another standard header does so in one version of the library and not in the next."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Names behind std:: by header. Functions that have namesakes elsewhere (std::remove of <cstdio>) are left out.
NAMES = {
    "algorithm": """adjacent_find all_of any_of binary_search clamp copy copy_backward copy_if copy_n count count_if equal
        equal_range fill fill_n find find_first_of find_if find_if_not for_each generate generate_n includes is_permutation
        is_sorted lexicographical_compare lower_bound make_heap max max_element merge min min_element minmax minmax_element
        mismatch none_of nth_element partial_sort partition pop_heap push_heap remove_if replace replace_if reverse rotate
        sample set_difference set_intersection set_union shuffle sort sort_heap stable_partition stable_sort transform unique
        upper_bound""",
    "array": "array to_array",
    "atomic": "atomic atomic_ref memory_order_acquire memory_order_relaxed memory_order_release",
    "bit": "bit_cast bit_ceil bit_floor bit_width countl_zero countr_zero endian has_single_bit popcount rotl rotr",
    "cctype": "isalnum isalpha isdigit isspace isxdigit tolower toupper",
    "charconv": "chars_format from_chars from_chars_result to_chars",
    "chrono": "chrono",
    "cmath": """acos asin atan atan2 cbrt ceil copysign cos erf erfc exp exp2 expm1 fabs floor fma fmod frexp hypot isfinite
        isinf isnan ldexp lerp llround log log10 log1p log2 lround modf nearbyint nextafter pow remainder rint round signbit
        sin sqrt tan trunc""",
    "condition_variable": "condition_variable",
    "cstdint": """int8_t int16_t int32_t int64_t intmax_t intptr_t uint8_t uint16_t uint32_t uint64_t uintmax_t
        uintptr_t""",
    "cstdio": "FILE fclose fflush fgets fopen fprintf fputs fread fwrite printf puts snprintf sscanf",
    "cstdlib": "abort aligned_alloc atof atoi exit free getenv malloc strtod strtof strtol strtoll strtoul strtoull system",
    "cstring": "memchr memcmp memcpy memmove memset strchr strcmp strerror strlen strncmp strrchr strstr",
    "deque": "deque",
    "exception": "current_exception exception_ptr rethrow_exception set_terminate terminate",
    "filesystem": "filesystem",
    "fstream": "fstream ifstream ofstream",
    "functional": "bind cref equal_to function greater hash invoke less minus multiplies plus ref reference_wrapper",
    "iomanip": "quoted setfill setprecision setw",
    "iostream": "cerr cin clog cout",
    "istream": "istream",
    "iterator": "advance back_inserter distance inserter istream_iterator istreambuf_iterator make_move_iterator",
    "limits": "numeric_limits",
    "map": "map multimap",
    "memory": "make_shared make_unique shared_ptr unique_ptr weak_ptr",
    "mutex": "call_once lock_guard mutex once_flag recursive_mutex scoped_lock unique_lock",
    "new": "align_val_t bad_alloc nothrow nothrow_t",
    "numbers": "numbers",
    "numeric": "accumulate exclusive_scan gcd inclusive_scan inner_product iota lcm midpoint partial_sum reduce",
    "optional": "make_optional nullopt optional",
    "ostream": "endl flush ostream",
    "random": """bernoulli_distribution discrete_distribution mt19937 mt19937_64 normal_distribution random_device
        uniform_int_distribution uniform_real_distribution""",
    "regex": "regex regex_match regex_replace regex_search smatch sregex_iterator",
    "set": "multiset set",
    "span": "span",
    "sstream": "istringstream ostringstream stringstream",
    "stdexcept": "domain_error invalid_argument length_error logic_error out_of_range runtime_error",
    "string": "getline stod stoi string to_string",
    "string_view": "string_view",
    "system_error": "errc error_code system_error",
    "thread": "jthread this_thread thread",
    "tuple": "forward_as_tuple make_tuple tie tuple",
    "type_traits": """conditional_t decay_t enable_if_t false_type invoke_result_t is_base_of_v is_convertible_v
        is_floating_point_v is_integral_v is_same_v is_trivially_copyable_v remove_cvref_t remove_reference_t true_type
        underlying_type_t""",
    "unordered_map": "unordered_map",
    "unordered_set": "unordered_set",
    "utility": "declval exchange forward in_place index_sequence make_index_sequence make_pair move pair swap",
    "variant": "get_if holds_alternative monostate variant visit",
    "vector": "vector",
}
# What the standard says comes with another header.
COMES_WITH = {"istream": ["iostream"], "ostream": ["iostream", "fstream", "sstream"], "string_view": ["string"]}
HEADER_OF = {name: header for header, names in NAMES.items() for name in names.split()}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"]+)[>"].*$', re.M)
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"', re.S)
USE = re.compile(r"\bstd::(?:ranges::)?(\w+)")


def main():
    texts = {}
    for folder in ("common", "cpu", "cuda", "tools", "tests"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".h", ".cpp", ".cu", ".cuh"):
                texts[path.relative_to(ROOT).as_posix()] = path.read_text(encoding="utf-8")
    includes = {file: set(INCLUDE.findall(text)) for file, text in texts.items()}

    def reached(file, seen):
        if file not in seen:
            seen.add(file)
            for name in includes.get(file, ()):
                reached(name, seen)
        return seen

    missing = 0
    for file, text in texts.items():
        have = reached(file, set())
        uses = {}
        for name in USE.findall(NOT_CODE.sub("", INCLUDE.sub("", text))):
            if name in HEADER_OF:
                uses.setdefault(HEADER_OF[name], name)
        for header, name in sorted(uses.items()):
            if header not in have and not have.intersection(COMES_WITH.get(header, ())):
                print(f"{file} uses std::{name} without <{header}>")
                missing += 1
    print(f"includes: {len(texts)} files, {len(HEADER_OF)} names, {missing} headers missing")
    return 1 if missing or not texts else 0


if __name__ == "__main__":
    sys.exit(main())
