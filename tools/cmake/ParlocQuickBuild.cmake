# The program from nothing in half the time: a folder of common is compiled as one, those of tools several folders at
# once, so that what they include is read once; and in Release only the stages (cpu) are optimised to the last: what -O1
# leaves elsewhere is not felt. Off by default: with it a source that forgets an include compiles, and one that changes
# compiles others again. The asan preset has it, which is its test: two names alike in the unnamed namespaces of a folder
# do not compile.
function(_parloc_build_quickly target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  target_compile_options(${target} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1>
    # Both are false reports of gcc: on what -O1 does not see through, and on a source that another includes.
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized;-Wno-subobject-linkage>")
endfunction()

_parloc_build_quickly(parloc)
set_target_properties(parloc PROPERTIES UNITY_BUILD_MODE GROUP)
get_target_property(_parloc_sources parloc SOURCES)
foreach(source IN LISTS _parloc_sources)
  if(source MATCHES "/cpu/[^/]*$")
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>)
  elseif(source MATCHES "/common/([a-z]+)/")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${CMAKE_MATCH_1})
  endif()
endforeach()
if(PARLOC_TOOLS)
  _parloc_build_quickly(parloc_tools)
  _parloc_build_quickly(parloc_program)
endif()
