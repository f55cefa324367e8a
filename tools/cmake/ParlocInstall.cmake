# The public headers as <parloc/...>, for the build tree and the install tree; the install rules; the CMake package.

# ---- public headers --------------------------------------------------------------------------------------------------
# Sources say "common/io/log.h", users say <parloc/io/log.h>: the copies differ from the sources in that alone.
set(PARLOC_PUBLIC_HEADERS
  config/config.h
  config/pose_filters.h
  error.h
  eval/metrics.h
  filter/steps/compute_config.h
  filter/filter_config.h
  filter/filter_group.h
  filter/particle_filter.h
  filter/pose_filter.h
  filter/pose/covariance.h
  filter/pose/pose_guess.h
  filter/steps/step_config.h
  flow/flow_config.h
  flow/flow_filter.h
  flow/flow_filter_config.h
  inputs/open_log.h
  inputs/open_map.h
  inputs/open_truth.h
  inputs/topic_role.h
  io/log.h
  io/log_choice.h
  io/trajectory.h
  live/live_localizer.h
  live/live_slam.h
  localize/health.h
  localize/localizer.h
  localize/localizer_config.h
  localize/modes.h
  map/grid_map.h
  map/map_reader.h
  map/map_yaml.h
  map/segment_map.h
  math/pose.h
  model/beam_counts.h
  model/beam_table.h
  model/continuous_odometry.h
  model/motion_config.h
  model/scan.h
  model/scan_config.h
  model/scan_shape.h
  model/sensor_config.h
  model/trajectory.h
  search/global_search.h
  search/search_config.h
  slam/grid_slam.h
  slam/grid_slam_config.h
  slam/loops/loop_counts.h
  slam/scan_odometry_counts.h
  slam/slam_checkpoint.h
  slam/slam_config.h
  parloc.h)
set(_parloc_include_dir ${PROJECT_BINARY_DIR}/include)
foreach(header ${PARLOC_PUBLIC_HEADERS})
  set(source ${PROJECT_SOURCE_DIR}/common/${header})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(READ ${source} text)
  string(REPLACE "#include \"common/" "#include \"parloc/" text "${text}")
  file(CONFIGURE OUTPUT ${_parloc_include_dir}/parloc/${header} CONTENT "${text}" @ONLY)
endforeach()
target_include_directories(parloc INTERFACE
  $<BUILD_INTERFACE:${_parloc_include_dir}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set_target_properties(parloc PROPERTIES VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

if(NOT PARLOC_INSTALL)
  return()
endif()

# ---- files -----------------------------------------------------------------------------------------------------------
install(TARGETS parloc EXPORT parlocTargets)
if(TARGET parloc_program)
  set_target_properties(parloc_program PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS parloc_program)
endif()
install(DIRECTORY ${_parloc_include_dir}/parloc TYPE INCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/maps ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/parloc)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md TYPE DOC)

# ---- package: find_package(parloc) gives parloc::parloc ----------------------------------------------------------------
include(CMakePackageConfigHelpers)
get_target_property(_parloc_type parloc TYPE)
if(_parloc_type STREQUAL "STATIC_LIBRARY")
  set(PARLOC_IS_STATIC ON)  # whoever links a static library links what it uses, too
else()
  set(PARLOC_IS_STATIC OFF)
endif()
set(_parloc_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/parloc)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/parlocConfig.cmake.in
  ${PROJECT_BINARY_DIR}/parlocConfig.cmake INSTALL_DESTINATION ${_parloc_package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/parlocConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/parlocConfig.cmake ${PROJECT_BINARY_DIR}/parlocConfigVersion.cmake
  DESTINATION ${_parloc_package_dir})
install(EXPORT parlocTargets NAMESPACE parloc:: DESTINATION ${_parloc_package_dir})
