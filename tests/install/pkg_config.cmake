# Builds and runs the two programs of the consumer, and the examples in C and Fortran if there are compilers, with nothing
# but a compiler and pkg-config.
cmake_minimum_required(VERSION 3.25)
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
set(static --static)
if(SHARED)
  set(static "")
endif()

function(build_and_run compiler package source)
  execute_process(COMMAND ${PKG_CONFIG} ${static} --cflags --libs ${package}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  cmake_path(GET source FILENAME name)
  set(program ${OUT}/${name}_pkg_config)
  execute_process(COMMAND ${compiler} ${ARGN} ${source} -o ${program} ${flags} -Wl,-rpath,${PREFIX}/${LIBDIR}
    WORKING_DIRECTORY ${OUT} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${program} ${OUT}/stewart.plan COMMAND_ERROR_IS_FATAL ANY)  # the first one saves it
endfunction()

build_and_run(${COMPILER} assur ${CONSUMER}/use_assur.cpp -std=c++20)
build_and_run(${COMPILER} assur_core ${CONSUMER}/use_assur_core.cpp -std=c++20)
if(C)
  build_and_run(${C} assur ${EXAMPLES}/four_bar.c -std=c99)
  build_and_run(${C} assur_core ${CONSUMER}/in_c/run_plan.c -std=c99)
endif()
if(FORTRAN)
  build_and_run(${FORTRAN} assur ${EXAMPLES}/four_bar.f90)
endif()
