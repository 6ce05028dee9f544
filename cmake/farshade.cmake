# farshade_library makes a library whose headers are compiled alone, farshade_test makes a test program,
# farshade_headers precompiles headers that such targets share.

# What a program needs that links a library of this project.
add_library(farshade_sources INTERFACE)
target_include_directories(farshade_sources INTERFACE ${PROJECT_SOURCE_DIR})

# The options of this project's own sources. Libraries link them privately, so a program of another project that links a
# library keeps its own.
add_library(farshade_options INTERFACE)
target_link_libraries(farshade_options INTERFACE farshade_sources)
target_compile_options(farshade_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror
  # Without fused multiply-add, so that a mask has the same bits on every machine.
  -ffp-contract=off
  # Nobody reads errno after a square root or traps. GCC then vectorises square roots. No result changes.
  -fno-math-errno -fno-trapping-math)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms on "literal" + string: GCC PR 105651; with precompiled headers there are more of them.
  target_compile_options(farshade_options INTERFACE -Wno-restrict $<$<BOOL:${FARSHADE_UNITY}>:-Wno-array-bounds>
    $<$<BOOL:${FARSHADE_UNITY}>:-Wno-stringop-overflow>)
endif()
if(FARSHADE_NATIVE)
  target_compile_options(farshade_options INTERFACE -march=native)
endif()

# farshade_headers(NAME HEADERS <a> ... [DEPENDS lib ...] [OPTIONS option ...])
# Precompiles headers of other projects. Only with FARSHADE_UNITY, so that other builds find an include that is missing.
# GCC compiles with the optimisation level of the precompiled header, whatever the target says, so targets that share
# one have the same level.
function(farshade_headers name)
  if(NOT FARSHADE_UNITY)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPENDS;OPTIONS" ${ARGN})
  file(CONFIGURE OUTPUT ${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE farshade_options ${ARG_DEPENDS})
  # Without time stamps, clang takes a header that ccache kept.
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS} $<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>)
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

# farshade_cold(TARGET): its code runs once per program, so it is optimised less: -O1 takes 60 % of the time of -O3.
function(farshade_cold target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(FARSHADE_UNITY)
    target_precompile_headers(${target} REUSE_FROM cold_headers)
  endif()
endfunction()

# farshade_library(NAME HEADERS a.h ... SOURCES a.cpp ... DEPENDS lib ... PRIVATE_DEPENDS lib ... [ALONE a.cpp ...]
#   [COLD] [VULKAN])
# The target all_verify_interface_header_sets compiles every header alone. With FARSHADE_UNITY the target headers_alone
# does so, too, after the precompiled headers. That takes a third of the time (by clang), but does not find a missing include
# of one of those headers. With FARSHADE_UNITY the sources are compiled in units of up to 12 files. ALONE: sources that
# stay units of their own, because names in their anonymous namespaces clash with others or because they have own
# compiler options.
# COLD: farshade_cold. VULKAN: most units include vulkan_raii.hpp, so it is among their precompiled headers.
function(farshade_library name)
  cmake_parse_arguments(ARG "COLD;VULKAN" "" "HEADERS;SOURCES;DEPENDS;PRIVATE_DEPENDS;ALONE" ${ARGN})
  set(precompiled library_headers)
  if(ARG_VULKAN)
    set(precompiled vulkan_headers)
  endif()
  if(ARG_SOURCES)
    add_library(${name} STATIC)
    set(scope PUBLIC)
    target_sources(${name} PRIVATE ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE farshade_options ${ARG_PRIVATE_DEPENDS})
    set_target_properties(${name} PROPERTIES UNITY_BUILD ${FARSHADE_UNITY} UNITY_BUILD_BATCH_SIZE 12)
    if(ARG_COLD)
      farshade_cold(${name})
    elseif(FARSHADE_UNITY)
      target_precompile_headers(${name} REUSE_FROM ${precompiled})
    endif()
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  else()
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_sources(${name} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARG_HEADERS})
  target_link_libraries(${name} ${scope} farshade_sources ${ARG_DEPENDS})
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  if(FARSHADE_UNITY AND BUILD_TESTING)
    farshade_headers_alone(${name} ${precompiled} ${ARG_HEADERS})
  endif()
endfunction()

