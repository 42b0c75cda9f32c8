# One library a room: every .cc below the folder, include path = repository path.

add_library(atlas_options INTERFACE)
target_include_directories(atlas_options INTERFACE ${PROJECT_SOURCE_DIR})
# Results must not depend on the machine: no fused multiply-add, whatever the SIMD target.
target_compile_options(atlas_options INTERFACE -Wall -Wextra -Wpedantic -Werror -ffp-contract=off)
target_compile_definitions(atlas_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
if(ATLAS_SANITIZE)
  target_compile_options(atlas_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined
                                                 -fno-omit-frame-pointer)
  target_link_options(atlas_options INTERFACE -fsanitize=address,undefined)
endif()
if(ATLAS_TSAN)
  target_compile_options(atlas_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(atlas_options INTERFACE -fsanitize=thread)
endif()

# atlas_unity(OUT NAME SOURCES...): sets OUT to one generated source that includes them all. CMake's own unity builds write
# absolute paths, so that checkouts could not share a compiler cache.
function(atlas_unity out name)
  set(lines)
  foreach(source ${ARGN})
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${source})
    string(APPEND lines "#include \"${path}\"\n")
  endforeach()
  set(unit ${CMAKE_CURRENT_BINARY_DIR}/unity_${name}.cc)
  file(CONFIGURE OUTPUT ${unit} CONTENT "${lines}" @ONLY)
  # What a source keeps to itself is taken for a header's, because the unit includes it.
  set_source_files_properties(${unit} PROPERTIES COMPILE_OPTIONS -Wno-subobject-linkage)
  set(${out} ${unit} PARENT_SCOPE)
endfunction()

# atlas_units(OUT PREFIX ALONE SOURCES...): sets OUT to what is compiled for the sources: eight of a folder at a time are one
# unit, because most of a small source's compilation is instantiating what its headers need. Sources whose path matches
# ALONE stay by themselves, such as those with options of their own; so do those that Highway includes for each SIMD target.
function(atlas_units out prefix alone)
  set(units)
  set(folders)
  foreach(source ${ARGN})
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${source})
    file(STRINGS ${source} simd REGEX "HWY_TARGET_INCLUDE" LIMIT_COUNT 1)
    if(NOT ATLAS_UNITY OR simd OR (alone AND path MATCHES "${alone}"))
      list(APPEND units ${source})
      continue()
    endif()
    get_filename_component(folder ${path} DIRECTORY)
    string(REPLACE "/" "_" folder ${folder})
    list(APPEND folders ${folder})
    list(APPEND of_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder ${folders})
    list(LENGTH of_${folder} count)
    # Units of equal size: ten sources are two units of five.
    math(EXPR parts "(${count} + 7) / 8")
    math(EXPR size "(${count} + ${parts} - 1) / ${parts}")
    foreach(first RANGE 0 ${count} ${size})
      if(first LESS count)
        list(SUBLIST of_${folder} ${first} ${size} members)
        atlas_unity(unit ${prefix}_${folder}_${first} ${members})
        list(APPEND units ${unit})
      endif()
    endforeach()
  endforeach()
  set(${out} ${units} PARENT_SCOPE)
endfunction()

# atlas_room(NAME [LIBRARIES ...] [PRIVATE ...] [EXCLUDE regex] [HOT folders...] [ALONE regex])
# HOT: folders whose loops gain from -O3; everywhere else it only costs compile time. They are an object library of their
# own, since a precompiled header's level of optimisation overrides that of the source which uses it.
function(atlas_room name)
  cmake_parse_arguments(ARG "" "EXCLUDE;ALONE" "LIBRARIES;PRIVATE;HOT" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX ${ARG_EXCLUDE})
  endif()
  if(NOT sources)
    add_library(atlas_${name} INTERFACE)
    target_link_libraries(atlas_${name} INTERFACE atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES})
    return()
  endif()
  set(hot)
  foreach(folder ${ARG_HOT})
    file(GLOB_RECURSE members CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cc)
    list(APPEND hot ${members})
  endforeach()
  if(hot)
    list(REMOVE_ITEM sources ${hot})
    atlas_units(units ${name} "${ARG_ALONE}" ${hot})
    add_library(atlas_${name}_hot OBJECT ${units})
    target_link_libraries(atlas_${name}_hot PRIVATE atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES}
                                                    ${ARG_PRIVATE})
    target_compile_options(atlas_${name}_hot PRIVATE $<$<CONFIG:Release>:-O3>)
    target_precompile_headers(atlas_${name}_hot REUSE_FROM atlas_hot_headers)
  endif()
  atlas_units(units ${name} "${ARG_ALONE}" ${sources})
  add_library(atlas_${name} STATIC ${units} $<$<BOOL:${hot}>:$<TARGET_OBJECTS:atlas_${name}_hot>>)
  target_link_libraries(atlas_${name} PUBLIC atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES}
                                      PRIVATE ${ARG_PRIVATE})
  target_precompile_headers(atlas_${name} REUSE_FROM atlas_headers)
