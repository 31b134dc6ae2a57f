# Writes the first C++ program of README to OUT.
cmake_minimum_required(VERSION 3.25)
file(READ ${README} text)
string(REGEX MATCH "\n```cpp\n([^`]+)```" block "${text}")
if(NOT block)
  message(FATAL_ERROR "no C++ program in ${README}")
endif()
file(WRITE ${OUT} "${CMAKE_MATCH_1}")
