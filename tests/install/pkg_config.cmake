# Builds and runs the two programs of the consumer, with nothing but a compiler and pkg-config.
cmake_minimum_required(VERSION 3.25)
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
set(static --static)
if(SHARED)
  set(static "")
endif()

foreach(package IN ITEMS assur assur_core)
  execute_process(COMMAND ${PKG_CONFIG} ${static} --cflags --libs ${package}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(program ${OUT}/${package}_pkg_config)
  execute_process(COMMAND ${COMPILER} -std=c++20 ${CONSUMER}/use_${package}.cpp -o ${program}
    ${flags} -Wl,-rpath,${PREFIX}/${LIBDIR} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${program} ${OUT}/stewart.plan COMMAND_ERROR_IS_FATAL ANY)  # assur saves it
endforeach()
