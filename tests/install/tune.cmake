# ASSUR_TUNE_ON_INSTALL with a budget of a few seconds: runs SCRIPT like cmake --install with a prefix in STAGE.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${STAGE})
set(database ${STAGE}/prefix/${DATADIR}/assur/tuning.db)
function(install_with arguments destination)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env DESTDIR=${destination} ${CMAKE_COMMAND}
    -D CMAKE_INSTALL_PREFIX=${STAGE}/prefix "-DASSUR_TUNE_ARGUMENTS=${arguments}" -P ${SCRIPT}
    ERROR_VARIABLE err COMMAND_ERROR_IS_FATAL ANY)
  set(err "${err}" PARENT_SCOPE)
endfunction()

# A package for other machines holds no samples of this one.
install_with("--budget;10;--quiet" ${STAGE}/package)
file(GLOB_RECURSE found ${STAGE}/*)
if(found)
  message(FATAL_ERROR "installed with DESTDIR: ${found}")
endif()

# An installation does not fail with its tuning.
install_with("--budget;nothing" "")
if(NOT err MATCHES "assur tune failed")
  message(FATAL_ERROR "no warning:\n${err}")
endif()

install_with("--budget;10;--quiet" "")
execute_process(COMMAND ${COMMAND} db check --json --db ${database} OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
string(JSON samples GET "${out}" rows 0 samples)
if(NOT samples GREATER 0)
  message(FATAL_ERROR "nothing was stored:\n${out}")
endif()
