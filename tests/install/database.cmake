# After a move of the tree, the command still finds the database of its installation. The test uses a text file: it is
# refused with status 3, which shows that it was found.
cmake_minimum_required(VERSION 3.25)
file(WRITE ${PREFIX}/${DATADIR}/assur/tuning.db "no database")
execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=ASSUR_DB HOME=${PREFIX} ${PREFIX}/${BINDIR}/assur db info
  OUTPUT_VARIABLE out RESULT_VARIABLE status)
file(REMOVE ${PREFIX}/${DATADIR}/assur/tuning.db)
string(FIND "${out}" "${PREFIX}/${DATADIR}/assur/tuning.db\n  role            installation" found)
if(NOT status EQUAL 3 OR found EQUAL -1)
  message(FATAL_ERROR "status ${status}, the database of the installation is not listed:\n${out}")
endif()
