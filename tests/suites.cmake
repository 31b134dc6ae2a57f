# ctest reads this when it starts: one test for each suite of the GoogleTest program `program`, named FOLDER.SUITE, which
# `emulator` runs ("": none). A process for each case would spend more time on its start than on most cases. ctest must
# not search the output for skipped cases, because it would count a suite with a failed and a skipped case as skipped.
# Suites that run many mechanisms with many strategies. `./quickstart test` leaves them out.
set(long dispatch.Offers simulation.Accuracy simulation.RandomJoints simulation.Strategies structure.Shapes/ManyBodies)
if(NOT EXISTS ${program})
  add_test(${folder}_test_NOT_BUILT ${folder}_test_NOT_BUILT)
  return()
endif()
execute_process(COMMAND ${emulator} ${program} --gtest_list_tests OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\." suites "${list}")
list(TRANSFORM suites STRIP)
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "\\.$" "" name ${folder}.${suite})
  add_test(${name} ${emulator} ${program} --gtest_filter=${suite}*)
  set_tests_properties(${name} PROPERTIES ENVIRONMENT ASSUR_DB=)
  set(labels)
  if(is_of_lib)
    list(APPEND labels lib)
  endif()
  list(FIND long ${name} at)  # ctest knows no IN_LIST
  if(NOT at EQUAL -1)
    list(APPEND labels long)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${labels}")
endforeach()
