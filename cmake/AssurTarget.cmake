# The common properties of all targets of assur. No flag is global: a project that embeds assur keeps its own flags.

# assur_target(TARGET): language level, warnings, floating point, sanitizers.
function(assur_target target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    $<$<BOOL:${ASSUR_WERROR}>:-Werror>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 wrongly warns of overlapping memory in `"text" + string` (GCC bug 105651), and does so more often with
    # precompiled headers, in which it treats system headers like others.
    target_compile_options(${target} PRIVATE -Wno-restrict)
    if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
      target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
    endif()
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    # With these, Clang means more by -Wconversion and -Wshadow than GCC does.
    target_compile_options(${target} PRIVATE -Wno-sign-conversion -Wno-shadow)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_SYSTEM_PROCESSOR MATCHES "^arm")
    target_compile_options(${target} PRIVATE -Wno-psabi)  # notes of calls that differ from those of GCC 6
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # GCC looks for unused memory from 128 MB on, which most files here reach with their headers. From 512 MB on, the
    # six measured files take 8 % less time together, and the compiler up to a fifth more memory.
    target_compile_options(${target} PRIVATE --param=ggc-min-heapsize=524288)
  endif()
  # Contraction of a multiplication and an addition rounds once instead of twice, wherever the optimiser chooses.
  # Without contraction, results have the same bits at every optimisation level.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  # Eigen must not start threads, because callers pass a budget of threads. Its temporaries stay off the heap, so that
  # the steady state allocates nothing. Only its code under the MPL is used.
  target_compile_definitions(${target} PRIVATE
    EIGEN_DONT_PARALLELIZE EIGEN_STACK_ALLOCATION_LIMIT=1048576 EIGEN_MPL2_ONLY)
  if(ASSUR_SANITIZE)
    # Checks of each pointer cost a quarter of the time to compile; the address sanitizer sees most of what they see.
    target_compile_options(${target} PRIVATE
      -fsanitize=${ASSUR_SANITIZE} -fno-sanitize=null,alignment,object-size,vptr -fno-sanitize-recover=all
      -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${ASSUR_SANITIZE})
    # Files with and without the address sanitizer must agree on how Eigen allocates memory.
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
endfunction()

# assur_library(TARGET): a target that a shared library, such as the Python module, may contain. Functions that no one
# replaces at run time may be inlined nevertheless. Not for executables, which share precompiled headers without this.
function(assur_library target)
  assur_target(${target})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  endif()
endfunction()

# Precompiled headers save a third of the time of a build. They contain headers of the standard library and of other
# libraries, which never change here. A build with ccache does not use them, because ccache does not cache files that
# were compiled with precompiled headers. CMAKE_DISABLE_PRECOMPILE_HEADERS=ON (as in the preset `ci`) tests that each
# file includes the headers that it uses.
if(NOT DEFINED CMAKE_DISABLE_PRECOMPILE_HEADERS AND "${CMAKE_CXX_COMPILER_LAUNCHER} ${CMAKE_CXX_COMPILER}" MATCHES ccache)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(ASSUR_STANDARD_HEADERS
  <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory>
  <numbers> <numeric> <optional> <random> <set> <span> <sstream> <string> <string_view> <tuple> <unordered_map>
  <utility> <variant> <vector>)

# assur_together(TARGET NAME files...): compiles these sources of TARGET as one file, so that templates are instantiated
# once for all of them. Code that steps run may be optimised differently: measure it. Two files of a group
# cannot have helpers with the same name. CMAKE_UNITY_BUILD=OFF compiles each file alone.
function(assur_together target name)
  target_sources(${target} PRIVATE ${ARGN})
  set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${name})
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  if(NOT DEFINED CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  endif()
endfunction()
