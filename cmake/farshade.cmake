# farshade_library makes a library whose headers are compiled alone, farshade_test makes a test program.

add_library(farshade_options INTERFACE)
target_compile_options(farshade_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror
  # Without fused multiply-add, so that a mask has the same bits on every machine.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(farshade_options INTERFACE -Wno-restrict)  # false alarms on "literal" + string: GCC PR 105651
endif()
if(FARSHADE_NATIVE)
  target_compile_options(farshade_options INTERFACE -march=native)
endif()
target_include_directories(farshade_options INTERFACE ${PROJECT_SOURCE_DIR})

# farshade_library(NAME HEADERS a.h ... SOURCES a.cpp ... DEPENDS lib ... PRIVATE_DEPENDS lib ... [ALONE a.cpp ...]
#   [COLD])
# The target all_verify_interface_header_sets compiles every header alone. With FARSHADE_UNITY the sources are compiled
# in units of up to 12 files, because vulkan_raii.hpp alone costs 4 s in each unit. ALONE: sources that stay units of
# their own, because names in their anonymous namespaces clash with others or because they have own compiler options.
# COLD: the code runs once per program, so it is optimised less (-O1 takes 60 % of the time of -O3 for CLI11 and glTF).
function(farshade_library name)
  cmake_parse_arguments(ARG "COLD" "" "HEADERS;SOURCES;DEPENDS;PRIVATE_DEPENDS;ALONE" ${ARGN})
  if(ARG_SOURCES)
    add_library(${name} STATIC)
    set(scope PUBLIC)
    target_sources(${name} PRIVATE ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_PRIVATE_DEPENDS})
    set_target_properties(${name} PROPERTIES UNITY_BUILD ${FARSHADE_UNITY} UNITY_BUILD_BATCH_SIZE 12)
    if(ARG_COLD)
      target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    endif()
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  else()
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_sources(${name} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARG_HEADERS})
  target_link_libraries(${name} ${scope} farshade_options ${ARG_DEPENDS})
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()

set(farshade_test_options)
if(FARSHADE_UNITY)  # a whole build: less time for sources whose speed matters to nobody
  list(APPEND farshade_test_options $<$<CONFIG:Release>:-O1>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    list(APPEND farshade_test_options -Wno-array-bounds -Wno-stringop-overflow)  # PR 105651 again, with the precompiled header
  endif()
endif()
if(FARSHADE_FUZZ)  # only fuzz targets need to know which code runs; -O0 compiles in two thirds of the time
  list(APPEND farshade_test_options -fno-sanitize=fuzzer-no-link -O0)
endif()

# farshade_test(NAME SOURCES a_test.cpp ... DEPENDS lib ... [LABEL unit] [TIMEOUT seconds] [ENVIRONMENT NAME=value]
#   [TOGETHER] [SERIAL])
# Makes one gtest program; each of its cases is one CTest test. TOGETHER: the whole program is one CTest test, because
# its cases share what takes long to make. SERIAL: nothing runs beside it, because it compares times. With FARSHADE_UNITY the sources are compiled in units of up to 4 files, so
# names in the anonymous namespaces of one program must differ. Its sources may use the macro FARSHADE_ASSETS, the folder
# of the bundled assets. The target tests_LABEL builds all programs of that label.
function(farshade_test name)
  cmake_parse_arguments(ARG "TOGETHER;SERIAL" "LABEL;TIMEOUT;ENVIRONMENT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 240)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE farshade_options ${ARG_DEPENDS} GTest::gtest_main)
  target_compile_options(${name} PRIVATE ${farshade_test_options})
  if(FARSHADE_UNITY)
    target_precompile_headers(${name} REUSE_FROM test_headers)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  endif()
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
  # Tests do not read the user's configuration files.
  list(APPEND environment ENVIRONMENT_MODIFICATION XDG_CONFIG_HOME=set:${PROJECT_BINARY_DIR}/no-config)
  if(ARG_SERIAL)
    list(APPEND environment RUN_SERIAL ON)
  endif()
  if(ARG_TOGETHER)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} ${environment})
    return()
  endif()
  include(GoogleTest)
  gtest_discover_tests(${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} ${environment})
endfunction()
