# One library a room: every .cc below the folder, include path = repository path.

add_library(atlas_options INTERFACE)
target_include_directories(atlas_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(atlas_options INTERFACE -Wall -Wextra -Wpedantic -Werror)
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
  set(${out} ${unit} PARENT_SCOPE)
endfunction()

# atlas_room(NAME [LIBRARIES ...] [PRIVATE ...] [EXCLUDE regex])
function(atlas_room name)
  cmake_parse_arguments(ARG "" "EXCLUDE" "LIBRARIES;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX ${ARG_EXCLUDE})
  endif()
  if(NOT sources)
    add_library(atlas_${name} INTERFACE)
    target_link_libraries(atlas_${name} INTERFACE atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES})
    return()
  endif()
  add_library(atlas_${name} STATIC ${sources})
  target_link_libraries(atlas_${name} PUBLIC atlas_options Eigen3::Eigen Threads::Threads ${ARG_LIBRARIES}
                                      PRIVATE ${ARG_PRIVATE})
  target_precompile_headers(atlas_${name} REUSE_FROM atlas_headers)
endfunction()

# atlas_hot(FOLDERS ...): sources whose loops gain from -O3; everywhere else it only costs compile time.
function(atlas_hot)
  foreach(folder ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cc)
    set_property(SOURCE ${sources} APPEND PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>)
  endforeach()
endfunction()

# atlas_test(NAME SOURCES... LIBRARIES ...): one GoogleTest executable, registered with CTest.
function(atlas_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LIBRARIES" ${ARGN})
  if(NOT "${ARG_SOURCES}" MATCHES "_test")
    return()
  endif()
  add_executable(test_${name} ${ARG_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest_main)
  target_precompile_headers(test_${name} REUSE_FROM atlas_test_headers)
  add_test(NAME ${name} COMMAND test_${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()

# Two thirds of a compilation is reading standard headers, Eigen, fmt and GoogleTest: they are read once for all rooms and
# once for all tests. Headers are still included where they are used.
set(atlas_precompiled
    <Eigen/Dense> <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstring> <deque> <filesystem>
    <fmt/format.h> <fmt/ranges.h> <fstream> <functional> <iostream> <limits> <map> <memory> <mutex> <numeric> <optional>
    <queue> <set> <span> <sstream> <stdexcept> <string> <thread> <tuple> <unordered_map> <unordered_set> <variant>
    <vector>)
foreach(headers atlas_headers atlas_test_headers)
  set(empty ${CMAKE_BINARY_DIR}/${headers}.cc)
  file(CONFIGURE OUTPUT ${empty} CONTENT "// Holds precompiled headers.\n")
  add_library(${headers} STATIC ${empty})
  target_link_libraries(${headers} PRIVATE atlas_options Eigen3::Eigen Threads::Threads fmt::fmt)
  target_precompile_headers(${headers} PRIVATE ${atlas_precompiled})
endforeach()
target_link_libraries(atlas_test_headers PRIVATE GTest::gtest)
target_precompile_headers(atlas_test_headers PRIVATE <gtest/gtest.h>)
