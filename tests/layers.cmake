# Checks the order of lib/ and of tuner/: each folder includes only itself and folders to its left, so that none of lib/
# includes db/. The sources of the core (CORE, relative to lib/) include, directly or indirectly, none of the libraries
# that the core must not use. lib/CMakeLists.txt lists all sources.
cmake_minimum_required(VERSION 3.25)
set(foreign "^#include [<\"](nlohmann|muParser|cs\\.h|btf\\.h|klu\\.h|umfpack|dmumps|suitesparse|SQLite|CLI|boost|tinyxml2|asmjit)")
set(findings "")

# check_order(ROOT folders...): appends to `findings`, and sets `files`. Files in ROOT itself include no folder, unless
# they are named among the folders.
macro(check_order root)
  set(layers ${ARGN})
  file(GLOB_RECURSE files RELATIVE ${root} ${root}/*.cpp ${root}/*.hpp ${root}/*.in)
  foreach(file IN LISTS files)
    string(REGEX REPLACE "/.*" "" folder ${file})
    list(FIND layers "${folder}" own)  # -1 for files in ROOT itself
    file(STRINGS ${root}/${file} includes REGEX "^#include \"[a-z_]+/")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^#include \"([a-z_]+)/.*" "\\1" used "${include}")
      list(FIND layers "${used}" other)
      if(other GREATER own)
        list(APPEND findings "${root}/${file}: ${include} reaches from ${folder} to ${used}")
      endif()
    endforeach()
  endforeach()
endmacro()

check_order(${TUNER} measure output sweep pictures check tuning report commands enough_memory.cpp main.cpp)
check_order(${LIB} parallel backends scene mjcf structure equations planning modes signals group program execute path
            errors simulation side_by_side verification fleet c db)

file(READ ${LIB}/CMakeLists.txt listed)
foreach(file IN LISTS files)
  if(file MATCHES "\\.cpp$" AND NOT listed MATCHES "[ \n(]${file}[ \n)]")
    list(APPEND findings "lib/${file}: is not listed in lib/CMakeLists.txt")
  endif()
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
elseif(findings)
  list(JOIN findings "\n" text)
  message(FATAL_ERROR "${text}")
endif()
message(STATUS "${count} files in lib/ keep their order, ${core_count} make the core")