# farshade_headers_alone(LIBRARY PRECOMPILED a.h ...): part of the target headers_alone.
function(farshade_headers_alone library precompiled)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(sources)
  foreach(header IN LISTS ARGN)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/alone/${header}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include \"${folder}/${header}\"\n")
    list(APPEND sources ${source})
  endforeach()
  add_library(${library}_alone OBJECT EXCLUDE_FROM_ALL ${sources})
  target_link_libraries(${library}_alone PRIVATE farshade_options ${library})
  target_precompile_headers(${library}_alone REUSE_FROM ${precompiled})
  if(NOT TARGET headers_alone)
    add_custom_target(headers_alone)
  endif()
  add_dependencies(headers_alone ${library}_alone)
endfunction()

set(farshade_test_options)
if(FARSHADE_UNITY)  # a whole build: less time for sources whose speed matters to nobody
  list(APPEND farshade_test_options $<$<CONFIG:Release>:-O1>)
endif()
# A process with a sanitizer takes 90 ms to start, so the cases of a unit test program share one.
set(farshade_sanitized OFF)
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=")
  set(farshade_sanitized ON)
endif()
if(FARSHADE_FUZZ)  # only fuzz targets need to know which code runs; -O0 compiles in two thirds of the time
  list(APPEND farshade_test_options -fno-sanitize=fuzzer-no-link -O0)
endif()

# farshade_test(NAME SOURCES a_test.cpp ... DEPENDS lib ... [LABEL unit] [TIMEOUT seconds] [ENVIRONMENT NAME=value]
#   [TOGETHER] [SHARDS count] [SERIAL] [COST seconds] [VULKAN])
# Makes one gtest program; each of its cases is one CTest test. TOGETHER: the whole program is one CTest test, because
# its cases share what takes long to make; so are unit, threads and oracle tests with sanitizers
# (tests/support/run_cases). SHARDS: as many CTest tests, each with every count-th case of the program; their output names
# a case that fails. SERIAL: nothing runs beside it, because it compares times. COST: about how long it takes, because
# CTest starts the longest tests first. VULKAN: as in farshade_library. With FARSHADE_UNITY the sources are compiled in units
# of up to 4 files, so names in the anonymous namespaces of one program must differ. Its sources may use the macro
# FARSHADE_ASSETS, the folder of the bundled assets. The target tests_LABEL builds all programs of that label.
function(farshade_test name)
  cmake_parse_arguments(ARG "TOGETHER;SERIAL;VULKAN" "LABEL;TIMEOUT;ENVIRONMENT;COST;SHARDS" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)  # a test that hangs; a slow and busy machine takes minutes for the longest
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE farshade_options ${ARG_DEPENDS} GTest::gtest_main)
  target_compile_options(${name} PRIVATE ${farshade_test_options})
  if(FARSHADE_UNITY)
    set(precompiled test_headers)
    if(ARG_VULKAN)
      set(precompiled test_vulkan_headers)
    endif()
    target_precompile_headers(${name} REUSE_FROM ${precompiled})
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  endif()
  target_compile_definitions(${name} PRIVATE
    FARSHADE_ASSETS="${PROJECT_SOURCE_DIR}/assets"
    FARSHADE_SOURCE="${PROJECT_SOURCE_DIR}")
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
  if(ARG_COST)
    list(APPEND environment COST ${ARG_COST})
  endif()
  if(ARG_SHARDS)
    foreach(shard RANGE 1 ${ARG_SHARDS})
      math(EXPR index "${shard} - 1")
      add_test(NAME ${name}.${shard}of${ARG_SHARDS} COMMAND ${CMAKE_COMMAND} -E env
        GTEST_TOTAL_SHARDS=${ARG_SHARDS} GTEST_SHARD_INDEX=${index} $<TARGET_FILE:${name}>)
      set_tests_properties(${name}.${shard}of${ARG_SHARDS} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
        ${environment})
    endforeach()
    return()
  endif()
  if(ARG_TOGETHER)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} ${environment})
    return()
  endif()
  if(farshade_sanitized AND ARG_LABEL MATCHES "^(unit|threads|oracle)$")
    add_test(NAME ${name} COMMAND ${PROJECT_SOURCE_DIR}/tests/support/run_cases $<TARGET_FILE:${name}>)
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT 1200 ${environment})
    return()
  endif()
  include(GoogleTest)
  gtest_discover_tests(${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 600
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} ${environment})
endfunction()