endfunction()

# atlas_trade(ROOM FOLDER [HOT] [LIBRARIES ...] [PRIVATE ...] [EXCLUDE regex] [ALONE regex]): a room's folder as a library of
# its own.
function(atlas_trade room folder)
  cmake_parse_arguments(ARG "HOT" "EXCLUDE;ALONE" "LIBRARIES;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cc)
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX ${ARG_EXCLUDE})
  endif()
  atlas_units(units ${room}_${folder} "${ARG_ALONE}" ${sources})
  add_library(atlas_${room}_${folder} STATIC ${units})
  target_link_libraries(atlas_${room}_${folder} PUBLIC atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES}
                                                PRIVATE ${ARG_PRIVATE})
  if(ARG_HOT)
    target_compile_options(atlas_${room}_${folder} PRIVATE $<$<CONFIG:Release>:-O3>)
    target_precompile_headers(atlas_${room}_${folder} REUSE_FROM atlas_hot_headers)
  else()
    target_precompile_headers(atlas_${room}_${folder} REUSE_FROM atlas_headers)
  endif()
endfunction()

# atlas_test(NAME SOURCES... LIBRARIES ... [ALONE regex]): one GoogleTest executable, registered with CTest.
function(atlas_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT;ALONE" "SOURCES;LIBRARIES" ${ARGN})
  if(NOT "${ARG_SOURCES}" MATCHES "_test")
    return()
  endif()
  atlas_units(units test_${name} "${ARG_ALONE}" ${ARG_SOURCES})
  add_executable(test_${name} ${units})
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest_main)
  target_precompile_headers(test_${name} REUSE_FROM atlas_test_headers)
  add_test(NAME ${name} COMMAND test_${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)
  endif()
  if(ATLAS_SANITIZE OR ATLAS_TSAN)
    math(EXPR ARG_TIMEOUT "4 * ${ARG_TIMEOUT}")
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()

# Two thirds of a compilation is reading standard headers, Eigen, fmt and GoogleTest: they are read once for all rooms,
# once for their hot folders and once for all tests. Headers are still included where they are used.
set(atlas_precompiled
    <Eigen/Dense> <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstring> <deque> <filesystem>
    <fmt/format.h> <fmt/ranges.h> <fstream> <functional> <iostream> <limits> <map> <memory> <mutex> <numeric> <optional>
    <queue> <set> <span> <sstream> <stdexcept> <string> <thread> <tuple> <unordered_map> <unordered_set> <variant>
    <vector>)
foreach(headers atlas_headers atlas_hot_headers atlas_test_headers)
  set(empty ${CMAKE_BINARY_DIR}/${headers}.cc)
  file(CONFIGURE OUTPUT ${empty} CONTENT "// Holds precompiled headers.\n")
  add_library(${headers} STATIC ${empty})
  target_link_libraries(${headers} PRIVATE atlas_options Eigen3::Eigen Threads::Threads fmt::fmt)
  target_precompile_headers(${headers} PRIVATE ${atlas_precompiled})
endforeach()
target_link_libraries(atlas_test_headers PRIVATE GTest::gtest)
target_precompile_headers(atlas_test_headers PRIVATE <gtest/gtest.h>)
target_compile_options(atlas_hot_headers PRIVATE $<$<CONFIG:Release>:-O3>)
