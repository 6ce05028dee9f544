# The two ways a target is made here: a library with verified headers, and a program.

add_library(farshade_options INTERFACE)
target_compile_options(farshade_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror
  # No fused multiply-add behind our back: a mask is the same bits on every machine.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(farshade_options INTERFACE -Wno-restrict)  # false alarms on "literal" + string: GCC PR 105651
endif()
if(FARSHADE_NATIVE)
  target_compile_options(farshade_options INTERFACE -march=native)
endif()
target_include_directories(farshade_options INTERFACE ${PROJECT_SOURCE_DIR})

# farshade_library(NAME HEADERS a.h ... SOURCES a.cpp ... DEPENDS lib ... PRIVATE_DEPENDS lib ...)
# Every header is compiled alone by the target all_verify_interface_header_sets.
function(farshade_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS;SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(${name} STATIC)
    set(scope PUBLIC)
    target_sources(${name} PRIVATE ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_PRIVATE_DEPENDS})
  else()
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_sources(${name} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARG_HEADERS})
  target_link_libraries(${name} ${scope} farshade_options ${ARG_DEPENDS})
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()

# farshade_test(NAME SOURCES a_test.cpp ... DEPENDS lib ... [LABEL unit] [TIMEOUT seconds] [ENVIRONMENT NAME=value])
# One gtest program; every case in it is one CTest test. Tests may use FARSHADE_ASSETS (bundled assets).
# The target tests_LABEL builds all programs of that label.
function(farshade_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT;ENVIRONMENT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE farshade_options ${ARG_DEPENDS} GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    FARSHADE_ASSETS="${PROJECT_SOURCE_DIR}/assets"
    FARSHADE_SOURCE="${PROJECT_SOURCE_DIR}"
    FARSHADE_BINARY="${PROJECT_BINARY_DIR}")
  if(NOT TARGET tests_${ARG_LABEL})
    add_custom_target(tests_${ARG_LABEL})
  endif()
  add_dependencies(tests_${ARG_LABEL} ${name})
  if(ARG_ENVIRONMENT)
    set(environment ENVIRONMENT ${ARG_ENVIRONMENT})
  endif()
  include(GoogleTest)
  gtest_discover_tests(${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} ${environment})
endfunction()
