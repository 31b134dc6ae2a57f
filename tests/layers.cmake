# Checks the order of lib/ and of tuner/: each folder includes only itself and folders to its left, so that none of
# lib/ includes db/. Each public header is a layer of its own, to the left of the folder or file that implements it.
# The sources of the core (CORE, relative to lib/) include, directly or indirectly, none of the libraries that the
# core must not use. The CMakeLists.txt of each part lists all its sources. Fast paths name no features.
cmake_minimum_required(VERSION 3.25)
set(foreign "^#include [<\"](nlohmann|muParser|cs\\.h|btf\\.h|klu\\.h|umfpack|dmumps|suitesparse|SQLite|CLI|boost|tinyxml2|asmjit)")
set(findings "")

# check_order(ROOT layers...): appends to `findings`, and sets `files`. Layers are folders, files of ROOT itself, and
# public headers. Files in ROOT itself that are not named include no layer.
macro(check_order root)
  set(layers ${ARGN})
  file(GLOB_RECURSE files RELATIVE ${root} ${root}/*.h ${root}/*.cpp ${root}/*.hpp ${root}/*.in)
  foreach(file IN LISTS files)
    string(REGEX REPLACE "/.*" "" folder ${file})
    list(FIND layers "${folder}" own)  # -1 for files in ROOT itself
    file(STRINGS ${root}/${file} includes REGEX "^#include [<\"]")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^#include [<\"](assur/)?([^/>\"]+).*" "\\2" used "${include}")
      list(FIND layers "${used}" other)
      if(other GREATER own)
        list(APPEND findings "${root}/${file}: ${include} reaches from ${folder} to ${used}")
      endif()
    endforeach()
  endforeach()
endmacro()

check_order(${TUNER} measure mechanisms output sweep pictures check tuning report commands enough_memory.cpp main.cpp)

set(lib_layers version.hpp status.hpp status.cpp machine.hpp parallel backend.hpp strategy.hpp strategy.cpp backends
  report.hpp report.cpp status_text.hpp status_text.cpp number.hpp law.hpp scene.hpp scene joints builder files samples
  mjcf.hpp mjcf structure.hpp equations graph start structure evaluation program executors performance.hpp plan.hpp
  saved_plan.hpp derivatives.hpp dispatch plan modes.hpp modes rows.hpp outputs drivers groups step_settings.hpp motion
  errors jacobian.hpp simulator.hpp motion_range.hpp simulation ensemble.hpp runs tables verification curve.hpp fleet.hpp fleet
  print.hpp print.cpp eigen.hpp assur.hpp assur.h c db)
check_order(${INCLUDE} ${lib_layers})
foreach(file IN LISTS files)
  if(NOT file IN_LIST lib_layers)
    list(APPEND findings "${INCLUDE}/${file}: is not among the layers in tests/layers.cmake")
  endif()
endforeach()
check_order(${LIB} ${lib_layers})

# Paths that take steps in another way ask program/needs.hpp whether they can; they name no features of scenes.
file(GLOB ways RELATIVE ${LIB} ${LIB}/runs/*.cpp ${LIB}/tables/*.cpp ${LIB}/executors/*.cpp ${LIB}/fleet/*.cpp
  ${LIB}/motion/whole_step.cpp ${LIB}/motion/together.cpp ${LIB}/groups/coded_*.cpp ${LIB}/program/together_step.cpp
  ${LIB}/dispatch/together_rules.cpp)
foreach(file IN LISTS ways)
  file(STRINGS ${LIB}/${file} named
    REGEX "(callbacks|bounds|checks|gears|controlled)\\.empty\\(\\)|Law::Function|for_each_function|limits\\.seconds")
  foreach(line IN LISTS named)
    if(NOT line MATCHES "needs\\.add\\(")
      list(APPEND findings "lib/${file}: names a feature instead of asking program/needs.hpp: ${line}")
    endif()
  endforeach()
endforeach()

# Each shared library has its own list of threads that wait for an atomic number, so that waiting and waking must lie in
# one library.
file(GLOB_RECURSE waiting ${LIB}/*.?pp ${INCLUDE}/*.hpp ${TUNER}/*.?pp)
list(FILTER waiting EXCLUDE REGEX "parallel/waiting\\.cpp$")
foreach(file IN LISTS waiting)
  file(STRINGS ${file} found REGEX "notify_(all|one)\\(|[a-z_]\\.wait\\(|std::(barrier|latch|counting_semaphore|binary_semaphore)")
  if(found)
    list(APPEND findings "${file}: waits or wakes beside lib/parallel/waiting.cpp: ${found}")
  endif()
endforeach()

foreach(part IN ITEMS lib tuner db python bench tests)
  file(GLOB lists ${SOURCE}/${part}/CMakeLists.txt ${SOURCE}/${part}/peers/CMakeLists.txt)
  set(listed "")
  foreach(list IN LISTS lists)
    file(READ ${list} text)
    string(APPEND listed "${text}")
  endforeach()
  file(GLOB_RECURSE sources RELATIVE ${SOURCE}/${part} ${SOURCE}/${part}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "^(install|fuzz)/")  # programs of their own, fuzzers by target
  foreach(file IN LISTS sources)
    set(name ${file})
    if(part MATCHES "bench|tests")  # paths there are relative to the folder of a program; some programs have one file
      string(REGEX REPLACE "(.*/)?(.*)\\.cpp" "\\2(.cpp)?" name ${file})
    endif()
    if(NOT listed MATCHES "[ \n(/]${name}[ \n)]")
      list(APPEND findings "${part}/${file}: is not listed in ${part}/CMakeLists.txt")
    endif()
  endforeach()
endforeach()

set(open ${CORE})
set(seen "")
while(open)
  list(POP_FRONT open file)
  if(file IN_LIST seen OR NOT EXISTS ${LIB}/${file})
    continue()
  endif()
  list(APPEND seen ${file})
  file(STRINGS ${LIB}/${file} includes REGEX "^#include ")
  foreach(include IN LISTS includes)
    if(include MATCHES "${foreign}")
      list(APPEND findings "lib/${file}: ${include} is not for the core")
    elseif(include MATCHES "^#include \"(.*)\"")
      list(APPEND open ${CMAKE_MATCH_1})
    endif()
  endforeach()
endwhile()

list(LENGTH files count)
list(LENGTH seen core_count)
if(count EQUAL 0 OR core_count EQUAL 0)
  message(FATAL_ERROR "no files found in ${LIB}")
elseif(NOT ways)
  message(FATAL_ERROR "no fast paths found in ${LIB}")
elseif(findings)
  list(JOIN findings "\n" text)
  message(FATAL_ERROR "${text}")
endif()
message(STATUS "${count} files in lib/ keep their order, ${core_count} make the core")
