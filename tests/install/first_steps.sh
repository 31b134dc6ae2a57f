#!/usr/bin/env bash
# Does what README.md and docs/ say, in their order, in a tree in which nothing was built: builds, installs, and
# compiles programs in C++, C and Fortran. The commands come from the pages. For a bare Debian, as root: see .ci/full.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
[[ ! -e build ]] || { echo "build/ is there already" >&2 && exit 1; }
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT

# block PAGE TEXT: the first block of the page that contains the text.
block() {
  awk -v text="$2" '
    /^```/ { if (open && index(code, text)) { printf "%s", code; found = 1; exit }
             open = !open; code = ""; next }
    open { code = code $0 "\n" }
    END { exit !found }' "$1" || { echo "$1 has no block with $2" >&2 && return 1; }
}

# follow PAGE TEXT: runs this block here.
follow() {
  local commands
  commands=$(block "$1" "$2")
  printf '\n== %s\n%s\n' "$1" "$commands"
  eval "$commands"
}

# prints TEXT COMMAND...
prints() {
  local output
  output=$("${@:2}")
  printf '%s\n' "$output"
  [[ $output == *"$1"* ]] || { echo "$2 does not print $1" >&2 && exit 1; }
}

follow README.md ./quickstart
follow docs/building.md "cmake --install build"
assur --version
block README.md "int main" >program.cpp
follow docs/building.md "c++ -std=c++20 program.cpp"
prints "handle1 = 2.0782333566916" ./program

{
  printf 'cmake_minimum_required(VERSION 3.25)\nproject(program LANGUAGES CXX)\n'
  printf 'add_executable(program program.cpp)\n'
  block docs/building.md "find_package(assur REQUIRED)"
} >"$stage/CMakeLists.txt"
cp program.cpp "$stage"
cmake -G Ninja -D CMAKE_PREFIX_PATH="$HOME/assur" -S "$stage" -B "$stage/build"
cmake --build "$stage/build"
prints "handle1 = 2.0782333566916" "$stage/build/program"

[[ -n $(type -P gfortran) ]] || apt-get -q install -y --no-install-recommends gfortran
follow docs/c.md "gfortran examples"
prints "rocker 1.363622" ./four_bar_in_c
prints "1.427453 to 2.658826 rad" ./four_bar_in_fortran
rm program program.cpp four_bar_in_c four_bar_in_fortran

block docs/python.md 'assur.run("stewart")' >"$stage/motion.py"
PYTHONPATH=build/python prints 2.0782333566916 python3 "$stage/motion.py"
PYTHONPATH=$HOME/assur/lib/python3/dist-packages prints 2.0782333566916 python3 "$stage/motion.py"
