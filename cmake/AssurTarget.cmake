# What all of our own targets share. Nothing here is global: a project that embeds assur keeps its own flags.

# assur_target(TARGET): language level, warnings, floating point, sanitizers.
function(assur_target target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    $<$<BOOL:${ASSUR_WERROR}>:-Werror>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 takes `"text" + string` for overlapping memory (its bug 105651), and more so in precompiled headers: there it
    # forgets what is the system's.
    target_compile_options(${target} PRIVATE -Wno-restrict)
    if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
      target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
    endif()
  endif()
  # A contracted multiplication and addition rounds once instead of twice; where it happens depends on the optimiser.
  # Off, results are the same bits at every optimisation level.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  # Threads are handed down as a budget, never taken by Eigen; its temporaries stay off the heap, so that the steady
  # state allocates nothing. Of its code only what is under the MPL is taken.
  target_compile_definitions(${target} PRIVATE
    EIGEN_DONT_PARALLELIZE EIGEN_STACK_ALLOCATION_LIMIT=1048576 EIGEN_MPL2_ONLY)
  if(ASSUR_SANITIZE)
    target_compile_options(${target} PRIVATE
      -fsanitize=${ASSUR_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${ASSUR_SANITIZE})
  endif()
endfunction()

# Precompiled headers save a third of the time of a build. They hold what never changes here: headers of the standard
# library and of other libraries. A build with ccache does without: ccache keeps nothing that was compiled with them.
# CMAKE_DISABLE_PRECOMPILE_HEADERS=ON, as the preset ci has it, shows whether each file includes what it uses.
if(NOT DEFINED CMAKE_DISABLE_PRECOMPILE_HEADERS AND "${CMAKE_CXX_COMPILER_LAUNCHER} ${CMAKE_CXX_COMPILER}" MATCHES ccache)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(ASSUR_STANDARD_HEADERS
  <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory>
  <numbers> <numeric> <optional> <random> <set> <span> <sstream> <string> <string_view> <tuple> <unordered_map>
  <utility> <variant> <vector>)

# assur_together(TARGET NAME files...): sources of TARGET that are compiled as one file, which saves what they would each
# instantiate again. For code that no step runs through: it may be optimised otherwise. Two of them cannot have helpers
# of one name. CMAKE_UNITY_BUILD=OFF compiles each alone.
function(assur_together target name)
  target_sources(${target} PRIVATE ${ARGN})
  set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${name})
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  if(NOT DEFINED CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  endif()
endfunction()
