# ASSUR_TUNE_ON_INSTALL with a budget of a few seconds: runs SCRIPT like cmake --install with the prefix below DESTDIR.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${STAGE})
execute_process(COMMAND ${CMAKE_COMMAND} -E env DESTDIR=${STAGE} ${CMAKE_COMMAND} -D CMAKE_INSTALL_PREFIX=/prefix
  "-DASSUR_TUNE_ARGUMENTS=--budget;10;--quiet" -P ${SCRIPT} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${COMMAND} db check --json --db ${STAGE}/prefix/${DATADIR}/assur/tuning.db
  OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
string(JSON samples GET "${out}" rows 0 samples)
if(NOT samples GREATER 0)
  message(FATAL_ERROR "nothing was stored:\n${out}")
endif()
